"use strict";
(() => {
  const all = (selector, within = document) => [...within.querySelectorAll(selector)];
  const one = (selector, within = document) => within.querySelector(selector);

  // The address: #place, or #place?name=value, in which filter and explorer keep what was chosen.
  const address = () => {
    const hash = location.hash.slice(1), end = hash.indexOf("?");
    let place = end < 0 ? hash : hash.slice(0, end);
    try { place = decodeURIComponent(place); } catch { /* typed by hand: taken as it is */ }
    return { place, query: new URLSearchParams(end < 0 ? "" : hash.slice(end + 1)) };
  };
  const keep = (place, values) => {
    const query = new URLSearchParams(Object.entries(values).filter(([, value]) => value !== ""));
    const text = query.toString();
    history.replaceState(null, "", `#${place}${text ? `?${text}` : ""}`);
  };
  window.pageAddress = { read: address, keep };

  // What is folded opens when an address leads into it.
  const unfold = (target) => {
    for (let node = target; node; node = node.parentElement) if (node.tagName === "DETAILS") node.open = true;
  };
  const follow = () => {
    const { place } = address();
    const target = place && document.getElementById(place);
    if (!target) return;
    if (target.closest(".verdict, .claim")) one(".filter")?.dispatchEvent(new CustomEvent("clear", { detail: target }));
    unfold(target);
    const table = one(":scope > .fold", target);
    if (table && target.id.startsWith("table-")) table.open = true;
    target.scrollIntoView();
  };

  // Verdicts by word and text.
  const filter = () => {
    const form = one(".filter");
    if (!form) return;
    const rows = all(".verdict");
    const texts = new Map(rows.map((row) => [row, `${one(".says", row.closest(".claim")).textContent} ${row.textContent}`.toLowerCase()]));
    const apply = (remember) => {
      const words = all("[name=word]:checked", form).map((box) => box.value);
      const close = Boolean(one("[name=close]:checked", form));
      const text = form.elements.text.value.trim().toLowerCase();
      let shown = 0;
      for (const row of rows) {
        const fits = (!words.length || words.includes(row.dataset.word)) && (!close || row.dataset.close)
          && text.split(/\s+/).every((part) => texts.get(row).includes(part));
        row.hidden = !fits;
        shown += fits;
      }
      for (const claim of all(".claim")) claim.hidden = all(".verdict", claim).every((row) => row.hidden);
      one("output", form).textContent = shown === rows.length ? "" : `${shown} of ${rows.length}`;
      one(".none").hidden = shown > 0;
      if (remember) keep("verdicts", { word: words.join(","), close: close ? "yes" : "", text: form.elements.text.value.trim() });
    };
    const restore = () => {
      const { place, query } = address();
      if (place !== "verdicts") return;
      const words = (query.get("word") || "").split(",");
      for (const box of all("[name=word]", form)) box.checked = words.includes(box.value);
      if (form.elements.close) form.elements.close.checked = query.get("close") === "yes";
      form.elements.text.value = query.get("text") || "";
      apply(false);
    };
    form.hidden = false;
    form.addEventListener("input", () => apply(true));
    form.addEventListener("submit", (event) => event.preventDefault());
    form.addEventListener("clear", (event) => {
      if (!event.detail.hidden && !event.detail.closest("[hidden]")) return;
      form.reset();
      apply(false);
    });
    form.elements.unfold.addEventListener("click", (event) => {
      const open = event.target.dataset.open !== "yes";
      for (const claim of all(".claim")) claim.open = open;
      event.target.dataset.open = open ? "yes" : "";
      event.target.textContent = open ? "Fold all" : "Unfold all";
    });
    window.addEventListener("hashchange", restore);
    restore();
  };

  // Only what scrolls takes the focus.
  const regions = () => {
    for (const region of all(".wide[tabindex], pre[tabindex]")) {
      const scrolls = region.scrollWidth > region.clientWidth + 1;
      region.tabIndex = scrolls ? 0 : -1;
      if (!scrolls) region.removeAttribute("tabindex");
      else region.setAttribute("tabindex", "0");
    }
  };

  // A drawing that is shown smaller than it was made opens at its own size, to be panned; without script its link
  // leads to the file.
  const enlarge = () => {
    let dialog;
    const open = (picture) => {
      dialog?.remove();
      dialog = document.createElement("dialog");
      dialog.className = "enlarged";
      dialog.setAttribute("aria-label", picture.alt.split(". ")[0]);
      dialog.innerHTML = '<form method="dialog"><button type="button" data-by="0.8" aria-label="Smaller">−</button>'
        + '<button type="button" data-by="1.25" aria-label="Larger">+</button><button>Close</button></form>'
        + '<div class="pan" tabindex="0" role="region" aria-label="Drawing, scrolls"></div>';
      const shown = new Image();
      shown.src = picture.currentSrc || picture.src;
      shown.alt = picture.alt;
      let width = Number(picture.getAttribute("width"));
      const size = (by) => {
        width = Math.min(4000, Math.max(300, width * by));
        shown.style.width = `${width}px`;
      };
      size(1);
      one(".pan", dialog).append(shown);
      for (const button of all("[data-by]", dialog)) button.addEventListener("click", () => size(Number(button.dataset.by)));
      dialog.addEventListener("close", () => picture.closest("a").focus());
      document.body.append(dialog);
      dialog.showModal();
    };
    document.addEventListener("click", (event) => {
      const picture = event.target.closest(".drawing a")?.querySelector("img");
      if (!picture || event.ctrlKey || event.metaKey || event.shiftKey) return;
      if (picture.clientWidth >= 0.8 * Number(picture.getAttribute("width"))) return;
      event.preventDefault();
      open(picture);
    });
  };

  // The entry of the contents that is being read.
  const contents = () => {
    const details = one(".contents details");
    if (details && matchMedia("(max-width: 67.99rem)").matches) details.open = false;
    for (const link of all(".contents li a")) {
      link.addEventListener("click", () => {
        if (matchMedia("(max-width: 67.99rem)").matches) details.open = false;
      });
    }
    const links = new Map(all(".contents li a").map((link) => [link.hash.slice(1), link]));
    const seen = new Set();
    const watch = new IntersectionObserver((entries) => {
      for (const entry of entries) entry.isIntersecting ? seen.add(entry.target.id) : seen.delete(entry.target.id);
      const current = [...links.keys()].filter((name) => seen.has(name)).pop();
      const nav = one(".contents"), entry = links.get(current);
      if (entry && nav.scrollHeight > nav.clientHeight) {
        const [box, own] = [nav.getBoundingClientRect(), entry.getBoundingClientRect()];
        if (own.top < box.top + 40 || own.bottom > box.bottom - 40) nav.scrollTop += own.top - box.top - box.height / 3;
      }
      for (const [name, link] of links) name === current ? link.setAttribute("aria-current", "true") : link.removeAttribute("aria-current");
    }, { rootMargin: "-5% 0px -75% 0px" });
    for (const name of links.keys()) {
      const target = document.getElementById(name);
      if (target) watch.observe(target);
    }
  };

  // What publishing wrote beside the page: when, by which commit; and the other pages.
  const published = () => {
    const run = window.RUN;
    if (!run) return;
    const told = {
      made: run.made,
      commit: run.commit,
      digest: run.digest,
      versions: run.versions && Object.entries(run.versions).map((pair) => pair.join(" ")).join(", "),
    };
    for (const [name, text] of Object.entries(told)) {
      const place = one(`[data-run=${name}]`);
      if (!place || !text) continue;
      place.hidden = false;
      one("dd", place).textContent = text;
    }
    const cited = one("[data-run=cited]");
    if (cited) cited.textContent = `, commit ${(run.commit || "unknown").slice(0, 12)}, ${run.made.slice(0, 10)}`;
  };
  const others = () => {
    const place = one("#others");
    if (!place || !window.REPORTS) return;
    for (const report of window.REPORTS) {
      if (report.place === document.body.dataset.place) continue;
      const link = document.createElement("a");
      link.href = `../../${report.place}/index.html`;
      link.textContent = report.title;
      place.append(" · ", link);
    }
  };

  document.addEventListener("DOMContentLoaded", () => {
    filter();
    contents();
    regions();
    enlarge();
    published();
    others();
    follow();
    document.documentElement.dataset.ready = "yes";
  });
  window.addEventListener("resize", regions);
  window.addEventListener("hashchange", follow);
  document.addEventListener("toggle", regions, true);
  window.addEventListener("beforeprint", () => {
    for (const picture of all("img[loading=lazy]")) picture.loading = "eager";
    for (const claim of all(".claim:not([open])")) {
      claim.open = true;
      window.addEventListener("afterprint", () => { claim.open = false; }, { once: true });
    }
  });
})();
