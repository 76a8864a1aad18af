"""Efficiencies: none where nothing went in; that of the system counts what the resistor takes."""

import numpy as np
import pytest

from pipeline.charge.records import Mode
from pipeline.charge.simulate import Supply
from tests.charge.samples import battery, charge, load, settings, values


def test_there_is_none_where_nothing_went_in():
    mode = Mode(**(load("modes/cc_cv.yaml") | {"stop": {"elapsed_s": 60}}))
    dark = Supply(np.zeros(1), np.zeros(1))
    found = values(charge(battery("lead_acid_12v7ah"), mode, settings(0.5), dark))
    for name in ("charge_efficiency", "energy_efficiency", "system_efficiency"):
        assert found[name] is None


def test_the_system_pays_for_what_the_resistor_takes():
    sheet = load("modes/cv_reflex.yaml")
    sheet.pop("max_current_a")
    sheet |= {"phases": {"reflex": sheet["phases"]["reflex"]}, "stop": {"elapsed_s": 20}}
    found = values(charge(battery("lead_acid_12v7ah"), Mode(**sheet), settings(0.5)))
    net = found["energy_in_wh"] - found["energy_out_wh"]
    gained = found["energy_efficiency"] * net
    assert found["system_efficiency"] == pytest.approx(gained / found["energy_in_wh"], rel=1e-12)
    assert found["system_efficiency"] < found["energy_efficiency"]


def test_converters_and_side_loads_are_paid_for_too():
    """From a panel: a watt into the battery costs 1 / (0.95 x 0.92) W, and 20 W are served meanwhile."""
    sheet = load("modes/cc_cv.yaml") | {"stop": {"elapsed_s": 900}}
    times = np.array([0.0, 300.0, 600.0])
    per_w, side_w = np.array([1.0, 2.0, 1.0]) / (0.95 * 0.92), np.array([20.0, 0.0, 10.0]) / 0.95
    supply = Supply(times, np.full(3, 30.0), per_w, side_w)
    made = charge(battery("lead_acid_12v7ah"), Mode(**sheet), settings(0.5, sample_interval_s=100.0), supply)
    found = values(made)
    put_in = np.diff(np.append(0.0, made.trace["Charging Energy / Wh"]))
    drawn_wh = np.sum(put_in.reshape(3, 3).sum(axis=1) * per_w) + np.sum(side_w) * 300.0 / 3600.0
    assert found["energy_drawn_wh"] == pytest.approx(drawn_wh, rel=1e-12)
    gained = found["energy_efficiency"] * found["energy_in_wh"]
    assert found["system_efficiency"] == pytest.approx(gained / drawn_wh, rel=1e-12)
    plain = values(charge(battery("lead_acid_12v7ah"), Mode(**sheet), settings(0.5), Supply(times, np.full(3, 30.0))))
    assert plain["energy_drawn_wh"] == pytest.approx(plain["energy_in_wh"], rel=1e-12)
    assert plain["end_soc"] == pytest.approx(found["end_soc"], abs=1e-9)
