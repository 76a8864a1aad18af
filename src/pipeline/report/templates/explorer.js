(() => {
  const place = document.getElementById("explore");
  if (!place) return;
  const WIDTH = 900, HEIGHT = 190, LEFT = 62, RIGHT = 12, TOP = 14, BOTTOM = 30;
  const SVG = "http://www.w3.org/2000/svg";
  // Marks differ in colour and dash, so that one shows through another; groups differ in width.
  const DASHES = ["", "9 5", "4 3", "1.5 4", "12 4 2 4", "16 5", "7 3 1.5 3", "3 6"];
  const WIDTHS = [2.2, 1.1, 3.2];
  const node = (name, attributes = {}, ...children) => {
    const made = document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) key in made ? (made[key] = value) : made.setAttribute(key, value);
    made.append(...children);
    return made;
  };
  const draw = (name, attributes = {}, text = "") => {
    const made = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    if (text) made.textContent = text;
    return made;
  };
  const look = (trace) => `stroke: var(--t${trace.mark % 8}); stroke-width: ${WIDTHS[trace.order % 3]}; stroke-dasharray: ${DASHES[trace.mark % 8] || "none"}`;
  const shownNumber = (value) => (value === null || Number.isNaN(value) ? "–"
    : String(Number(value.toPrecision(4))).replace("-", "−"));

  let traces = [], state = null, panels = [], readout = null, hair = null;

  // The value of a trace at a time, by straight lines; none outside of it.
  const at = (trace, quantity, time) => {
    const times = trace.time, values = trace.quantities[quantity];
    if (!values || time < times[0] || time > times[times.length - 1]) return null;
    let low = 0, high = times.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      times[middle] <= time ? (low = middle) : (high = middle);
    }
    const span = times[high] - times[low];
    return span ? values[low] + ((values[high] - values[low]) * (time - times[low])) / span : values[high];
  };
  const reference = () => traces.find((trace) => trace.name === state.reference);
  // What is drawn of a trace: times in view and values, less those of the reference where one is chosen.
  const points = (trace, quantity) => {
    const base = reference(), values = trace.quantities[quantity];
    const from = state.from, to = state.to;
    const times = trace.time.filter((time) => time >= from && time <= to);
    for (const edge of [from, to]) if (at(trace, quantity, edge) !== null) times.push(edge);
    const wanted = [...new Set(times)].sort((a, b) => a - b);
    return wanted.map((time) => {
      const own = at(trace, quantity, time), theirs = base ? at(base, quantity, time) : 0;
      return [time, own === null || theirs === null ? null : own - theirs];
    }).filter(([, value]) => value !== null && values);
  };
  const chosen = () => traces.filter((trace) => state.charges.includes(trace.name));
  const end = () => Math.max(...chosen().map((trace) => trace.time[trace.time.length - 1]), 1);
  const unitOfTime = () => (state.to - state.from > 3 * 3600 ? [3600, "h"] : state.to - state.from > 600 ? [60, "min"] : [1, "s"]);
  const ticks = (low, high, most) => {
    const rough = (high - low) / most || 1, power = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map((factor) => factor * power).find((size) => size >= rough);
    const found = [];
    for (let value = Math.ceil(low / step) * step; value <= high + step * 1e-9; value += step) found.push(Number(value.toPrecision(10)));
    return found;
  };

  const remember = () => {
    const initial = state.from === 0 && state.to === end();
    window.pageAddress.keep("explorer", {
      quantities: state.quantities.join("|"), charges: state.charges.join("|"), reference: state.reference,
      from: initial ? "" : String(Number(state.from.toPrecision(6))), to: initial ? "" : String(Number(state.to.toPrecision(6))),
    });
  };
  const zoom = (from, to) => {
    const whole = end(), span = Math.min(Math.max(to - from, whole * 1e-4), whole);
    state.from = Math.min(Math.max(from, 0), whole - span);
    state.to = state.from + span;
    render();
    remember();
  };

  const timeOf = (event, svg) => {
    const box = svg.getBoundingClientRect();
    const x = ((event.clientX - box.left) / box.width) * WIDTH;
    const part = Math.min(Math.max((x - LEFT) / (WIDTH - LEFT - RIGHT), 0), 1);
    return state.from + part * (state.to - state.from);
  };
  const across = (time) => LEFT + ((time - state.from) / (state.to - state.from)) * (WIDTH - LEFT - RIGHT);

  const hover = (time) => {
    hair = time;
    for (const { svg } of panels) {
      const line = svg.querySelector(".hair");
      line.setAttribute("visibility", time === null ? "hidden" : "visible");
      if (time !== null) for (const side of ["x1", "x2"]) line.setAttribute(side, across(time));
    }
    readout.replaceChildren();
    if (time === null) return;
    const [factor, unit] = unitOfTime(), base = reference();
    const head = node("tr", {}, node("th", { scope: "col" }, `at ${shownNumber(time / factor)} ${unit}`),
      ...state.quantities.map((name) => node("th", { scope: "col", className: "n" }, base ? `Δ ${name}` : name)));
    const rows = chosen().map((trace) => node("tr", {}, node("th", { scope: "row" }, swatch(trace), ` ${trace.title}`),
      ...state.quantities.map((name) => {
        const own = at(trace, name, time), theirs = base ? at(base, name, time) : 0;
        return node("td", { className: "n" }, shownNumber(own === null || theirs === null ? null : own - theirs));
      })));
    readout.append(node("table", {}, node("thead", {}, head), node("tbody", {}, ...rows)));
  };

  const panel = (quantity, last) => {
    const svg = draw("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, tabindex: "0", role: "img" });
    const curves = chosen().map((trace) => [trace, points(trace, quantity)]).filter(([, found]) => found.length > 1);
    const values = curves.flatMap(([, found]) => found.map(([, value]) => value));
    let low = Math.min(...values), high = Math.max(...values);
    if (!values.length) [low, high] = [0, 1];
    const slack = (high - low) * 0.06 || Math.abs(high) * 0.05 || 1;
    [low, high] = [low - slack, high + slack];
    const up = (value) => HEIGHT - BOTTOM - ((value - low) / (high - low)) * (HEIGHT - TOP - BOTTOM);
    const [factor, unit] = unitOfTime();
    for (const value of ticks(low, high, 5)) {
      svg.append(draw("line", { class: "grid", x1: LEFT, x2: WIDTH - RIGHT, y1: up(value), y2: up(value) }),
        draw("text", { x: LEFT - 6, y: up(value) + 4, "text-anchor": "end" }, shownNumber(value)));
    }
    for (const value of ticks(state.from / factor, state.to / factor, 9)) {
      const x = across(value * factor);
      svg.append(draw("line", { class: "grid", x1: x, x2: x, y1: TOP, y2: HEIGHT - BOTTOM }),
        draw("text", { x, y: HEIGHT - BOTTOM + 15, "text-anchor": "middle" }, shownNumber(value)));
    }
    svg.append(draw("rect", { class: "frame", x: LEFT, y: TOP, width: WIDTH - LEFT - RIGHT, height: HEIGHT - TOP - BOTTOM }));
    for (const [trace, found] of curves) {
      const path = found.map(([time, value], place) => `${place ? "L" : "M"}${across(time).toFixed(1)} ${up(value).toFixed(1)}`).join("");
      svg.append(draw("path", { class: "curve", d: path, style: look(trace) }));
    }
    const name = `${reference() ? "Difference in " : ""}${quantity}${reference() ? `, less ${reference().title}` : ""}`;
    svg.append(draw("text", { x: LEFT, y: 10, style: "font-weight: 600" }, name));
    if (last) svg.append(draw("text", { x: WIDTH - RIGHT, y: HEIGHT - 2, "text-anchor": "end" }, `Time [${unit}]`));
    svg.append(draw("line", { class: "hair", y1: TOP, y2: HEIGHT - BOTTOM, visibility: "hidden" }),
      draw("rect", { class: "band", y: TOP, height: HEIGHT - TOP - BOTTOM, visibility: "hidden" }));
    svg.setAttribute("aria-label", `${name} of ${chosen().map((trace) => trace.title).join("; ")}, from ${shownNumber(state.from / factor)} to ${shownNumber(state.to / factor)} ${unit}`);
    listen(svg);
    return { svg, quantity };
  };

  const listen = (svg) => {
    let begun = null;
    const band = svg.querySelector(".band");
    svg.addEventListener("pointerdown", (event) => {
      if (event.button) return;
      begun = timeOf(event, svg);
      svg.setPointerCapture(event.pointerId);
    });
    svg.addEventListener("pointermove", (event) => {
      const time = timeOf(event, svg);
      hover(time);
      if (begun === null) return;
      const [from, to] = [Math.min(begun, time), Math.max(begun, time)];
      band.setAttribute("visibility", "visible");
      band.setAttribute("x", across(from));
      band.setAttribute("width", Math.max(across(to) - across(from), 0));
    });
    svg.addEventListener("pointerup", (event) => {
      if (begun === null) return;
      const time = timeOf(event, svg), [from, to] = [Math.min(begun, time), Math.max(begun, time)];
      begun = null;
      band.setAttribute("visibility", "hidden");
      if (across(to) - across(from) > 6) zoom(from, to);
    });
    svg.addEventListener("pointerleave", () => { if (begun === null) hover(null); });
    svg.addEventListener("dblclick", () => zoom(0, end()));
    svg.addEventListener("wheel", (event) => {
      if (!event.ctrlKey && document.activeElement !== svg) return;
      event.preventDefault();
      const centre = timeOf(event, svg), by = event.deltaY > 0 ? 1.25 : 0.8;
      zoom(centre - (centre - state.from) * by, centre + (state.to - centre) * by);
      again(svg);
    }, { passive: false });
    svg.addEventListener("keydown", (event) => {
      const span = state.to - state.from, middle = hair ?? (state.from + state.to) / 2;
      const keys = {
        ArrowLeft: () => (event.shiftKey ? zoom(state.from - span / 5, state.to - span / 5) : hover(Math.max(middle - span / 50, state.from))),
        ArrowRight: () => (event.shiftKey ? zoom(state.from + span / 5, state.to + span / 5) : hover(Math.min(middle + span / 50, state.to))),
        "+": () => zoom(middle - span / 3, middle + span / 3),
        "=": () => zoom(middle - span / 3, middle + span / 3),
        "-": () => zoom(middle - span * 0.75, middle + span * 0.75),
        0: () => zoom(0, end()),
        Escape: () => zoom(0, end()),
      };
      if (!keys[event.key]) return;
      event.preventDefault();
      const kept = hair;
      keys[event.key]();
      if (hair === null && kept !== null && kept >= state.from && kept <= state.to) hover(kept);
      again(svg);
    });
  };
  // Drawing anew makes new panels; the focus stays in that of the same quantity.
  const again = (svg) => {
    if (svg.isConnected) return;
    panels.find((one) => one.quantity === svg.dataset.quantity)?.svg.focus();
  };

  const swatch = (trace) => {
    const made = draw("svg", { class: "swatch", viewBox: "0 0 34 8", width: "34", height: "8", "aria-hidden": "true" });
    made.append(draw("path", { class: "curve", d: "M0 4H34", style: look(trace) }));
    return made;
  };
  const render = () => {
    const field = place.querySelector(".panels");
    panels = state.quantities.map((quantity, index) => panel(quantity, index === state.quantities.length - 1));
    for (const one of panels) one.svg.dataset.quantity = one.quantity;
    field.replaceChildren(...panels.map((one) => one.svg));
    hover(null);
  };

  // What is shown, as a table for other programs: a row for each point that is drawn.
  const csv = () => {
    const quote = (text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
    const base = reference(), head = ["charge", "time / s", ...state.quantities.map((name) => (base ? `${name} less ${base.title}` : name))];
    const rows = chosen().flatMap((trace) => trace.time.filter((time) => time >= state.from && time <= state.to).map((time) => [
      trace.title, time, ...state.quantities.map((name) => {
        const own = at(trace, name, time), theirs = base ? at(base, name, time) : 0;
        return own === null || theirs === null ? "" : Number((own - theirs).toPrecision(6));
      })]));
    return [head, ...rows].map((row) => row.map((cell) => quote(String(cell))).join(",")).join("\n") + "\n";
  };
  const download = () => {
    const link = node("a", { download: "charges.csv", href: URL.createObjectURL(new Blob([csv()], { type: "text/csv" })) });
    link.click();
    URL.revokeObjectURL(link.href);
  };

  const boxes = (legend, names, titles, picked, change) => node("fieldset", {}, node("legend", {}, legend),
    ...names.map((name, index) => {
      const box = node("input", { type: "checkbox", value: name, checked: picked.includes(name) });
      box.addEventListener("change", () => change(name, box.checked));
      return node("label", {}, box, " ", ...titles[index]);
    }));
  const build = () => {
    const quantities = [...new Set(traces.flatMap((trace) => Object.keys(trace.quantities)))];
    const groups = [...new Set(traces.map((trace) => trace.group))];
    for (const trace of traces) trace.order = groups.indexOf(trace.group);
    const { place: where, query } = window.pageAddress.read();
    const asked = (name, known) => (where === "explorer" ? (query.get(name) || "").split("|").filter((one) => known.includes(one)) : []);
    const names = traces.map((trace) => trace.name);
    const own = asked("charges", names), shown = asked("quantities", quantities);
    state = {
      quantities: shown.length ? shown : quantities.slice(0, 3),
      charges: own.length ? own : names.filter((_, index) => traces[index].group === groups[0]),
      reference: asked("reference", names)[0] || "", from: 0, to: 0,
    };
    state.to = end();
    if (where === "explorer" && query.get("to")) [state.from, state.to] = [Number(query.get("from")) || 0, Number(query.get("to"))];
    const toggle = (key, all) => (name, on) => {
      const whole = state.from === 0 && state.to === end();
      const next = all.filter((one) => (one === name ? on : state[key].includes(one)));
      if (next.length) state[key] = next;
      if (whole || state.from >= end()) [state.from, state.to] = [0, end()];
      render();
      remember();
    };
    const select = node("select", { name: "reference" }, node("option", { value: "" }, "none"),
      ...traces.map((trace) => node("option", { value: trace.name, selected: trace.name === state.reference }, `${trace.title}, ${trace.group}`)));
    select.addEventListener("change", () => { state.reference = select.value; render(); remember(); });
    const button = (text, name, act) => {
      const made = node("button", { type: "button", name }, text);
      made.addEventListener("click", act);
      return made;
    };
    readout = node("div", { className: "readout wide" });
    place.className = "explore";
    place.replaceChildren(
      boxes("Quantities", quantities, quantities.map((name) => [name]), state.quantities, toggle("quantities", quantities)),
      ...groups.map((group) => {
        const own = traces.filter((trace) => trace.group === group);
        return boxes(group, own.map((trace) => trace.name), own.map((trace) => [swatch(trace), ` ${trace.title}`]), state.charges, toggle("charges", names));
      }),
      node("div", { className: "controls" }, node("label", {}, "Difference to ", select),
        button("Whole charge", "reset", () => zoom(0, end())), button("CSV of what is shown", "csv", download)),
      node("p", { className: "soft" }, "Drag to zoom in time; Ctrl and wheel, or + and −; arrows move the readout, with Shift the view; 0 shows all."),
      node("div", { className: "panels" }), readout);
    render();
    place.dataset.ready = "yes";
  };

  const load = () => {
    if (place.dataset.loading) return;
    place.dataset.loading = "yes";
    if (window.TRACES) { traces = window.TRACES; build(); return; }
    const script = document.createElement("script");
    script.src = place.dataset.source;
    script.onload = () => { traces = window.TRACES; build(); };
    script.onerror = () => { place.textContent = "The curves are not beside this page."; };
    document.head.append(script);
  };
  place.textContent = "The curves load when they come into view.";
  new IntersectionObserver((entries, watch) => {
    if (entries.some((entry) => entry.isIntersecting)) { watch.disconnect(); load(); }
  }, { rootMargin: "200px" }).observe(place);
})();
