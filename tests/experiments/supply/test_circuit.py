"""The circuit's diagrams show what is configured."""

from __future__ import annotations

import pytest

from pipeline.report.records import FigureCard
from pipeline.report.tables import ModeLabel, ReportData
from tests import making
from tests.experiments.drawing import drawn
from tests.experiments.supply.system import SYSTEM


@pytest.fixture
def whole() -> ReportData:
    modes = {"cv_reflex": ModeLabel("CV-Reflex", {"discharge_a": 0.5})}
    return ReportData(making.inputs({}), modes, {}, {"system": SYSTEM})


def texts(part: str, data: ReportData) -> str:
    card = FigureCard(draw="circuit", title="t", caption="c", options={"part": part})
    found = drawn(card, data)
    words = [text.get_text() for axes in found.get_axes() for text in axes.texts]
    return "\n".join(words + [axes.get_title(loc="left") for axes in found.get_axes()])


def test_the_switches_stand_as_the_paper_says(whole):
    assert "S2 and S3 on, S4 off" in texts("mode_1", whole)
    second = texts("mode_2", whole)
    assert {"S2 on", "S3 off", "S4 on", "27 Ω"} <= set(second.splitlines())


@pytest.mark.parametrize("part", ["system", "architecture"])
def test_diagrams_carry_the_configured_values(whole, part):
    found = texts(part, whole)
    for words in ("Kyocera KC65T", "0.95", "0.92", "24 V", "20 W"):
        assert words in found


def test_a_diagram_of_what_is_not_configured_says_so(whole):
    assert "no panel" in texts("system", ReportData(whole.inputs, {}, {}))
