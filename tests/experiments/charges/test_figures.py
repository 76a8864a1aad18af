"""Every figure on every kind of run: it draws, its axes carry units, its files are the same twice."""

from __future__ import annotations

import itertools
import re

import numpy as np
import pytest

from pipeline.kernel import registry
from pipeline.report import style
from pipeline.report.records import FigureCard
from pipeline.report.tables import ReportData
from tests.experiments.drawing import CONF, cards, drawn, saved

UNIT = re.compile(r"\[(A|V|W|mW|µJ|Wh|F|Hz|%|h|s|ms|W/m²/s|°C|1|nat|nat per step|mW² s)\]")
DIAGRAMS = {"algorithm", "circuit"}


def test_figures_of_charges_draw_on_every_kind_of_run(name, card, data):
    units_stand_on_the_axes(name, card, drawn(card, data))


def units_stand_on_the_axes(name, card, found) -> None:
    fields = found.get_axes()
    assert fields
    if card.draw in DIAGRAMS:
        assert len(fields[0].texts) > 5, name
        return
    assert any(UNIT.search(axes.get_xlabel()) for axes in fields), name
    vertical = [axes.get_ylabel() for axes in fields] + [found.get_supylabel()]
    named = [label.get_text() for axes in fields for label in axes.get_yticklabels()]  # bars bear names instead
    assert any(UNIT.search(label) for label in vertical) or any(re.search("[A-Za-z]", text) for text in named), name


def test_axes_stand_on_rounded_places_whatever_the_layout_solver_left(tmp_path):
    with style.active():
        drawing = style.figure(3.0)
        drawing.subplots(2, 2)
        style.save(drawing, tmp_path, "f")
    edges = [edge for axes in drawing.axes for edge in axes.get_position().bounds]
    assert len(edges) == 16
    assert edges == pytest.approx([round(edge, 6) for edge in edges], abs=1e-15, rel=0.0)


def test_every_figure_has_units_on_its_axes_and_is_the_same_bytes_twice(name, card, whole, tmp_path):
    (tmp_path / "first").mkdir()
    with style.active():
        drawing = card.drawing().draw(card, whole)
        first = style.save(drawing, tmp_path / "first", name)
    units_stand_on_the_axes(name, card, drawing)
    fresh = ReportData(whole.inputs, whole.modes, whole.comparisons, whole.settings)
    second = saved(card, fresh, tmp_path / "second", name)
    assert [path.name for path in first] == [f"{name}.svg", f"{name}.png"]
    for one, other in zip(first, second, strict=True):
        assert one.read_bytes() == other.read_bytes()
    text = first[0].read_text()
    assert "<dc:date>" not in text
    assert str(tmp_path) not in text
    assert b"Software" not in first[1].read_bytes()[:400]


def test_every_drawing_module_is_drawn_by_a_card():
    studies = [path.stem for path in (CONF / "report").glob("*.yaml")]
    assert {card.draw for study in studies for card in cards(study).values()} == set(registry.figures())


def card_of(name):
    return lambda **more: FigureCard(draw=name, title="t", caption="c", options=more)


def test_the_lines_are_the_traces(whole):
    found = drawn(card_of("over_time")(quantity="soc"), whole)
    for axes, comparison in zip(found.get_axes(), whole.comparisons, strict=True):
        lines = [line for line in axes.get_lines() if len(line.get_xdata()) > 2]
        assert len(lines) == len(whole.modes)
        for line, mode in zip(lines, whole.modes, strict=True):
            trace = whole.charge(comparison, mode, "trace")
            np.testing.assert_allclose(line.get_ydata(), 100 * trace["soc"])
            np.testing.assert_allclose(line.get_xdata(), trace["Test Time / s"] / 3600)


def test_times_in_which_the_supply_limits_are_underlined(whole, limited):
    card = card_of("over_time")(quantity="current")
    said = [
        [text.get_text() for axes in drawn(card, data).get_axes() for text in axes.texts] for data in (whole, limited)
    ]
    assert said == [[], ["limited by the supply"] * 2]


def test_a_band_over_fewer_rows_keeps_every_extreme():
    from pipeline.experiments.charges.figures.over_time import _blocks

    rng = np.random.default_rng(3)
    low, high = rng.normal(size=(2, 100_003))
    hours, lows, highs = _blocks(np.arange(100_003.0), low, high)
    assert len(hours) <= 600
    assert lows.min() == low.min()
    assert highs.max() == high.max()


def test_the_bars_of_energy_add_up_to_the_table(whole):
    found = drawn(card_of("energy")(), whole)
    for axes, comparison in zip(found.get_axes(), whole.comparisons, strict=True):
        for place, mode in enumerate(whole.modes):
            bars = [bar for bar in axes.patches if abs(bar.get_y() + bar.get_height() / 2 - place) < 0.1]
            energy = whole.charge(comparison, mode, "energy")
            expected = energy["energy_j"][energy["role"] == "loss"].sum() / 3600
            assert sum(bar.get_width() for bar in bars) == pytest.approx(expected, rel=1e-12)


def test_the_cascade_of_powers_ends_at_the_battery(whole):
    bars = drawn(card_of("supply")(), whole).get_axes()[0].patches
    widths = [bar.get_width() for bar in bars]
    assert widths[0] - sum(widths[1:-1]) == pytest.approx(widths[-1], rel=1e-12)
    for upper, lower in itertools.pairwise(bars[1:-1]):
        assert upper.get_x() == pytest.approx(lower.get_x() + lower.get_width(), rel=1e-12)


def test_the_reflex_intervals_are_the_knobs(whole):
    axes = drawn(card_of("reflex_waveform")(mode="cv_reflex", periods=1), whole).get_axes()[0]
    line = max(axes.get_lines(), key=lambda line: len(line.get_xdata()))
    time, current = np.array(line.get_xdata()), np.array(line.get_ydata())
    charge_ms = np.ptp(time[current == 2.1])
    discharge_ms = np.ptp(time[current == -0.5])
    assert charge_ms == pytest.approx(0.9 * 1000 / 90)
    assert discharge_ms == pytest.approx(0.05 * 1000 / 90)
    assert time.max() == pytest.approx(1000 / 90)


def test_a_mode_that_is_not_in_the_run_is_said_in_the_field(whole):
    axes = drawn(card_of("reflex_waveform")(mode="cv_reflx"), whole).get_axes()[0]
    assert "mode cv_reflx is not in this run" in {text.get_text() for text in axes.texts}


def test_modes_differ_in_colour_line_and_marker():
    found = style.marks([f"mode {number}" for number in range(7)])
    for kind in range(3):
        assert len({str(mark[kind]) for mark in found.values()}) == 7
    assert style.marks(["a", "b"])["b"] == style.marks(["c", "b", "d"])["b"]


def test_a_users_settings_change_nothing(whole, tmp_path):
    import matplotlib

    card = card_of("over_time")(quantity="current")
    saved(card, whole, tmp_path / "plain", "f")
    with matplotlib.rc_context({"lines.linewidth": 9.0, "font.size": 30.0, "svg.fonttype": "none"}):
        saved(card, whole, tmp_path / "changed", "f")
        assert matplotlib.rcParams["lines.linewidth"] == 9.0
    for ending in ("svg", "png"):
        assert (tmp_path / "plain" / f"f.{ending}").read_bytes() == (tmp_path / "changed" / f"f.{ending}").read_bytes()
