"""The figures of the search half show what the tables hold."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pipeline.experiments.frequency import figures
from pipeline.report.records import FigureCard
from pipeline.report.tables import ReportData
from tests import making
from tests.experiments.drawing import drawn
from tests.experiments.frequency.artefacts import ALGORITHM, search_half

FIGURES = Path(figures.__path__[0])
SEARCHES = {"swarm": "chaotic", "uniform": "uniform", "arcsine": "arcsine"}


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> ReportData:
    return ReportData(making.inputs(search_half(tmp_path_factory.mktemp("search"))), {}, {}, {"algorithm": ALGORITHM})


def card_of(name):
    return lambda **more: FigureCard(draw=name, title="t", caption="c", options=more)


def texts(found) -> str:
    words = [text.get_text() for axes in found.get_axes() for text in axes.texts]
    return "\n".join(words + [axes.get_title(loc="left") for axes in found.get_axes()])


def test_each_maximum_of_disorder_is_marked_where_it_is(whole):
    table = whole.table("chaos", "disorder")
    axes = drawn(card_of("map_disorder")(), whole).get_axes()[2]
    marked = sorted(line.get_xdata()[0] for line in axes.get_lines() if len(line.get_xdata()) == 1)
    rows = [table["bins"] == bins for bins in np.unique(table["bins"])]
    assert marked == sorted(table["r"][row][np.argmax(table["entropy_nats"][row])] for row in rows)


@pytest.mark.parametrize(("quantity", "column"), [("frequency", "position"), ("ise", "value")])
def test_the_runs_drawn_are_the_histories(whole, quantity, column):
    axes = drawn(card_of("convergence")(quantity=quantity), whole).get_axes()[0]
    table = whole.table("search", "published_protocol_history")
    lines = [line.get_ydata() for line in axes.get_lines() if line.get_marker() not in ("None", "", None)]
    assert len(lines) == 2
    np.testing.assert_array_equal(np.concatenate(lines), table[column])


def test_the_marked_frequencies_are_those_of_the_objective(whole):
    found = drawn(card_of("loss_over_frequency")(), whole)
    marked = [line.get_xdata()[0] for line in found.get_axes()[0].get_lines() if line.get_marker() == "o"]
    numbers = whole.numbers("objective")
    assert marked == pytest.approx([0.954, numbers["optimal_frequency_hz"], numbers["impedance_minimum_hz"]])


def test_levels_and_chances_are_the_tables(whole):
    found = drawn(card_of("level_effects")(), whole)
    levels, anova = whole.table("tuning", "published_levels"), whole.table("tuning", "published_anova")
    for axes, factor in zip(found.get_axes()[:3], ("c1", "c2", "w"), strict=True):
        line = max(axes.get_lines(), key=lambda line: len(line.get_xdata()))
        np.testing.assert_allclose(line.get_ydata(), levels["mean"][levels["factor"] == factor])
        assert f"p = {anova['p'][anova['source'] == factor][0]:.2f}" in axes.get_title(loc="left")


def test_an_effect_that_may_be_none_is_drawn_dark(whole):
    table = whole.table("search", "comparison")
    axes = drawn(card_of("search_effects")(searches=SEARCHES), whole).get_axes()[2]
    dots = [line for line in axes.get_lines() if len(line.get_xdata()) == 1 and line.get_marker() not in ("None", "")]
    shown = [row for row in range(len(table["first"])) if {table["first"][row], table["second"][row]} <= set(SEARCHES)]
    shown = [row for row in shown if table["measure"][row] == "iterations_to_within_1_hz"]
    assert [line.get_xdata()[0] for line in dots] == [table["larger"][row] for row in shown]
    for line, row in zip(dots, shown, strict=True):
        assert (line.get_marker() == "D") == (table["larger_low"][row] <= 0.5 <= table["larger_high"][row])


def test_the_flow_chart_is_the_settings(whole):
    found = texts(drawn(card_of("algorithm")(), whole))
    for words in ("10 particles", "1 to 500 Hz", "Moved 30 times?", "logistic map", "C1 = 1, C2 = 1, W = 0.75"):
        assert words in found


def test_a_diagram_of_what_is_not_configured_says_so(whole):
    bare = ReportData(whole.inputs, whole.modes, whole.comparisons)
    assert "no swarm" in texts(drawn(card_of("algorithm")(), bare))


@pytest.mark.parametrize("name", sorted(path.stem for path in FIGURES.glob("[!_]*.py")))
def test_every_figure_draws(whole, name):
    options = {"search_effects": {"searches": SEARCHES}, "convergence": {"quantity": "ise"}}.get(name, {})
    assert drawn(card_of(name)(**options), whole).get_axes()
