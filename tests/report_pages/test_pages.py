"""The page: complete, self-contained, escaped, and the same bytes every time."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import replace
from html.parser import HTMLParser

import pytest

from pipeline.published.words import WORDS
from pipeline.report import pages
from pipeline.report.claims import Rests
from pipeline.report.pages import PageContent, PageFigure, PageSection, render
from pipeline.report.tables import Parameter, ReportTable
from tests.report_pages.conftest import SVG, verdict_columns

VOID = {"meta", "img", "br", "link", "hr", "input"}


class Page(HTMLParser):
    """Collects what the tests ask about, and that every element is closed where it should be."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.found: list[tuple[str, dict[str, str | None]]] = []
        self.text: list[str] = []
        self.feed(text)
        self.close()
        assert not self.open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text.append(data)

    def attributes(self, name: str) -> list[str]:
        return [str(attrs[name]) for _, attrs in self.found if name in attrs]


@pytest.fixture
def page(content: PageContent) -> Page:
    return Page(render(content))


def test_the_same_content_gives_the_same_bytes(content: PageContent) -> None:
    assert render(content) == render(content)


def test_nothing_is_loaded_from_outside(content: PageContent, page: Page) -> None:
    sources = page.attributes("src")
    assert set(sources) == {"figures/figure_11.svg", "run.js", "../../reports.js"}
    assert not {"iframe", "object", "embed"} & {tag for tag, _ in page.found}
    assert all(attrs["href"].startswith("data:image/") for tag, attrs in page.found if tag == "link")
    assert not re.search(r"url\(|@import|fetch\(|XMLHttpRequest", render(content))
    outside = [link for link in page.attributes("href") if "://" in link and not link.startswith("data:")]
    assert outside == ["https://doi.org/10.1000/example"]


def test_every_link_within_the_page_has_its_end_and_identifiers_are_unique(page: Page) -> None:
    names = page.attributes("id")
    assert max(Counter(names).values()) == 1
    assert {link[1:] for link in page.attributes("href") if link.startswith("#")} <= set(names)


def main_parts(page: Page) -> list[str]:
    """Return the identifiers of the sections, tables and figures of a page in their order."""
    return [str(attrs["id"]) for tag, attrs in page.found if tag in ("section", "figure", "details") and "id" in attrs]


def test_the_page_goes_from_the_answer_to_how_it_is_reproduced(content: PageContent) -> None:
    traces = replace(content, answer=["Take one.", "Rise: one."], traces=2)
    assert main_parts(Page(render(traces))) == [
        *("answer", "matrix", "verdicts", "figures", "figure_11", "table-table_1", "explorer", "in-numbers"),
        *("table-charges", "parameters", "parameters-panel", "parameters-battery", "reproduce"),
    ]


def test_the_answer_has_the_picture_asked_for(content: PageContent) -> None:
    other = PageFigure("same_rise", "", "Rise", "A rise.")
    section = PageSection("apart", "Apart", "Text.", (), [other])
    shown = render(replace(content, answer=["Take one."], sections=[section], hero="same_rise"))
    assert shown.index("figures/same_rise.svg") < shown.index("figures/figure_11.svg")
    first = render(replace(content, answer=["Take one."], sections=[section], hero="left_out"))
    assert first.index("figures/figure_11.svg") < first.index("figures/same_rise.svg")


def test_verdicts_are_counted_and_told_by_word_and_symbol(content: PageContent, page: Page) -> None:
    text = " ".join(" ".join(page.text).split())
    for count, symbol, word in (
        (1, "✓", "holds"),
        (2, "⊘", "contradicted"),
        (1, "○", "not checkable"),
        (1, "≈", "undecided"),
    ):
        assert f"{count} {symbol} {word}" in text
    assert "Robust share 62 %" in text
    assert "Published 65 W ± 0.5 W" in text
    assert "margin −0.25 W" in text


def test_arithmetic_of_the_paper_is_counted_apart(content: PageContent) -> None:
    columns = verdict_columns("holds", "contradicted", "holds") | {"basis": ["model", "paper_data", "paper_data"]}
    shown = Page(render(replace(content, verdicts=columns)))
    text = " ".join("".join(shown.text).split())
    assert "1 ✓ holds" in text
    assert "as arithmetic of the paper alone: holds 1, contradicted 1" in text


def test_conditions_that_were_not_kept_stand_on_the_page(page: Page) -> None:
    assert "".join(page.text).count("Not as in the paper: another <cell>") == 1


@pytest.mark.parametrize("verdict", WORDS)
def test_a_verdict_that_does_not_occur_is_not_on_the_page(content: PageContent, verdict: str) -> None:
    others = [word for word in WORDS if word != verdict]
    shown = Page(render(replace(content, verdicts=verdict_columns(*others))))
    rows = [attrs["data-word"] for _, attrs in shown.found if "data-word" in attrs]
    assert rows == [word.replace(" ", "-") for word in others]
    assert verdict.replace(" ", "-") not in shown.attributes("value")


def test_text_is_escaped(content: PageContent) -> None:
    html = render(content)
    assert "<of>" not in html
    assert "claim <0>" not in html
    assert "claim &lt;0&gt; &amp; more" in html


def test_every_figure_has_its_words_its_size_and_its_files(page: Page) -> None:
    (image,) = [attrs for tag, attrs in page.found if tag == "img"]
    assert image["alt"] == 'Battery current. Current "in" A'
    assert (image["width"], image["height"], image["loading"]) == ("864", "384", "lazy")
    assert {"figures/figure_11.svg", "figures/figure_11.png"} <= set(page.attributes("href"))


def test_a_heavy_figure_is_shown_as_png(content: PageContent) -> None:
    heavy = replace(content.figures[0], heavy=True)
    assert 'src="figures/figure_11.png"' in render(replace(content, figures=[heavy]))


def test_the_size_of_a_drawing_is_that_of_its_head() -> None:
    assert pages.size_of(SVG) == (864, 384)
    assert pages.size_of('<svg width="300" height="100.4"/>') == (300, 100)
    assert pages.size_of("<svg/>") == (864, 432)


def test_the_papers_caption_stands_beside_ours_and_what_is_not_drawn_is_said(content: PageContent) -> None:
    captions = {"Figure 11": "Battery current <comparison>.", "Figure 12": "An enlarged view."}
    absent = {"Figure 2": "its picture is lost <here>", "Figure 11": "never told, since it is drawn"}
    html = render(replace(content, paper=replace(content.paper, captions=captions, not_drawn=absent)))
    text = " ".join("".join(Page(html).text).split())
    assert 'The paper: Battery current <comparison>. Current "in" A' in text
    assert "Figure 12 not drawn The paper: An enlarged view. This run leaves out what it shows." in text
    assert "Figure 2 not drawn Its picture is lost <here>." in text
    places = [html.index(f'id="{name}"') for name in ("absent-figure-2", "figure_11", "absent-figure-12")]
    assert places == sorted(places)
    assert "never told" not in text
    assert 'href="#absent-figure-2"' in html


def test_every_column_has_a_header(page: Page) -> None:
    headers = [attrs for tag, attrs in page.found if tag == "th"]
    assert all(attrs.get("scope") in ("col", "row", "rowgroup") for attrs in headers)


def test_a_parameter_shows_source_range_and_calibration(page: Page) -> None:
    text = " ".join(" ".join(page.text).split())
    assert "battery.heat_capacity_j_per_k 2100 J/K estimate 1800 to 2600 by weight" in text
    assert "panel.max_power_w 65 W published to table 1 Table 1" in text


def test_calibrated_and_fitted_parameters_stand_on_top_and_in_their_group(content: PageContent) -> None:
    fitted = Parameter("battery.r_ohm", 0.02, "ohm", "fitted", "to Figure 2")
    shown = Page(render(replace(content, parameters=[*content.parameters, fitted])))
    assert [text for text in shown.text if text == "battery.r_ohm"] == ["battery.r_ohm"] * 2
    assert shown.attributes("id").count("parameter-battery.r_ohm") == 1


def test_a_row_leads_to_what_its_answer_rests_on(content: PageContent) -> None:
    rests = Rests(
        ("panel",), ("figure_11",), ("supply",), ("panel", "unknown"), ("panel.max_power_w",),
        "conf/published/a_study.yaml", "claim_0", "snakemake panel",
    )  # fmt: skip
    html = render(replace(content, rests={"claim_0": rests}, owners={"charges": "supply"}))
    shown = Page(html)
    links = shown.attributes("href")
    wanted = ("figure_11", "table-table_1", "table-charges", "key-panel", "parameters-panel")
    assert {f"#{name}" for name in (*wanted, "parameter-panel.max_power_w", "statement-claim_0")} <= set(links)
    assert {link[1:] for link in links if link.startswith("#")} <= set(shown.attributes("id"))
    text = " ".join("".join(shown.text).split())
    assert "conf/published/a_study.yaml, key claim_0" in text
    assert "snakemake panel" in text


def test_a_long_table_is_folded(content: PageContent) -> None:
    rows = tuple((f"row {number}", number) for number in range(pages.FOLDED + 1))
    long = ReportTable("long", "Long", "", ("name", "value"), rows)
    short = replace(long, name="short", rows=rows[:-1])
    html = render(replace(content, tables=[long, short]))
    assert "15 rows" in html
    assert "14 rows" not in html


@pytest.mark.parametrize("part", ["figures", "tables", "parameters"])
def test_a_page_without_a_part_is_still_a_page(content: PageContent, part: str) -> None:
    Page(render(replace(content, **{part: []})))


def test_a_row_has_no_fields_without_content(content: PageContent) -> None:
    names = ("robust_share", "robust_low", "robust_high", "published_value", "computed_value", "margin")
    html = render(replace(content, verdicts=verdict_columns("holds") | {name: [None] for name in names}))
    terms = ("Robust share", "Published", "Computed", "Margin")
    assert not [term for term in terms if re.search(f"<dt>{term}</dt><dd>[^<]", html)]
    assert re.search("<dt>Published</dt><dd>[^<]", render(replace(content, verdicts=verdict_columns("holds"))))
