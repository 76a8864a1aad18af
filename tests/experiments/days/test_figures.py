"""Figures, tables and sentences of days in the sun, from made-up artefacts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pipeline.experiments.days import page
from pipeline.experiments.days.numbers import DAY_NUMBERS, WEATHER_NUMBERS, weathers
from pipeline.kernel.artefacts import Output
from pipeline.quantity import Vocabulary
from pipeline.report.pages import PageFigure
from pipeline.report.tables import ModeLabel, ReportData
from tests import making
from tests.experiments.drawing import cards, drawn, looked_at, saved

OURS = [name for name, card in cards().items() if card.owner() == "days"]
MODES = {"cc_cv": "CC-CV", "cv_pulse": "CV-pulse", "cv_reflex": "CV-Reflex"}
SKIES = {"clear": "clear", "overcast": "overcast"}
ROWS = 40


def fill(output: Output, name: str, columns: dict, rows: int) -> None:
    texts = {"state": "mode_1"}
    output.write(name, {one: columns.get(one, [texts.get(one, 1.0)] * rows) for one in output.columns(name)})


def numbers(output: Output, vocabulary: Vocabulary, **found: float) -> None:
    output.numbers(vocabulary.quantity(name, value) for name, value in found.items())


def write(folder: Path, days: dict[str, str]) -> dict[str, Path]:
    """Return the inputs of days on which the modes are done, or not, at noon."""
    inputs = {}
    clock_s = 6 * 3600.0 + 600.0 * np.arange(1, ROWS + 1)
    for place, sky in enumerate(days):
        inputs[f"weather/{sky}"] = folder / sky
        output = making.output("weather", folder / sky)
        fill(output, "weather", {"clock_s": clock_s, "interval_s": [600.0] * ROWS}, ROWS)
        missing = {"clock_s": [30600.0, 36000.0], "length_s": [300.0, 900.0], "filled": ["interpolated", "dark"]}
        output.write("gaps", {name: column if place else [] for name, column in missing.items()})
        output.write("notes", {"note": ["taken for TMY3, read by pvlib"] * place})
        inputs[f"daylight/{sky}"] = folder / f"light.{sky}"
        making.output("daylight", folder / f"light.{sky}").write("notes", {"note": ["two rows an hour"]})
        counted = {"gaps": 2.0 * place, "gap_s": 1200.0 * place, "dark_gaps": 1.0 * place, "dark_gap_s": 900.0 * place}
        numbers(output, WEATHER_NUMBERS, irradiation_kwh_m2=7.0 - 5.0 * place, mean_ambient_c=20.0, **counted)
        for number, mode in enumerate(MODES):
            inputs[f"day/{sky}/{mode}"] = folder / f"{sky}.{mode}"
            output = making.output("day", folder / f"{sky}.{mode}")
            states = np.repeat(["off", "mode_1", "mode_2", "ended"], ROWS // 4)
            trace = {"clock_s": clock_s, "interval_s": [600.0] * ROWS, "state": states}
            fill(output, "trace", trace, ROWS)
            changes = {
                "clock_s": clock_s[:: ROWS // 4],
                "before": ["off", "off", "mode_1", "mode_2"],
                "after": ["off", "mode_1", "mode_2", "ended"],
                "s4_share": [0.0, 0.0, 0.05, 0.0],
                "pulses_hz": [0.0, 0.0, 90.0, 0.0],
                "reason": ["first light", "sun", "elapsed 3600 s", "stop: soc 0.99"],
            }
            fill(output, "switching", changes, 4)
            output.write("missed", {"missed": ["reflex never ran"] if mode == "cv_reflex" else []})
            parts = ("panel", "tracker", "boost", "load", "buck", "resistor", "battery")
            energies = {f"{part}_wh": 10.0 for part in parts} | {"curtailed_wh": 50.0, "stored_wh": 80.0 - number}
            done = {"ended_clock_s": 43200.0} if sky == "clear" else {}
            numbers(
                output, DAY_NUMBERS, **energies, **done, sun_wh=200.0, end_soc=0.5, charging_s=3.5e3,
                current_limited_s=1e3, voltage_limited_s=1.5e3, supply_limited_s=1e3, peak_temperature_c=27.0,
            )  # fmt: skip
    return inputs


def data_of(folders: dict[str, Path], **settings) -> ReportData:
    labels = {name: ModeLabel(title) for name, title in MODES.items()}
    return ReportData(making.inputs(folders), labels, {"same_peak": "Same peak current"}, settings)


@pytest.fixture
def whole():
    """Return a run without days."""
    return data_of({})


@pytest.fixture
def days(tmp_path):
    day = {"title": "a day", "weathers": SKIES, "load": "a load", "initial_soc": 0.2}
    return data_of(write(tmp_path / "days", SKIES), day=day)


@pytest.mark.parametrize("name", OURS)
def test_it_draws(days, whole, tmp_path, name):
    for number, data in enumerate((days, whole)):
        for path in saved(cards()[name], data, tmp_path):
            assert path.stat().st_size > 1000, ("with days", "without")[number]
        assert looked_at(cards()[name], data) == []


def test_the_bars_are_as_long_as_the_day(days):
    card = cards()["days_limits"]
    figure = drawn(card, days)
    for axes in [one for one in figure.axes if one.axison]:
        ends = [patch.get_x() + patch.get_width() for patch in axes.patches]
        assert max(ends) == pytest.approx(ROWS * 600.0 / 3600.0)


def test_the_bars_split_the_sun(days):
    card = cards()["days_energy"]
    first = next(axes for axes in drawn(card, days).axes if axes.axison)
    lengths = [patch.get_width() for patch in first.patches]
    assert sum(lengths[:9]) == pytest.approx(200.0)


def test_the_tables_hold_every_day_and_mode(days, whole):
    assert weathers(whole) == {}
    found = page.numbers(days)
    assert found.header == ("day", "quantity", "CC-CV", "CV-pulse", "CV-Reflex")
    by_name = {(row[0], row[1]): row[2:] for row in found.rows}
    assert by_name["clear", "stored in the battery / Wh"] == (80.0, 79.0, 78.0)
    assert by_name["clear", "ended at / h, local time"] == (12.0, 12.0, 12.0)
    assert by_name["overcast", "ended at / h, local time"] == (None, None, None)
    changes = page.switchings(days)
    assert len(changes.rows) == 2 * 3 * 4
    assert changes.rows[2][2:] == ("09:30:00", "Mode 2", "elapsed 3600 s", "100 %", "100 %", "5 %", 90.0)


def test_gaps_are_listed_where_there_are_some(days, whole):
    (found,) = page.gaps(days)
    assert found.rows == (
        ("overcast", "08:30:00", 300.0, "interpolated"),
        ("overcast", "10:00:00", 900.0, "dark"),
    )
    assert "2 gaps, 1200 s together; 1 of them, 900 s, are too long" in page.text(days)
    assert page.gaps(whole) == []


def test_the_page_says_what_the_files_were_taken_for(days):
    (found,) = page.files(days)
    assert found.rows == (
        ("load: a load", "two rows an hour"),
        ("weather: overcast", "taken for TMY3, read by pvlib"),
    )


def test_the_sentences_are_computed(days):
    found = page.text(days)
    assert "CC-CV ends at 12:00 (stop at SOC 99 %)" in found
    assert "CV-Reflex reaches 50.0 % by last light" in found
    assert "CV-Reflex: reflex never ran." in found
    assert "40 % of it is stored, and 25 % is not needed" in found


@pytest.mark.parametrize(("seconds", "text"), [(0.0, "00:00:00"), (86399.6, "00:00:00"), (45296.0, "12:34:56")])
def test_the_clock(seconds, text):
    assert page.clock(seconds) == text


def test_the_section_has_the_figures_and_is_left_out_without_days(days, whole):
    assert page.sections(whole, []) == []
    (found,) = page.sections(days, [PageFigure("days_energy", "", "t", "c")])
    assert found.title == "From sun to battery: a day"
    assert [table.name for table in found.tables] == ["days", "day_switchings", "day_files", "day_gaps"]
    assert [figure.name for figure in found.figures] == ["days_energy"]
