"""The tail of a lead-acid charge against what makers print of it.

Panasonic, "Methods of Charging the Valve-Regulated Lead-Acid Battery", main power (cycle use), 20 to 25 degC: at most
0.4 CA and 2.45 V a cell; complete when the current has been stable for three hours, which takes 6 to 12 hours depending
on the discharge before (https://studylib.net/doc/18081116). Remco, charging instructions of its VRLA batteries: about
110 % of what was discharged goes back in until full (http://www.remcobattery.com/fp_PD_8TIPS.php).
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import pipeline
from pipeline.charge.records import Mode

STABLE_H = 3.0
STABLE_SHARE = 0.05
"""How far from its last value a stable current may be: a reading of the sheet, which gives none."""


def _tail(battery: str, initial_soc: float) -> tuple[Any, float]:
    """Return the trace of twelve hours as the sheet says, and the hour at which it calls the charge complete."""
    cc_cv = pipeline.mode("cc_cv")
    capacity = pipeline.battery(battery).capacity_in_use_ah
    sheet = {"max_current_a": 0.4 * capacity, "voltage_v": 6 * 2.45, "stop": {"elapsed_s": 12 * 3600}}
    charge = pipeline.charge(
        battery, Mode.model_validate({**cc_cv.model_dump(exclude_unset=True), **sheet}), initial_soc=initial_soc
    )
    hours, current = charge.trace["Test Time / s"] / 3600, charge.trace["Current / A"]
    moving = np.flatnonzero(np.abs(current / current.iloc[-1] - 1) > STABLE_SHARE)
    return charge.trace, float(hours.iloc[moving[-1]]) + STABLE_H


@pytest.mark.parametrize("battery", ["lead_acid_12v7ah", "lead_acid_12v18ah"])
@pytest.mark.parametrize("initial_soc", [0.05, 0.2, 0.5])
def test_a_cycle_charge_is_complete_when_the_sheet_says(battery: str, initial_soc: float) -> None:
    _, complete_h = _tail(battery, initial_soc)
    assert 6 <= complete_h <= 12


@pytest.mark.parametrize("battery", ["lead_acid_12v7ah", "lead_acid_12v18ah"])
def test_the_overcharge_of_the_sheet_is_not_reached(battery: str) -> None:
    """What the statement on overcharging says: the model takes a few percent where the sheet says ten."""
    trace, _ = _tail(battery, 0.2)
    returned = trace["Charging Capacity / Ah"].iloc[-1]
    stored = (trace["soc"].iloc[-1] - 0.2) * pipeline.battery(battery).capacity_in_use_ah
    assert 1.02 < returned / stored < 1.05
