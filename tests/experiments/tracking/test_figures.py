"""Figures, tables and text of trackers and converters, from small artefacts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pipeline.experiments.tracking import page
from pipeline.experiments.tracking.records import CONVERTER_NUMBERS as OF_CONVERTERS
from pipeline.experiments.tracking.records import TRACKING_NUMBERS
from pipeline.report.pages import PageFigure
from pipeline.report.tables import ReportData
from tests import making
from tests.experiments.drawing import cards, drawn, looked_at, saved

TRACKERS = {"perturb_observe": "perturb and observe", "particle_swarm": "particle swarm"}
SETTINGS = {"trackers": TRACKERS, "skies": {"clear": "clear"}}
SHARES = {"perturb_observe": 0.9, "particle_swarm": 0.999}
NAMES = ("tracker_ramp", "tracker_efficiency", "shaded_string", "efficiency_map")


def fill(output, name, rows):
    output.write(name, {column: [row.get(column, 0.5) for row in rows] for column in output.columns(name)})


def write(folder: Path) -> dict[str, Path]:
    rows: dict[str, list] = {"ramps": [], "course": [], "day": [], "shading_curves": [], "shading_ends": []}
    for name, share in SHARES.items():
        for group in ("slow", "fast"):
            for slope in (1.0, 10.0, 100.0):
                missed = 0.01 * slope if name == "perturb_observe" else 0.1
                rows["ramps"].append(
                    {"tracker": name, "group": group, "low_w_m2": 100.0, "high_w_m2": 900.0, "slope_w_m2_s": slope}
                    | {"repetitions": 1, "efficiency": 1.0 - missed / 100.0}
                )
        rows["course"] += [{"tracker": name, "time_s": t, "power_w": 10.0 + t} for t in np.linspace(0.0, 9.0, 30)]
        rows["day"].append({"tracker": name, "sky": "clear", "efficiency": share})
        rows["shading_ends"].append(
            {"scene": "half_shadow", "tracker": name, "voltage_v": 20 * share, "power_w": 30 * share, "best_w": 30.0}
            | {"share": share}
        )
    volts = np.linspace(0.0, 21.0, 50)
    rows["shading_curves"] = [{"scene": "half_shadow", "voltage_v": v, "power_w": 2 * v} for v in volts]
    output = making.output("tracking", folder / "tracking")
    for name, own in rows.items():
        fill(output, name, own)
    output.numbers(
        TRACKING_NUMBERS.quantity(pattern, share, tracker=name)
        for name, share in SHARES.items()
        for pattern in TRACKING_NUMBERS.words
    )
    _converters(folder / "converters")
    return {name: folder / name for name in ("tracking", "converters")}


def _converters(folder: Path) -> None:
    output = making.output("converters", folder)
    voltages = {"boost": [(14.0, 24.0), (17.0, 24.0)], "buck": [(24.0, 12.0), (24.0, 14.0)]}
    rows = [
        {"converter": which, "source_v": source, "sink_v": sink, "power_w": power, "efficiency": 0.9, "core_w": 0.1}
        for which, pairs in voltages.items()
        for source, sink in pairs
        for power in np.geomspace(1.0, 60.0, 9)
    ]
    check = [{"converter": which, "power_w": 30.0, "averaged": 0.95, "switched": 0.9501} for which in voltages]
    fill(output, "efficiency", rows)
    fill(output, "check", check)
    values = {
        "{converter}_full_efficiency": 0.95,
        "{converter}_best_efficiency": 0.96,
        "{converter}_best_w": 20.0,
        "{converter}_off_switched": 1e-4,
    }
    output.numbers(OF_CONVERTERS.quantity(name, value, converter=w) for w in voltages for name, value in values.items())


def supply(folder: Path) -> Path:
    """Write a supply that takes 99 % of the panel's power."""
    output = making.output("supply", folder)
    row = {"panel_power_w": 65.25, "bus_power_w": 0.9405 * 65.25, "boost_efficiency": 0.95, "buck_efficiency": 0.92}
    fill(output, "supply", [row])
    return folder


@pytest.fixture
def whole() -> ReportData:
    """Return a run that tries no trackers."""
    return ReportData(making.inputs({}), {}, {})


@pytest.fixture
def supplied(tmp_path: Path) -> ReportData:
    folders = write(tmp_path / "made") | {"supply": supply(tmp_path / "supply")}
    return ReportData(making.inputs(folders), {}, {}, {"tracking": SETTINGS})


@pytest.mark.parametrize("name", NAMES)
def test_it_draws_with_and_without_artefacts(supplied, whole, tmp_path, name):
    for folder, data in (("with", supplied), ("without", whole)):
        for path in saved(cards()[name], data, tmp_path / folder):
            assert path.stat().st_size > 1000
        assert looked_at(cards()[name], data) == []


def test_every_tracker_has_its_line_and_its_end(supplied):
    ramp = drawn(cards()["tracker_ramp"], supplied)
    assert len(ramp.axes[1].get_lines()) == len(TRACKERS)
    shade = drawn(cards()["shaded_string"], supplied)
    ends = [line for line in shade.axes[0].get_lines() if len(line.get_xdata()) == 1]
    assert [float(line.get_ydata()[0]) for line in ends] == [30.0 * share for share in SHARES.values()]


def test_tables_hold_every_row(supplied, whole):
    assert page.sections(whole, []) == []
    steady, ramps, days, shadows = page.tracking_tables(supplied)
    assert [row[0] for row in steady.rows] == list(TRACKERS.values())
    assert len(ramps.rows) == 3 * 2
    assert [row[-1] for row in days.rows] == [90.0, 99.9]
    assert [row[5] for row in shadows.rows] == [90.0, 99.9]
    assert len(page.converter_check(supplied).rows) == 2
    assert page.converter_check(supplied).rows[0][-1] == pytest.approx(-100.0)
    assert {row[0].split(",")[0] for row in page.converter_table(supplied).rows} == {"boost", "buck"}


def test_the_text_says_who_is_caught(supplied):
    text = page.tracking_text(supplied)
    assert "perturb and observe end below 95 %" in text
    assert "Particle swarm reaches at least 99.9 %" in text
    assert "take 99.00 % of it as configured" in text
    assert "the trackers reach 90.00 to 99.90 % in steady light" in text
    text = page.converter_text(supplied)
    assert "95.0 % at the panel's maximum power" in text
    assert "100 ppm" in text


def test_sections_follow_the_artefacts_and_have_their_figures(supplied, whole):
    assert page.sections(whole, []) == []
    figures = [PageFigure(name, "", name, name, draws=name) for name in NAMES]
    found = page.sections(supplied, figures)
    assert [section.name for section in found] == ["trackers-tried", "converters-by-load"]
    assert [[figure.name for figure in section.figures] for section in found] == [list(NAMES[:3]), [NAMES[3]]]
