"""The checks themselves: their bounds hold, and a mistake breaks them."""

from __future__ import annotations

import importlib
from pathlib import Path

import numpy as np
import pytest

from pipeline.cell.records import Battery
from pipeline.charge.records import Mode
from pipeline.experiments.validation import against_ngspice, exact, first_law, order, plain
from pipeline.experiments.validation.common import by_engine, cases, circuit, differences, reduced, thinned
from pipeline.experiments.validation.plain import suited
from pipeline.experiments.validation.records import Conditions, Found
from pipeline.experiments.validation.registry import installed
from tests.charge.samples import battery, load

LEAD = battery("lead_acid_12v7ah")
CONDITIONS = {"current_c_rate": 0.3, "voltage_v": 14.4, "initial_soc": 0.8}
PEERS = {
    "current_c_rate": 0.3,
    "held_voltage_v": 12.84,
    "initial_soc": 0.6,
    "ambient_c": 25.0,
    "battery": LEAD.model_dump(mode="json"),
}


def findings(found: Found) -> set[str]:
    return {row.finding for row in found.rows}


@pytest.mark.parametrize("check", [exact.check, order.check])
def test_its_bounds_hold(check) -> None:
    found = check({})
    assert findings(found) <= {"holds", "told"}, [row for row in found.rows if row.finding == "broken"]
    assert all(len(curve.x) == len(curve.y) > 1 for curve in found.curves)


def test_a_wrong_closed_form_is_broken(monkeypatch) -> None:
    monkeypatch.setattr(plain, "OHM", 0.05 * (1 + 1e-6))
    cell = plain.battery()
    monkeypatch.setattr(plain, "battery", lambda *_, **__: cell)
    monkeypatch.setattr(plain, "OHM", 0.05)
    broken = {row.quantity for row in exact.check({}).rows if row.finding == "broken"}
    assert {"adiabatic heating, edge", "adiabatic heating, averaged", "RC step, edge"} <= broken


def first_law_settings(names: list[str], **more) -> dict:
    return {
        "duration_s": 60.0,
        "bulk_s": 20.0,
        "batteries": {"lead": LEAD.model_dump(mode="json")},
        "conditions": {"lead": CONDITIONS},
        "modes": {name: Mode(**load(f"modes/{name}.yaml")).model_dump(mode="json", by_alias=True) for name in names},
    } | more


def test_the_first_law_closes_and_shows_every_mistake() -> None:
    found = first_law.check(first_law_settings(["cv_reflex", "staged_printed"]))
    assert findings(found) == {"holds"}
    mistakes = [row.quantity for row in found.rows if row.quantity.startswith(first_law.MISTAKE)]
    assert len(mistakes) == 4
    assert len(found.rows) == 4 + len(mistakes)


def test_every_battery_needs_its_conditions() -> None:
    with pytest.raises(ValueError, match="conditions are given for other; needed are those of lead"):
        first_law.check(first_law_settings(["cc_cv"], conditions={"other": CONDITIONS}))


@pytest.mark.parametrize("name", ["cc_cv", "cv_reflex", "staged_printed", "constant_4c", "plain_rule"])
def test_a_suited_mode_has_the_current_and_limit_it_is_given(name: str) -> None:
    lithium = battery("lfp_8ah")
    conditions = Conditions(current_c_rate=2.0, voltage_v=3.42, initial_soc=0.15)
    mode = suited(Mode(**load(f"modes/{name}.yaml")), lithium, conditions, 20.0, 200.0)
    settings = plain.ChargeSettings(initial_soc=0.15, ambient_c=25.0, sample_interval_s=1.0)
    charge = plain.simulate(lithium, mode, plain.BENCH, settings, plain.EngineSettings())
    assert np.max(charge.trace["current_max_a"]) == pytest.approx(16.0, rel=1e-9)
    assert plain.number(charge, "end_time_s") == 200.0
    assert set(mode.stop.model_dump(exclude_none=True)) == {"elapsed_s"}


@pytest.mark.parametrize("name", ["against_pybamm", "against_ngspice"])
def test_a_code_that_is_not_installed_breaks_nothing(name: str) -> None:
    found = importlib.import_module(f"pipeline.experiments.validation.{name}").check(PEERS | {"version": None})
    assert findings(found) == {"not installed"}
    assert len(found.rows) == 9
    assert not found.curves


@pytest.mark.parametrize(("name", "peer"), [("against_pybamm", "pybamm"), ("against_ngspice", "ngspice")])
def test_a_code_that_is_installed_agrees(name: str, peer: str) -> None:
    version = installed(peer)
    if version is None:
        pytest.skip(f"{peer} is not installed")
    found = importlib.import_module(f"pipeline.experiments.validation.{name}").check(PEERS | {"version": version})
    assert findings(found) <= {"holds", "told"}, [row for row in found.rows if row.finding == "broken"]


def test_another_circuit_differs_by_more_than_the_bounds() -> None:
    cell = reduced(LEAD)
    other = cell.model_copy(update={"thermal": cell.thermal.model_copy(update={"heat_capacity_j_k": 2100.5})})
    case = cases(2.1, 12.84, 0.6, 25.0)[0]
    gaps = differences(by_engine(cell, case), by_engine(other, case))
    assert np.max(np.abs(gaps["temperature"])) > 1e-5


def test_the_common_model_is_taken_from_the_battery() -> None:
    own = circuit(reduced(LEAD))
    assert own.capacity_ah == 7.0
    assert own.pair_tau_s == (0.006, 0.6)
    assert own.heat_capacity_j_k * own.cells == 2100.0
    with pytest.raises(ValueError, match="constant or linear"):
        reduced(battery("lfp_8ah"))


def test_the_deck_holds_the_parameters() -> None:
    own, (steady, held, pulsed) = circuit(reduced(LEAD)), cases(2.1, 12.84, 0.6, 25.0)
    text = {case.name: against_ngspice.deck(own, case, 0.01, Path("out.txt")) for case in (steady, held, pulsed)}
    assert "Vcur cur 0 2.1" in text["CC"]
    assert "min(2.1,(2.14-" in text["CC-CV"]
    assert "PULSE(2.1 0 " in text["pulse"]
    for one in text.values():
        assert "Cp1 p1 0 2.4 " in one
        assert "wrdata out.txt v(term) v(soc) v(heat)" in one


def test_ngspice_that_fails_says_so(monkeypatch, tmp_path) -> None:
    program = tmp_path / "ngspice"
    program.write_text("#!/bin/sh\necho timestep too small\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:/usr/bin:/bin")
    with pytest.raises(RuntimeError, match="timestep too small"):
        against_ngspice.charged(circuit(reduced(LEAD)), cases(2.1, 12.84, 0.6, 25.0)[0], np.array([1.0]))


def test_thinning_keeps_the_largest() -> None:
    time = np.arange(1000.0)
    values = np.zeros(1000)
    values[123] = -5.0
    kept_time, kept = thinned(time, values, most=10)
    assert len(kept) == 10
    assert kept[1] == -5.0
    assert kept_time[1] == 123.0


def test_the_plain_battery_is_plain() -> None:
    assert isinstance(plain.battery(), Battery)
    assert plain.pulsed_rise(0.0, 1.0, 1e-3, 1e6) == pytest.approx(0.0, abs=1e-6)
    assert plain.pulsed_rise(0.0, 1.0, 1e9, 1e12) == pytest.approx(plain.SHARE, rel=1e-6)
