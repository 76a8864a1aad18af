"""The pages in a real browser, from the file system: quiet, reachable, readable, and doing what they offer.

`make browser-setup` installs what this needs; without it every test is skipped with the reason. The pages of runs that
are published here are looked at too, and their screenshots kept under results/screenshots/.
"""

from __future__ import annotations

import csv
import re
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.browser import site

sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed: make browser-setup")
CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
if CHROMIUM is None:
    pytest.skip("no Chromium on the path: apt-get install chromium", allow_module_level=True)

PROJECT = Path(__file__).resolve().parents[2]
pytestmark = pytest.mark.browser
PUBLISHED = sorted(
    path.parent for at in ("*/*", "*/sweeps/*") for path in (PROJECT / "reports").glob(f"{at}/index.html")
)
MADE_UP = ["index.html", *(f"{place}/index.html" for place in site.PLACES)]
SERIOUS = ("serious", "critical")
A4_WIDTH = 794
Open = Callable[..., Any]


@pytest.fixture(scope="module")
def reports(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return site.build(tmp_path_factory.mktemp("site"))


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    with sync_api.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM)
        yield browser
        browser.close()


@pytest.fixture
def visit(chromium: Any, reports: Path) -> Iterator[Open]:
    """Open a page; whatever it says on the console, or asks for outside its folder, fails the test."""
    told: list[str] = []
    contexts = []

    def opened(page: str | Path, width: int = 1280, scheme: str = "light", place: str = "", **options: Any) -> Any:
        file = page if isinstance(page, Path) else reports / page
        root = next(parent for parent in file.parents if parent.name == "reports")
        context = chromium.new_context(viewport={"width": width, "height": 900}, color_scheme=scheme, **options)
        contexts.append(context)
        tab = context.new_page()
        tab.on("console", lambda message: told.append(f"console: {message.text}"))
        tab.on("pageerror", lambda error: told.append(f"error: {error}"))
        tab.on("requestfailed", lambda request: told.append(f"failed: {request.url}"))
        allowed = (root.as_uri(), "data:", "blob:")
        tab.on(
            "request", lambda found: told.append(f"asks for {found.url}") if not found.url.startswith(allowed) else None
        )
        tab.goto(f"{file.as_uri()}{place}")
        return tab

    yield opened
    for context in contexts:
        context.close()
    assert not told


def every_page() -> list[Any]:
    return [*MADE_UP, *(pytest.param(path / "index.html", id="/".join(path.parts[-2:])) for path in PUBLISHED)]


@pytest.mark.parametrize("page", every_page())
@pytest.mark.parametrize("width", [360, 768, 1280, 1920])
def test_no_page_is_wider_than_its_window(visit: Open, page: Any, width: int) -> None:
    tab = visit(page, width)
    assert tab.evaluate("document.documentElement.scrollWidth") <= width


@pytest.mark.parametrize("page", every_page())
def test_identifiers_are_unique_and_links_within_the_page_have_an_end(visit: Open, page: Any) -> None:
    tab = visit(page)
    names = tab.evaluate("[...document.querySelectorAll('[id]')].map((one) => one.id)")
    assert len(names) == len(set(names))
    links = tab.evaluate(
        "[...document.querySelectorAll('a[href^=\"#\"]')].map((one) => one.getAttribute('href').slice(1))"
    )
    assert set(links) <= set(names)


@pytest.mark.parametrize("page", every_page())
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_serious(visit: Open, page: Any, scheme: str) -> None:
    axe = pytest.importorskip(
        "axe_playwright_python.sync_playwright", reason="axe is not installed: make browser-setup"
    )
    tab = visit(page, scheme=scheme)
    for unfold in ("[name=unfold]", ".fold > summary"):
        for found in tab.query_selector_all(unfold)[:40]:
            found.click()
    if tab.query_selector("#explorer"):
        tab.evaluate("document.getElementById('explorer').scrollIntoView()")
        tab.wait_for_selector("#explore[data-ready]")
    found = axe.Axe().run(tab).response["violations"]
    assert not [(one["id"], one["nodes"][0]["html"][:200]) for one in found if one["impact"] in SERIOUS]


def test_the_filter_shows_what_is_asked_for_and_keeps_it_in_the_address(visit: Open) -> None:
    tab = visit(MADE_UP[1])
    every = tab.locator(".verdict").count()
    tab.check("[name=word][value=holds]")
    words = tab.evaluate("[...document.querySelectorAll('.verdict:not([hidden])')].map((one) => one.dataset.word)")
    assert words == ["holds", "holds"]
    tab.fill("[name=text]", "fast")
    assert tab.inner_text(".filter output") == f"1 of {every}"
    address = tab.url
    assert "#verdicts?word=holds&text=fast" in address
    again = visit(MADE_UP[1], place=address[address.index("#") :])
    assert again.is_checked("[name=word][value=holds]")
    assert again.locator(".verdict:not([hidden])").count() == 1
    tab.fill("[name=text]", "nothing like this")
    assert tab.is_visible(".none")


def test_close_calls_can_be_asked_for(visit: Open) -> None:
    tab = visit(MADE_UP[1])
    tab.check("[name=close]")
    shown = tab.evaluate("[...document.querySelectorAll('.verdict:not([hidden])')].map((one) => one.dataset.close)")
    assert shown
    assert set(shown) == {"yes"}


def test_a_cell_of_the_matrix_leads_to_its_row_and_that_to_its_figure(visit: Open) -> None:
    tab = visit(MADE_UP[1])
    row = tab.locator("#statement-fast_same_peak")
    assert not row.is_visible()
    tab.click(".cell[href='#statement-fast_same_peak']")
    assert row.is_visible()
    row.locator("a[href^='#figure_']").first.click()
    assert tab.locator(":target").get_attribute("id").startswith("figure_")


def test_what_is_said_stands_in_sight_above_the_row_that_an_address_leads_to(visit: Open) -> None:
    tab = visit(MADE_UP[1], place="#statement-claim_1")
    tab.wait_for_selector("#statement-claim_1", state="visible")
    said = tab.locator(".claim:has(#statement-claim_1) .says").bounding_box()
    bar = tab.locator(".filter").bounding_box()
    assert said["y"] >= bar["y"] + bar["height"]


def test_an_address_of_a_row_unfolds_it_even_where_a_filter_hides_it(visit: Open) -> None:
    tab = visit(MADE_UP[1], place="#statement-claim_1")
    assert tab.is_visible("#statement-claim_1")
    tab.check("[name=word][value=undecided]")
    assert not tab.is_visible("#statement-claim_1")
    tab.evaluate("location.hash = '#statement-claim_1'")
    tab.wait_for_selector("#statement-claim_1", state="visible")
    assert not tab.is_checked("[name=word][value=undecided]")


def test_a_folded_group_opens_where_an_address_leads_into_it(visit: Open) -> None:
    tab = visit(MADE_UP[1], place="#parameter-battery.value_3_v")
    assert tab.is_visible("[id='parameter-battery.value_3_v']")


def explored(visit: Open, place: str = "#explorer", **options: Any) -> Any:
    tab = visit(MADE_UP[1], place=place, **options)
    tab.wait_for_selector("#explore[data-ready]")
    return tab


def spans(tab: Any) -> list[str]:
    return tab.evaluate(
        "[...document.querySelectorAll('#explore .panels svg')].map((one) => one.getAttribute('aria-label'))"
    )


def test_the_curves_load_when_the_explorer_comes_into_view(visit: Open) -> None:
    tab = visit(MADE_UP[1])
    assert tab.evaluate("window.TRACES === undefined")
    tab.evaluate("document.getElementById('explorer').scrollIntoView()")
    tab.wait_for_selector("#explore[data-ready]")
    assert tab.locator("#explore .panels svg").count() == 3
    assert tab.locator("#explore .panels svg >> nth=0 >> .curve").count() == 2


def test_dragging_zooms_all_panels_and_a_double_click_shows_all(visit: Open) -> None:
    tab = explored(visit)
    box = tab.locator("#explore .panels svg").first.bounding_box()
    middle = box["y"] + box["height"] / 2
    tab.mouse.move(box["x"] + box["width"] * 0.4, middle)
    tab.mouse.down()
    tab.mouse.move(box["x"] + box["width"] * 0.6, middle, steps=4)
    tab.mouse.up()
    zoomed = spans(tab)
    assert len(zoomed) == 3
    assert all("from 0 to 60 min" not in one for one in zoomed)
    assert len({one.split("from")[1] for one in zoomed}) == 1
    assert "from=" in tab.url
    again = explored(visit, place=tab.url[tab.url.index("#") :])
    assert spans(again) == zoomed
    tab.locator("#explore .panels svg").first.dblclick()
    assert all("from 0 to 60 min" in one for one in spans(tab))


def test_the_readout_tells_the_values_under_the_pointer(visit: Open) -> None:
    tab = explored(visit)
    box = tab.locator("#explore .panels svg").first.bounding_box()
    # Half of the time: the field begins 62 of 900 from the left and ends 12 before the right.
    tab.mouse.move(box["x"] + box["width"] * (62 + 413) / 900, box["y"] + 60)
    cells = tab.locator(".readout tbody td").all_inner_texts()
    assert float(cells[0]) == pytest.approx(12.5, abs=0.01)
    assert float(cells[3]) == pytest.approx(12.25, abs=0.01)


def test_the_difference_to_a_charge_is_that_of_its_values(visit: Open) -> None:
    tab = explored(visit)
    tab.select_option("[name=reference]", "peak/cc")
    box = tab.locator("#explore .panels svg").first.bounding_box()
    tab.mouse.move(box["x"] + box["width"] * (62 + 413) / 900, box["y"] + 60)
    cells = [text.replace("−", "-") for text in tab.locator(".readout tbody td").all_inner_texts()]
    assert float(cells[0]) == 0.0
    assert float(cells[3]) == pytest.approx(-0.25, abs=0.01)
    assert "reference=peak%2Fcc" in tab.url


def test_the_keyboard_zooms_moves_and_reads(visit: Open) -> None:
    tab = explored(visit)
    tab.locator("#explore .panels svg").first.focus()
    tab.keyboard.press("+")
    first = spans(tab)
    assert "from 0 to 60 min" not in first[0]
    assert tab.evaluate("document.activeElement.tagName") == "svg"
    tab.keyboard.press("Shift+ArrowRight")
    assert spans(tab) != first
    tab.keyboard.press("ArrowRight")
    assert tab.locator(".readout tbody tr").count() == 2
    tab.keyboard.press("0")
    assert "from 0 to 60 min" in spans(tab)[0]


def test_an_address_keeps_names_with_signs_and_survives_what_is_typed_by_hand(visit: Open) -> None:
    tab = explored(visit)
    tab.uncheck("#explore input[value='Voltage [V]']")
    tab.check("#explore input[value='Share + rest [%]']")
    again = explored(visit, place=tab.url[tab.url.index("#") :])
    assert again.is_checked("#explore input[value='Share + rest [%]']")
    assert not again.is_checked("#explore input[value='Voltage [V]']")
    typed = visit(MADE_UP[1], place="#statement-claim_1%?word=50%")
    assert typed.is_visible(".filter")


def test_what_is_shown_can_be_downloaded(visit: Open) -> None:
    tab = explored(visit, accept_downloads=True)
    tab.check("#explore input[value='mean/reflex']")
    tab.uncheck("#explore input[value='peak/pulse']")
    with tab.expect_download() as waiting:
        tab.click("#explore [name=csv]")
    with Path(waiting.value.path()).open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert {row["charge"] for row in rows} == {"cc", "reflex"}
    last = [row for row in rows if row["charge"] == "reflex"][-1]
    assert (float(last["time / s"]), float(last["Voltage [V]"])) == (3600.0, 12.25)


def test_the_keyboard_reaches_the_content_first_and_every_verdict(visit: Open) -> None:
    tab = visit(MADE_UP[1])
    tab.keyboard.press("Tab")
    assert tab.evaluate("document.activeElement.className") == "skip"
    tab.keyboard.press("Enter")
    assert tab.evaluate("document.activeElement.id") == "main"
    tab.locator(".claim summary").first.focus()
    tab.keyboard.press("Enter")
    assert tab.locator(".claim").first.get_attribute("open") is not None


def test_only_what_scrolls_takes_the_focus(visit: Open) -> None:
    tab = visit(MADE_UP[1])
    wrong = tab.evaluate(
        "[...document.querySelectorAll('.wide, pre')].filter((one) => one.offsetParent"
        " && (one.scrollWidth > one.clientWidth + 1) !== one.hasAttribute('tabindex')).length"
    )
    assert wrong == 0


def test_a_drawing_can_be_enlarged_and_panned_on_a_phone(visit: Open) -> None:
    """At its own size, so that its text is as large as it was made, whatever the window's width."""
    tab = visit(MADE_UP[1], 360, has_touch=True, is_mobile=True)
    link = tab.locator("#figure_11 .drawing a")
    small = link.locator("img").bounding_box()
    assert small["width"] <= 360
    link.tap()
    pan = tab.locator("dialog.enlarged .pan")
    shown = pan.locator("img").bounding_box()
    assert shown["width"] >= 864
    assert pan.evaluate("(one) => one.scrollWidth > one.clientWidth")
    assert pan.evaluate("(one) => { one.scrollTo(400, 0); return one.scrollLeft }") == 400
    tab.locator("dialog [aria-label=Larger]").tap()
    assert pan.locator("img").bounding_box()["width"] > 1000
    tab.keyboard.press("Escape")
    assert tab.locator("dialog[open]").count() == 0
    assert tab.evaluate("document.activeElement.getAttribute('href')") == "figures/figure_11.svg"
    assert tab.evaluate("document.documentElement.scrollWidth") <= 360


def test_without_script_or_on_a_wide_window_a_drawing_leads_to_its_file(visit: Open) -> None:
    for options in ({"width": 360, "java_script_enabled": False}, {"width": 1280}):
        tab = visit(MADE_UP[1], **options)
        tab.locator("#figure_11 .drawing a").click()
        assert tab.url.endswith("/figures/figure_11.svg")


@pytest.mark.parametrize("folder", PUBLISHED, ids=lambda path: path.parent.name)
def test_every_drawing_opens_at_the_size_it_was_made(visit: Open, folder: Path) -> None:
    tab = visit(folder / "index.html", 360, has_touch=True, is_mobile=True)
    for link in tab.locator(".drawing a").all()[:3]:
        made = int(link.locator("img").get_attribute("width"))
        link.evaluate("(one) => one.scrollIntoView({block: 'center'})")
        link.tap()
        tab.wait_for_function("document.querySelector('dialog img').complete")
        assert tab.locator("dialog img").bounding_box()["width"] == pytest.approx(made, abs=1)
        tab.locator("dialog form button:last-child").tap()


def test_without_script_everything_is_there_to_read(visit: Open) -> None:
    tab = visit(MADE_UP[1], java_script_enabled=False)
    assert not tab.is_visible(".filter")
    tab.locator(".claim summary").first.click()
    assert tab.locator(".verdict").first.is_visible()
    assert tab.is_visible(".needs-script")
    assert tab.is_visible("a[href$='manifest.json']")


def test_pages_lead_to_each_other(visit: Open) -> None:
    tab = visit(MADE_UP[0])
    assert tab.locator(".facts").first.inner_text().startswith("20")
    tab.click(".cards h3 a >> nth=0")
    assert tab.inner_text("h1") == "A study that never was"
    assert re.fullmatch(r"\d{4}-\d\d-\d\d .* UTC", tab.inner_text("[data-run=made] dd"))
    tab.click("footer #others a")
    assert "seed=2" in tab.url
    tab.click(".home")
    assert tab.inner_text("h1") == "Charging studies"


def pages_printed(tab: Any) -> int:
    return len(re.findall(rb"/Type\s*/Page\b(?!s)", tab.pdf(format="A4", print_background=True)))


def test_print_unfolds_the_verdicts_and_leaves_out_what_cannot_be_used(visit: Open) -> None:
    tab = visit(MADE_UP[1])
    tab.emulate_media(media="print")
    assert tab.locator("#statement-claim_0 .found").is_visible()
    assert not tab.is_visible(".filter")
    assert not tab.is_visible("#explorer")
    assert 2 <= pages_printed(tab) <= 8


# Half of what was printed before: 72, 25 and 38 pages.
MOST_PAGES = {"solar_reflex": 36, "nicd_grnn": 12, "lfp_cuckoo": 19}
STUDIES = [path for path in PUBLISHED if path.name == "default" and path.parent.name in MOST_PAGES]
NO_WORDS = re.compile(r"\b[a-z0-9]+_[a-z0-9_]+|degC|\de[-+]?\d|\d\.\d{7,}|--|None|nan\b")
"""What a sentence for people has none of: keys, units as they are declared, powers of ten, digits without end."""


@pytest.mark.parametrize("folder", STUDIES, ids=lambda path: path.parent.name)
def test_sentences_of_a_study_have_words_and_no_keys(visit: Open, folder: Path) -> None:
    tab = visit(folder / "index.html")
    told = tab.evaluate(
        "[...document.querySelectorAll('#answer p, #answer li, .notes li, .found, .conditions, .matrix th,"
        " figcaption p, h2, h3, .absent p')].map((one) => one.textContent.trim())"
    )
    assert len(told) > 100
    assert not [text for text in told if NO_WORDS.search(text)]


@pytest.mark.parametrize("folder", STUDIES, ids=lambda path: path.parent.name)
def test_a_study_prints_in_half_the_pages(visit: Open, folder: Path) -> None:
    assert pages_printed(visit(folder / "index.html")) <= MOST_PAGES[folder.parent.name]


@pytest.mark.parametrize("folder", PUBLISHED, ids=lambda path: path.parent.name)
@pytest.mark.parametrize(("scheme", "width"), [("light", 1280), ("dark", 1280), ("light", 360)])
def test_pages_are_small_and_kept_as_pictures(visit: Open, folder: Path, scheme: str, width: int) -> None:
    assert (folder / "index.html").stat().st_size < 1_500_000
    tab = visit(folder / "index.html", width, scheme)
    kept = PROJECT / "results" / "screenshots" / f"{folder.parent.name}-{folder.name}"
    kept.mkdir(parents=True, exist_ok=True)
    for name, selector in (
        ("answer", "header"),
        ("verdicts", "#matrix"),
        ("figures", "#figures"),
        ("explorer", "#explorer"),
    ):
        if tab.query_selector(selector):
            tab.locator(selector).first.evaluate("(one) => one.scrollIntoView()")
            tab.wait_for_timeout(400)
            tab.screenshot(path=kept / f"{name}-{scheme}-{width}.png")
