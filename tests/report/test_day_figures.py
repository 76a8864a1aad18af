"""Figures, tables and sentences of days in the sun, from made-up artefacts."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pipeline import quantity, schemas, schemas_day, tables
from pipeline.report import day_tables
from pipeline.report.draw import draw, module
from tests.report.conftest import cards

OURS = [name for name, card in cards().items() if "day" in card.reads]
SKIES = {"clear": "clear", "overcast": "overcast"}
ROWS = 40


def fill(folder: Path, file: str, table: tables.Table, columns: dict, rows: int) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    kinds = {"number": 1.0, "text": "mode_1"}
    tables.write(table, {c.name: columns.get(c.name, [kinds[c.kind]] * rows) for c in table.columns}, folder / file)


def numbers(folder: Path, **found: float) -> None:
    rows = [quantity.Quantity(name, value, "1", name) for name, value in found.items()]
    tables.write(schemas.QUANTITIES, quantity.columns(rows), folder / "quantities.parquet")


def write(folder: Path, days: dict[str, str]) -> dict[str, Path]:
    """Return the inputs of days on which the modes are done, or not, at noon."""
    inputs = {}
    clock_s = 6 * 3600.0 + 600.0 * np.arange(1, ROWS + 1)
    for place, sky in enumerate(days):
        weather = folder / sky
        fill(weather, "weather.parquet", schemas_day.WEATHER, {"clock_s": clock_s, "interval_s": [600.0] * ROWS}, ROWS)
        missing = {"clock_s": [30600.0, 36000.0], "length_s": [300.0, 900.0], "filled": ["interpolated", "dark"]}
        own = {name: column if place else [] for name, column in missing.items()}
        tables.write(schemas_day.WEATHER_GAPS, own, weather / "gaps.parquet")
        counted = {"gaps": 2.0 * place, "gap_s": 1200.0 * place, "dark_gaps": 1.0 * place, "dark_gap_s": 900.0 * place}
        numbers(weather, irradiation_kwh_m2=7.0 - 5.0 * place, mean_ambient_c=20.0, **counted)
        inputs[f"weather/{sky}"] = weather
        for number, mode in enumerate(("cc_cv", "cv_pulse", "cv_reflex")):
            own = folder / f"{sky}.{mode}"
            states = np.repeat(["off", "mode_1", "mode_2", "ended"], ROWS // 4)
            trace = {"clock_s": clock_s, "interval_s": [600.0] * ROWS, "state": states}
            fill(own, "trace.parquet", schemas_day.DAY_TRACE, trace, ROWS)
            changes = {
                "clock_s": clock_s[:: ROWS // 4],
                "before": ["off", "off", "mode_1", "mode_2"],
                "after": ["off", "mode_1", "mode_2", "ended"],
                "s4_share": [0.0, 0.0, 0.05, 0.0],
                "pulses_hz": [0.0, 0.0, 90.0, 0.0],
                "reason": ["first light", "sun", "elapsed 3600 s", "stop: soc 0.99"],
            }
            fill(own, "switching.parquet", schemas_day.DAY_SWITCHING, changes, 4)
            parts = ("panel", "tracker", "boost", "load", "buck", "resistor", "battery")
            energies = {f"{part}_wh": 10.0 for part in parts} | {"curtailed_wh": 50.0, "stored_wh": 80.0 - number}
            done = {"ended_clock_s": 43200.0} if sky == "clear" else {}
            numbers(
                own, **energies, **done, sun_wh=200.0, end_soc=0.5, charging_s=3.5e3, current_limited_s=1e3,
                voltage_limited_s=1.5e3, supply_limited_s=1e3, peak_temperature_c=27.0,
            )  # fmt: skip
            inputs[f"day/{sky}/{mode}"] = own
    return inputs


@pytest.fixture
def days(whole, tmp_path):
    settings = {"day": {"title": "a day", "weathers": SKIES, "load": "a load", "initial_soc": 0.2}}
    return replace(whole, inputs=whole.inputs | write(tmp_path / "days", SKIES), settings=whole.settings | settings)


@pytest.mark.parametrize("name", OURS)
def test_it_draws(days, whole, tmp_path, name):
    for number, data in enumerate((days, whole)):
        for path in draw(name, cards()[name], data, tmp_path):
            assert path.stat().st_size > 1000, ("with days", "without")[number]


def test_the_bars_are_as_long_as_the_day(days):
    card = cards()["days_limits"]
    figure = module(card).draw(card, days)
    for axes in [one for one in figure.axes if one.axison]:
        ends = [patch.get_x() + patch.get_width() for patch in axes.patches]
        assert max(ends) == pytest.approx(ROWS * 600.0 / 3600.0)


def test_the_bars_split_the_sun(days):
    card = cards()["days_energy"]
    first = next(axes for axes in module(card).draw(card, days).axes if axes.axison)
    lengths = [patch.get_width() for patch in first.patches]
    assert sum(lengths[:9]) == pytest.approx(200.0)


def test_the_tables_hold_every_day_and_mode(days, whole):
    assert day_tables.weathers(whole) == {}
    found = day_tables.numbers(days)
    assert found.header == ("day", "quantity", "CC-CV", "CV-pulse", "CV-Reflex")
    by_name = {(row[0], row[1]): row[2:] for row in found.rows}
    assert by_name["clear", "stored in the battery / Wh"] == (80.0, 79.0, 78.0)
    assert by_name["clear", "ended at / h, local time"] == (12.0, 12.0, 12.0)
    assert by_name["overcast", "ended at / h, local time"] == (None, None, None)
    changes = day_tables.switchings(days)
    assert len(changes.rows) == 2 * 3 * 4
    assert changes.rows[2][2:] == ("09:30:00", "Mode 2", "elapsed 3600 s", "100 %", "100 %", "5 %", 90.0)


def test_gaps_are_listed_where_there_are_some(days, whole):
    (found,) = day_tables.gaps(days)
    assert found.rows == (
        ("overcast", "08:30:00", 300.0, "interpolated"),
        ("overcast", "10:00:00", 900.0, "dark"),
    )
    assert "2 gaps, 1200 s together; 1 of them, 900 s, are too long" in day_tables.text(days)
    assert day_tables.gaps(whole) == []


def test_the_sentences_are_computed(days):
    found = day_tables.text(days)
    assert "CC-CV ends at 12:00 (stop: soc 0.99)" in found
    assert "CV-Reflex reaches 50.0 % by last light" in found
    assert "40 % of it is stored, and for 25 % there is no use" in found


@pytest.mark.parametrize(("seconds", "text"), [(0.0, "00:00:00"), (86399.6, "00:00:00"), (45296.0, "12:34:56")])
def test_the_clock(seconds, text):
    assert day_tables.clock(seconds) == text
