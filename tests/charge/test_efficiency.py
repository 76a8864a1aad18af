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
