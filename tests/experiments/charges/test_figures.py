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
from tests import making
from tests.experiments.charges.artefacts import MODES, charge
from tests.experiments.drawing import CONF, cards, drawn, saved
from tests.experiments.looking import faults, shows_published

UNIT = re.compile(
    r"\[(A|V|W|mW|mΩ|mV/K|µJ|Wh|F|Hz|%|% of the input|h|min|s|ms|W/m²/s|°C|K|"
    r"nat|nat per step|mW² s|percentage points)\]"
)
COUNTED = re.compile(
    "(Parameter r|Values? (of the map|at r = 4)|Step|Density|Iterations?|C1|C2|W|Mean ISE|Rank|Mean rank|Searches|"
    "Chance|Table 2 as printed)"
)
"""What has no unit: numbers and ratios."""
DIAGRAMS = {"algorithm", "circuit"}


def test_figures_of_charges_draw_on_every_kind_of_run(name, card, data):
    drawing = drawn(card, data)
    units_stand_on_the_axes(name, card, drawing)
    with style.active():
        assert faults(drawing) == []


def units_stand_on_the_axes(name, card, found) -> None:
    fields = found.get_axes()
    assert fields
    if card.draw in DIAGRAMS:
        assert len(fields[0].texts) > 5, name
        return
    across = [axes.get_xlabel() for axes in fields]
    vertical = [axes.get_ylabel() for axes in fields] + [found.get_supylabel()]
    named = [label.get_text() for axes in fields for label in axes.get_yticklabels()]  # bars bear names instead
    assert any(across), name
    assert any(vertical) or any(re.search("[A-Za-z]", text) for text in named), name
    for label in (*across, *vertical):
        is_mode = label.split("\n")[0] in {"CC-CV", "CV-pulse", "CV-Reflex"}
        assert not label or is_mode or UNIT.search(label) or COUNTED.match(label), label


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
    with style.active():
        assert faults(drawing) == []
    assert shows_published(drawing) or not any(option.startswith("published") for option in card.options)
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


def lines_of(axes):
    return [line for line in axes.get_lines() if len(line.get_xdata()) > 2 and line.get_linestyle() != "None"]


def test_the_lines_are_the_traces(whole):
    found = drawn(card_of("over_time")(quantity="soc"), whole)
    for axes, comparison in zip(found.get_axes(), whole.comparisons, strict=True):
        for line, mode in zip(lines_of(axes), whole.modes, strict=True):
            trace = whole.charge(comparison, mode, "trace")
            np.testing.assert_allclose(line.get_ydata(), 100 * trace["soc"])
            np.testing.assert_allclose(line.get_xdata(), trace["Test Time / s"] / 3600)


@pytest.mark.parametrize(("quantity", "unit"), [("soc", "percentage points"), ("temperature", "K"), ("voltage", "V")])
def test_where_the_curves_of_a_later_comparison_coincide_the_lines_are_their_differences(whole, quantity, unit):
    first, second = whole.comparisons
    names = {f"charge/{first}/{mode}": f"charge/{first}/{mode}" for mode in whole.modes}
    names |= {f"charge/{second}/{mode}": f"charge/{second}/cc_cv" for mode in whole.modes}
    alike = ReportData(whole.inputs.renamed(names), whole.modes, whole.comparisons, whole.settings)
    above, below = drawn(card_of("over_time")(quantity=quantity), alike).get_axes()
    assert "Less" not in above.get_ylabel()
    assert below.get_ylabel() == f"Difference from\nCC-CV [{unit}]"
    assert len(lines_of(below)) == 2
    for line in lines_of(below):
        np.testing.assert_allclose(line.get_ydata(), 0.0, atol=1e-12)


def test_ends_of_another_comparison_stand_as_open_symbols_on_the_curves(whole, tmp_path):
    second = list(whole.comparisons)[1]
    charge(tmp_path / "short", MODES["cv_pulse"][1], stop_s=7200.0)
    folders = dict(whole.inputs) | {f"charge/{second}/cv_pulse": tmp_path / "short"}
    data = ReportData(making.inputs(folders), whole.modes, whole.comparisons, whole.settings)
    (axes,) = drawn(card_of("over_time")(quantity="temperature", ends_of=second), data).get_axes()
    (mark,) = (line for line in axes.get_lines() if line.get_markerfacecolor() == "white")
    short = data.charge(second, "cv_pulse", "trace")
    assert mark.get_xdata() == pytest.approx(short["Test Time / s"][-1:] / 3600.0)
    assert mark.get_ydata() == pytest.approx(short["Surface Temperature / degC"][-1:])


def test_a_jump_within_an_interval_stands_where_its_mean_says():
    ends, means = np.arange(10.0, 70.0, 10.0), np.array([4.0, 4.0, 3.0, 2.0, 2.0, 1.0])
    low, high = means.copy(), means.copy()
    low[2], high[2] = 2.0, 4.0
    times, values = style.stepped(ends, means, low, high)
    np.testing.assert_allclose(times, [0, 5, 15, 25, 25, 35, 45, 50, 50, 55, 60])
    np.testing.assert_allclose(values, [4, 4, 4, 4, 2, 2, 2, 2, 1, 1, 1])
    assert np.trapezoid(values, times) == pytest.approx(np.sum(means * 10.0), rel=1e-12)


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
    for axes, comparison in zip(found.get_axes()[::2], whole.comparisons, strict=True):
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
