"""Figures, tables and text of the solar supply, from small artefacts."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pipeline import quantity, schemas_supply, tables
from pipeline.report import converter_tables, supply_tables
from pipeline.report.draw import draw, module
from pipeline.report.supply_sections import sections
from tests.report.conftest import cards

TRACKERS = {"perturb_observe": "perturb and observe", "particle_swarm": "particle swarm"}
SETTINGS = {"trackers": TRACKERS, "skies": {"clear": "clear"}}
SHARES = {"perturb_observe": 0.9, "particle_swarm": 0.999}
NAMES = ("tracker_ramp", "tracker_efficiency", "shaded_string", "efficiency_map")


def columns(table, rows):
    return {column.name: [row.get(column.name, 0.5) for row in rows] for column in table.columns}


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
    for name, own in rows.items():
        file, table = schemas_supply.ARTEFACTS["tracking", name]
        (folder / "tracking").mkdir(parents=True, exist_ok=True)
        tables.write(table, columns(table, own), folder / "tracking" / file)
    keys = ("steady_efficiency", "ripple_v", "ripple_w", "start_s", "step_s", "ramps_efficiency", "worst_ramp")
    found = [quantity.Quantity(f"{name}_{key}", share, "1", "") for name, share in SHARES.items() for key in keys]
    file, table = schemas_supply.ARTEFACTS["tracking", "quantities"]
    tables.write(table, quantity.columns(found), folder / "tracking" / file)
    _converters(folder / "converters")
    return {name: folder / name for name in ("tracking", "converters")}


def _converters(folder: Path) -> None:
    folder.mkdir(parents=True)
    voltages = {"boost": [(14.0, 24.0), (17.0, 24.0)], "buck": [(24.0, 12.0), (24.0, 14.0)]}
    rows = [
        {"converter": which, "source_v": source, "sink_v": sink, "power_w": power, "efficiency": 0.9, "core_w": 0.1}
        for which, pairs in voltages.items()
        for source, sink in pairs
        for power in np.geomspace(1.0, 60.0, 9)
    ]
    check = [{"converter": which, "power_w": 30.0, "averaged": 0.95, "switched": 0.9501} for which in voltages]
    for name, own in (("efficiency", rows), ("check", check)):
        file, table = schemas_supply.ARTEFACTS["converters", name]
        tables.write(table, columns(table, own), folder / file)
    numbers = [
        quantity.Quantity(f"{which}_{name}", value, "1", "")
        for which in voltages
        for name, value in (
            ("full_efficiency", 0.95),
            ("best_efficiency", 0.96),
            ("best_w", 20.0),
            ("off_switched", 1e-4),
        )
    ]
    file, table = schemas_supply.ARTEFACTS["converters", "quantities"]
    tables.write(table, quantity.columns(numbers), folder / file)


@pytest.fixture
def supplied(whole, tmp_path):
    return replace(
        whole, inputs=whole.inputs | write(tmp_path / "made"), settings=whole.settings | {"tracking": SETTINGS}
    )


@pytest.mark.parametrize("name", NAMES)
def test_it_draws_with_and_without_artefacts(supplied, whole, tmp_path, name):
    for folder, data in (("with", supplied), ("without", whole)):
        (tmp_path / folder).mkdir()
        for path in draw(name, cards()[name], data, tmp_path / folder):
            assert path.stat().st_size > 1000


def test_every_tracker_has_its_line_and_its_end(supplied):
    ramp = module(cards()["tracker_ramp"]).draw(cards()["tracker_ramp"], supplied)
    assert len(ramp.axes[1].get_lines()) == len(TRACKERS)
    shade = module(cards()["shaded_string"]).draw(cards()["shaded_string"], supplied)
    ends = [line for line in shade.axes[0].get_lines() if len(line.get_xdata()) == 1]
    assert [float(line.get_ydata()[0]) for line in ends] == [30.0 * share for share in SHARES.values()]


def test_tables_hold_every_row(supplied, whole):
    assert supply_tables.tracking_tables(whole) == []
    steady, ramps, days, shadows = supply_tables.tracking_tables(supplied)
    assert [row[0] for row in steady.rows] == list(TRACKERS.values())
    assert len(ramps.rows) == 3 * 2
    assert [row[-1] for row in days.rows] == [90.0, 99.9]
    assert [row[5] for row in shadows.rows] == [90.0, 99.9]
    assert len(converter_tables.converter_check(supplied).rows) == 2
    assert converter_tables.converter_check(supplied).rows[0][-1] == pytest.approx(-100.0)
    assert {row[0].split(",")[0] for row in converter_tables.converter_table(supplied).rows} == {"boost", "buck"}


def test_the_text_says_who_is_caught(supplied):
    text = supply_tables.tracking_text(supplied)
    assert "perturb and observe end below 95 %" in text
    assert "Particle swarm reaches at least 99.9 %" in text
    assert "take 99.00 % of it as configured" in text
    assert "the trackers reach 90.00 to 99.90 % in steady light" in text
    text = converter_tables.converter_text(supplied)
    assert "95.0 % at the panel's maximum power" in text
    assert "100 ppm" in text


def test_sections_follow_the_artefacts(supplied, whole, tmp_path):
    assert sections(whole, [], []) == []
    file, table = schemas_supply.ARTEFACTS["panel", "fit"]
    (tmp_path / "panel").mkdir()
    rows = [{"quantity": "maximum power", "unit": "W", "data_sheet": 65.0, "model": 65.25}]
    tables.write(table, columns(table, rows), tmp_path / "panel" / file)
    found = sections(replace(supplied, inputs=supplied.inputs | {"panel": tmp_path / "panel"}), [], [])
    assert [section.name for section in found] == ["panel-model", "trackers-tried", "converters-by-load"]
    assert found[0].tables[0].rows[0][-1] == pytest.approx(100.0 * 0.25 / 65.0)
