"""How the error of each driver falls with the length of its steps or strides, and with its tolerance."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from pipeline.charge.averaged import LONGEST
from pipeline.experiments.validation import plain
from pipeline.experiments.validation.records import Curve, Found, Row, at_least, at_most

_TOLERANCES = tuple(10.0**-power for power in range(3, 9))
_DEFAULT = 1e-6
# Below this, rounding is all that is left of an error.
_ROUNDING = 1e-14
# The iteration within a stride closes to a tenth of the tolerance: longer strides alone show their own error.
_STRIDES = (4, 5, 6, 7, 8, 9, 10)
_STEPS = (4, 6, 8, 12, 16, 24)
_HELD_V, _HELD_S = 3.6, 720.0
_PULSED_A, _PULSED_S, _PULSED_AH, _COOLING_K_W = 8.0, 2400.0, 200.0, 3.0


class _Case(NamedTuple):
    """A charge of one driver whose error is known; `lowest` is the order it must show in the length."""

    driver: str
    what: str
    error: Callable[[float, float], float]
    seconds: float
    parts: tuple[int, ...]
    loosest: float
    lowest: float


def check(settings: Mapping[str, Any]) -> Found:
    """Return the observed orders, and the errors behind them.

    Steps: a held voltage, under which SOC relaxes exponentially. Strides: pulses that warm a cooled battery.
    """
    rows: list[Row] = []
    curves: list[Curve] = []
    for case in _CASES:
        lengths = [case.seconds / parts for parts in case.parts]
        of_length = [case.error(length, case.loosest) for length in lengths]
        of_tolerance = [case.error(case.seconds, one) for one in _TOLERANCES]
        worst = max(e / t for e, t in zip(of_tolerance, _TOLERANCES, strict=True) if t < 1.01 * _DEFAULT)
        order, power = fitted_order(lengths, of_length), fitted_order(_TOLERANCES, of_tolerance)
        rows += [
            at_least(f"{case.driver}: order in the length of {case.what}", order, case.lowest),
            Row(f"{case.driver}: power of the tolerance that the error follows", power),
            at_most(f"{case.driver}: error over tolerance, at 1e-6 and below", worst, 1.0),
        ]
        curves += [
            Curve(
                "length",
                case.driver,
                "longest step or stride [s]",
                "relative error [1]",
                np.array(lengths),
                np.array(of_length),
            ),
            Curve(
                "tolerance",
                case.driver,
                "tolerance [1]",
                "relative error [1]",
                np.array(_TOLERANCES),
                np.array(of_tolerance),
            ),
        ]
    return Found(rows, curves)


def fitted_order(lengths: Sequence[float], errors: Sequence[float]) -> float:
    """Return the slope of log(error) over log(length), least squares, where the error is more than rounding."""
    pairs = [(math.log(x), math.log(y)) for x, y in zip(lengths, errors, strict=True) if y > _ROUNDING]
    if len(pairs) < 2:
        return math.nan
    x, y = np.array(pairs).T
    return float(np.polyfit(x, y, 1)[0])


def _held(longest_s: float, tolerance: float) -> float:
    """Return the error of SOC after a held voltage."""
    mode = plain.held(_HELD_V, _HELD_S)
    charge = plain.charged(plain.battery(), mode, "edge", _HELD_S, maximum_step_s=longest_s, tolerance=tolerance)
    # The open-circuit voltage meets the held one at this depth of discharge.
    rest = (plain.FULL_V - _HELD_V / plain.CELLS) / plain.SLOPE_V
    lag_s = 3600.0 * plain.CAPACITY_AH * plain.OHM / plain.SLOPE_V
    expected = 1.0 - rest - (1.0 - plain.START_SOC - rest) * math.exp(-_HELD_S / lag_s)
    return abs(plain.number(charge, "end_soc") - expected)


def _warmed(longest_s: float, tolerance: float) -> float:
    """Return the error of the temperature after pulses, over its rise; so large a battery hardly fills meanwhile."""
    cell = plain.battery(cooling_k_w=_COOLING_K_W, capacity_ah=_PULSED_AH)
    mode = plain.pulsed(_PULSED_A, _PULSED_S)
    charge = plain.charged(cell, mode, "averaged", _PULSED_S, maximum_step_s=longest_s / LONGEST, tolerance=tolerance)
    settled_k = plain.CELLS * plain.OHM * _PULSED_A**2 * _COOLING_K_W
    lag_s = _COOLING_K_W * plain.HEAT_CAPACITY_J_K
    expected = float(plain.pulsed_rise(0.0, settled_k, lag_s, _PULSED_S / plain.PERIOD_S))
    return abs(plain.number(charge, "end_temperature_c") - plain.AMBIENT_C - expected) / expected


_CASES = (
    _Case("edge", "steps", _held, _HELD_S, _STEPS, 1e-3, 4.5),
    _Case("averaged", "strides", _warmed, _PULSED_S, _STRIDES, 1e-4, 3.5),
)
