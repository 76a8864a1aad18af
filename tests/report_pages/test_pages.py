"""The page: complete, self-contained, escaped, and the same bytes every time."""

from __future__ import annotations

import base64
import re
from collections import Counter
from dataclasses import replace
from html.parser import HTMLParser

import pytest

from pipeline.published.words import WORDS
from pipeline.report import pages
from pipeline.report.pages import PageContent, number, prose, render
from tests.report_pages.conftest import SVG, verdict_columns

VOID = {"meta", "img", "br", "link", "hr"}


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
    assert all(source.startswith("data:image/") for source in page.attributes("src"))
    assert not {"script", "link", "iframe", "object"} & {tag for tag, _ in page.found}
    assert not re.search(r"url\(|@import", render(content))
    outside = [link for link in page.attributes("href") if "://" in link]
    assert outside == ["https://doi.org/10.1000/example"]


def test_every_link_within_the_page_has_its_end_and_identifiers_are_unique(page: Page) -> None:
    names = page.attributes("id")
    assert max(Counter(names).values()) == 1
    assert {link[1:] for link in page.attributes("href") if link.startswith("#")} <= set(names)


def test_the_page_opens_with_the_verdicts_then_what_the_paper_shows(page: Page) -> None:
    order = [name for name in page.attributes("id") if not name.startswith("statement-")]
    wanted = ["verdicts", "figures", "table_1", "figure_11", "in-numbers", "charges", "parameters", "reproduce"]
    assert order == wanted


def test_verdicts_are_counted_and_told_by_word_and_symbol(content: PageContent, page: Page) -> None:
    text = " ".join("".join(page.text).split())
    for count, symbol, word in (
        (1, "✓", "holds"),
        (2, "⊘", "contradicted"),
        (1, "○", "not checkable"),
        (1, "≈", "undecided"),
    ):
        assert f"{count} {symbol} {word}" in text
    assert text.count("⊘contradicted") == 2
    assert "62 %53 % to 71 %" in text
    assert "65 W± 0.5" in text
    assert "−0.25 W" in text


def test_the_page_begins_with_the_answer(content: PageContent) -> None:
    shown = Page(render(replace(content, answer=["Take <one>.", "Rise: one."])))
    assert [name for name in shown.attributes("id") if not name.startswith("statement-")][:2] == ["answer", "verdicts"]
    assert "Take <one>." in "".join(shown.text)


def test_arithmetic_of_the_paper_is_counted_apart(content: PageContent) -> None:
    columns = verdict_columns("holds", "contradicted", "holds") | {"basis": ["model", "paper_data", "paper_data"]}
    shown = Page(render(replace(content, verdicts=columns)))
    text = " ".join("".join(shown.text).split())
    assert "1 ✓ holds" in text
    assert "as arithmetic of the paper alone: 1 holds, 1 contradicted" in text


def test_conditions_that_were_not_kept_stand_on_the_page(page: Page) -> None:
    assert "".join(page.text).count("Not as in the paper: another <cell>") == 1


@pytest.mark.parametrize("verdict", WORDS)
def test_a_verdict_that_does_not_occur_is_not_in_the_list(content: PageContent, verdict: str) -> None:
    others = [word for word in WORDS if word != verdict]
    shown = Page(render(replace(content, verdicts=verdict_columns(*others))))
    rows = [attrs["class"] for tag, attrs in shown.found if tag == "td" and "verdict" in (attrs.get("class") or "")]
    assert rows == [f"verdict {word.replace(' ', '-')}" for word in others]


def test_text_is_escaped(content: PageContent) -> None:
    html = render(content)
    assert "<of>" not in html
    assert "claim <0>" not in html
    assert "claim &lt;0&gt; &amp; more" in html


def test_every_figure_has_its_words_and_its_files(content: PageContent, page: Page) -> None:
    (image,) = [attrs for tag, attrs in page.found if tag == "img"]
    assert image["alt"] == 'Battery current. Current "in" A'
    kind, _, data = str(image["src"]).partition(",")
    assert (kind, base64.b64decode(data).decode()) == ("data:image/svg+xml;base64", SVG)
    assert {"figures/figure_11.svg", "figures/figure_11.png"} <= set(page.attributes("href"))


def test_a_heavy_figure_is_shown_as_png(content: PageContent, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pages, "LARGEST_SVG", len(SVG) - 1)
    assert pages.image(content.figures[0]) == "data:image/png;base64," + base64.b64encode(b"\x89PNG").decode()
    assert pages.image(replace(content.figures[0], png=b"")).startswith("data:image/svg")


def test_every_column_has_a_header(page: Page) -> None:
    headers = [attrs for tag, attrs in page.found if tag == "th"]
    assert all(attrs.get("scope") in ("col", "row", "rowgroup") for attrs in headers)


def test_a_parameter_shows_source_range_and_calibration(page: Page) -> None:
    text = " ".join(" ".join(page.text).split())
    assert "battery.heat_capacity_j_per_k 2100 J/K estimate 1800 to 2600 by weight" in text
    assert "panel.max_power_w 65 W published to table 1 Table 1" in text


@pytest.mark.parametrize("part", ["figures", "tables", "parameters"])
def test_a_page_without_a_part_is_still_a_page(content: PageContent, part: str) -> None:
    Page(render(replace(content, **{part: []})))


def test_no_robust_share_no_column(content: PageContent) -> None:
    columns = verdict_columns("holds") | {"robust_share": [None], "robust_low": [None], "robust_high": [None]}
    assert "obust share" not in render(replace(content, verdicts=columns))


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "–"),
        ("", "–"),
        (0.0, "0"),
        (-0.00012345678, "−0.00012346"),
        (123456.7, "123457"),
        (3, "3"),
        ("a-b", "a-b"),
    ],
)
def test_numbers_for_people(value: object, text: str) -> None:
    assert number(value) == text


def test_units_in_prose() -> None:
    assert prose("at 1000 W/m2 and 25 degC") == "at 1000 W/m² and 25 °C"
