"""Converters, batteries and references that several tests use."""

from __future__ import annotations

from typing import Any

import numpy as np

from pipeline.converter.records import CurrentControl, SwitchedBoost, SwitchedBuck
from pipeline.converter.topologies import BatteryLoad

BUS_V = 24.0
BATTERY = BatteryLoad(13.2, 0.0287, 0.015, 0.006)
_COMMON: dict[str, Any] = {
    "rectifier": "diode_emulated",
    "switching_frequency_hz": 5e4,
    "on_resistance_ohm": 0.03,
    "rectifier_resistance_ohm": 0.04,
    "rectifier_voltage_v": 0.35,
    "inductance_h": 220e-6,
    "inductor_resistance_ohm": 0.08,
    "capacitance_f": 330e-6,
    "capacitor_resistance_ohm": 0.05,
}
CONTROL = {"crossover_hz": 2500.0, "zero_hz": 250.0, "most_duty": 0.95}


def buck_stage(**changed: Any) -> SwitchedBuck:
    return SwitchedBuck(**(_COMMON | {"isolates_discharge": True, "control": CurrentControl(**CONTROL)} | changed))


def boost_stage(**changed: Any) -> SwitchedBoost:
    return SwitchedBoost(**(_COMMON | {"input_capacitance_f": 330e-6} | changed))


def pulses() -> np.ndarray:
    """Charge, discharge, rest, charge at a low current, where the inductor runs empty, rest."""
    parts = [(2.1, 30), (-0.5, 20), (0.0, 15), (0.1, 25), (0.0, 10), (2.1, 20)]
    return np.concatenate([np.full(count, level) for level, count in parts])
