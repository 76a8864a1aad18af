"""The engine against closed forms: an RC step, coulombs counted, a resistor that warms an insulated battery."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.records import Pair
from pipeline.charge.records import Window
from pipeline.charge.simulate import Charge
from pipeline.experiments.validation import plain
from pipeline.experiments.validation.records import Curve, Found, at_most, largest

_PAIR = Pair(resistance_ohm=0.1, time_constant_s=7.0)
_CURRENT_A, _SECONDS = 0.5, 600.0
_COOLING_K_W = 3.0

Array = NDArray[np.float64]


def check(settings: Mapping[str, Any]) -> Found:
    """Return the largest error of each exact solution under each driver, and the error over time.

    A constant current has no periods: the driver `averaged` is tried on pulses, whose closed forms are as exact.
    """
    lines = list(_lines())
    rows = [
        at_most(f"{line.group}, {line.series}", largest(line.y), *BOUNDS[line.group, line.series]) for line in lines
    ]
    return Found(rows, lines)


BOUNDS = {
    ("RC step", "edge"): (1e-12, "V"),
    ("RC step after 600 s of pulses", "averaged"): (1e-9, "V"),
    ("Coulomb balance", "edge"): (1e-13, "1"),
    ("Coulomb balance", "averaged"): (1e-13, "1"),
    ("adiabatic heating", "edge"): (1e-10, "K"),
    ("adiabatic heating", "averaged"): (1e-9, "K"),
    ("cooled heating", "edge"): (1e-9, "K"),
    ("cooled heating", "averaged"): (1e-6, "K"),
}
"""Bounds at the default tolerance, 1e-6 of the rise: what is linear keeps to rounding, cooling is integrated."""


def _lines() -> Iterator[Curve]:
    yield _curve("RC step", "edge", *_step_of_a_pair())
    yield _curve("RC step after 600 s of pulses", "averaged", *_pulses_of_a_pair())
    for driver in ("edge", "averaged"):
        yield _curve("Coulomb balance", driver, *_coulombs(driver))
        yield _curve("adiabatic heating", driver, *_warmth(driver, plain.INSULATED_K_W))
        yield _curve("cooled heating", driver, *_warmth(driver, _COOLING_K_W))


def _curve(group: str, series: str, time_s: Array, error: Array) -> Curve:
    up = f"error [{BOUNDS[group, series][1]}]"
    return Curve(group, series, "time [s]", up, time_s, error)


def _share(driver: str) -> float:
    return 1.0 if driver == "edge" else plain.SHARE


def _charge(driver: str, current_a: float, cooling_k_w: float = plain.INSULATED_K_W) -> Charge:
    make = plain.constant if driver == "edge" else plain.pulsed
    return plain.charged(plain.battery(cooling_k_w=cooling_k_w), make(current_a, _SECONDS), driver, 10.0)


def _coulombs(driver: str) -> tuple[Array, Array]:
    """Return time [s], and SOC less what was put in over the capacity."""
    trace = _charge(driver, _CURRENT_A).trace
    time_s = np.asarray(trace["Test Time / s"])
    expected = plain.START_SOC + _share(driver) * _CURRENT_A * time_s / (3600.0 * plain.CAPACITY_AH)
    return time_s, np.asarray(trace["soc"]) - expected


def _warmth(driver: str, cooling_k_w: float) -> tuple[Array, Array]:
    """Return time [s], and temperature less that of R0 I^2 in a cooled lump [K]."""
    current_a = 4.0 * _CURRENT_A
    trace = _charge(driver, current_a, cooling_k_w).trace
    time_s = np.asarray(trace["Test Time / s"])
    settled_k = plain.CELLS * plain.OHM * current_a**2 * cooling_k_w
    lag_s = cooling_k_w * plain.HEAT_CAPACITY_J_K
    if driver == "edge":
        rise_k = settled_k * -np.expm1(-time_s / lag_s)
    else:
        rise_k = plain.pulsed_rise(0.0, settled_k, lag_s, time_s / plain.PERIOD_S)
    return time_s, np.asarray(trace["Surface Temperature / degC"]) - plain.AMBIENT_C - rise_k


def _step_of_a_pair() -> tuple[Array, Array]:
    """Return time [s], and terminal voltage less the closed form of a step of the current [V]."""
    cell = plain.battery(_PAIR)
    wave = plain.charged(cell, plain.constant(_CURRENT_A, 40.0), "edge", 10.0, Window(start_s=0.0, length_s=40.0))
    time_s, voltage_v = (np.asarray(wave.waveform[name]) for name in ("time_s", "voltage_v"))
    depth = 1.0 - plain.START_SOC - _CURRENT_A * time_s / (3600.0 * plain.CAPACITY_AH)
    relaxed = 0.1 * _CURRENT_A * -np.expm1(-time_s / _PAIR.time_constant_s)
    expected = plain.FULL_V - plain.SLOPE_V * depth + plain.OHM * _CURRENT_A + relaxed
    return time_s, voltage_v - plain.CELLS * expected


def _pulses_of_a_pair() -> tuple[Array, Array]:
    """Return time [s], and terminal voltage in the last pulse less the exact map of all pulses before it [V]."""
    flat = plain.battery(_PAIR, slope_v=0.0)
    begin_s, tau_s = _SECONDS, _PAIR.time_constant_s
    window = Window(start_s=begin_s, length_s=plain.SHARE * plain.PERIOD_S)
    wave = plain.charged(flat, plain.pulsed(_CURRENT_A, begin_s + 1.0), "averaged", 10.0, window).waveform
    settled_v = 0.1 * _CURRENT_A
    before_v = plain.pulsed_rise(0.0, settled_v, tau_s, begin_s / plain.PERIOD_S)
    time_s, voltage_v, current_a = (np.asarray(wave[name]) for name in ("time_s", "voltage_v", "current_a"))
    pulse = current_a > 0.0
    later_s = time_s[pulse] - begin_s
    expected = plain.FULL_V + plain.OHM * _CURRENT_A + settled_v + (before_v - settled_v) * np.exp(-later_s / tau_s)
    return later_s, voltage_v[pulse] - plain.CELLS * expected
