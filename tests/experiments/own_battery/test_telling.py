"""What the page and the terminal say of a fit is what its tables hold."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from pipeline.experiments.own_battery import page, telling
from pipeline.kernel import store
from pipeline.report.tables import ReportData
from tests.making import inputs, output

KEYS = {"own_reading": "0" * 64, "own_fit": "1" * 64}
NAMES = ("seen.csv", "evening.csv", "night.csv")
ERRORS = [
    ("fit", 0, "voltage", "V", 0.004, 0.008, 0.02, 60.0, 1000),
    ("held out", 1, "voltage", "V", 0.147, 0.2, 0.3, 7200.0, 500),
    ("held out", 2, "voltage", "V", 0.05, 0.09, 0.1, 1800.0, 500),
    ("held out", 1, "temperature", "K", 0.4, 0.6, 1.1, 3600.0, 500),
]
LIMITS = [
    (1, "the charge at its start", 0.09),
    (1, "the resistances", 0.14),
    (1, "the charge at its start and the open-circuit voltage", 0.032),
    (2, "the charge at its start", 0.049),
    (2, "the resistances", 0.011),
    (2, "the charge at its start and the open-circuit voltage", 0.04),
]
PARAMETERS = ("capacity_ah", "pairs.fast.tau_s", "open_circuit_voltage_v.value.0")


@pytest.fixture
def run(tmp_path: Path) -> dict[str, Any]:
    """A run whose reading and fit are in the store of a folder."""
    reading = output("own_reading", store.artefact(tmp_path, "own_reading", KEYS["own_reading"]))
    reading.rows("files", [(n, name, 500, 1.0, 1.0, 0.5, False, 22.0) for n, name in enumerate(NAMES)])
    fit = output("own_fit", store.artefact(tmp_path, "own_fit", KEYS["own_fit"]))
    fit.rows("errors", ERRORS)
    fit.rows("limits", LIMITS)
    columns = fit.empty("parameters")
    for path, identified in zip(PARAMETERS, (True, False, False), strict=True):
        row = {"path": path, "identified": identified, "how": "keeps the start card's" if not identified else "fitted"}
        for name, column in columns.items():
            column.append(row.get(name, "" if name == "unit" else 1.0))
    fit.write("parameters", columns)
    nodes = {step: {"step": step, "key": key} for step, key in KEYS.items()}
    return {"study": "own_battery", "name": "default", "nodes": nodes}


def test_the_terminal_says_what_was_met_what_limits_it_and_where_the_card_is(
    run: dict[str, Any], tmp_path: Path
) -> None:
    assert list(telling.lines(run, {"own_fit"}, tmp_path)) == [
        "fit: voltage of seen.csv met to 4 mV (rmse)",
        "held out: voltage of evening.csv met to 147 mV (rmse)",
        "held out: voltage of night.csv met to 50 mV (rmse)",
        "held out, evening.csv, with the charge at its start found from it: 90 mV",
        "held out, evening.csv, with the resistances found from it: 140 mV",
        "held out, evening.csv, with the charge at its start and the open-circuit voltage found from it: 32 mV",
        "held out, night.csv, with the charge at its start found from it: 49 mV",
        "held out, night.csv, with the resistances found from it: 11 mV",
        "held out, night.csv, with the charge at its start and the open-circuit voltage found from it: 40 mV",
        "not told by the measurement: pairs.fast.tau_s",
        f"the card: {tmp_path / 'own_battery' / 'default' / 'battery.yaml'}",
    ]


def test_the_terminal_is_silent_about_a_fit_that_was_not_asked_for_or_is_not_there(
    run: dict[str, Any], tmp_path: Path
) -> None:
    assert list(telling.lines(run, {"own_reading"}, tmp_path)) == []
    assert list(telling.lines(run, {"own_fit"}, tmp_path / "elsewhere")) == []


def test_the_page_says_of_each_file_which_part_of_the_card_limits_it(run: dict[str, Any], tmp_path: Path) -> None:
    folders = {step: store.artefact(tmp_path, step, key) for step, key in KEYS.items()}
    (table,) = page._limits(ReportData(inputs(folders), {}, {}))
    assert [row[:2] for row in table.rows if "nothing" in str(row[1])] == [
        ("evening.csv", "nothing: the prediction"),
        ("night.csv", "nothing: the prediction"),
    ]
    assert "evening.csv: of single parts the charge at its start matters most, 147 mV become 90 mV" in table.caption
    assert "night.csv: of single parts the resistances matter most, 50 mV become 11 mV" in table.caption
    # Half of the error or more is left of neither file: no other form of a curve is called for.
    assert "own_battery.open_circuit_points" not in table.caption
