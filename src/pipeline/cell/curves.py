"""Quantities that depend on SOC, in one compiled form: value, slope and integral."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from pipeline.cell.records import (
    MOST_POINTS,
    MOST_TEMPERATURES,
    Curve,
    Inverse,
    Logarithm,
    Polynomial,
    Root,
    Shepherd,
)
from pipeline.jit import inlined, kernel

CONSTANT, POLYNOMIAL, LOGARITHM, ROOT, SHEPHERD, INVERSE, TABLE = range(7)


MOST_CURVES, MOST_PIECES = 10, MOST_POINTS
CURVE_FIELDS = [
    ("kind", np.int64, (MOST_CURVES,)),
    ("pieces", np.int64, (MOST_CURVES,)),
    ("parameters", np.float64, (MOST_CURVES, 4)),
    ("knots", np.float64, (MOST_CURVES, MOST_PIECES)),
    ("coefficients", np.float64, (MOST_CURVES, MOST_PIECES, 5)),
]
"""Fields of a compiled bank of curves, all of them functions of x = 1 - SOC."""


def compile_curves(bank: Any, curves: Sequence[Curve], factors: Sequence[float]) -> None:
    """Write curves into a bank.

    Arguments
    ---------
    bank : a record with `CURVE_FIELDS` among its fields.
    curves : the curves, in the order of their index.
    factors : factor of each, (n,).
    """
    for row, (curve, factor) in enumerate(zip(curves, factors, strict=True)):
        _compile(bank, row, curve, factor)


def _compile(bank: Any, row: int, curve: Curve, factor: float) -> None:
    parameters = bank["parameters"][row]
    if isinstance(curve, float | int):
        bank["kind"][row] = CONSTANT
        parameters[0] = factor * curve
    elif isinstance(curve, Polynomial):
        bank["kind"][row] = POLYNOMIAL if len(curve.polynomial) > 1 else CONSTANT
        parameters[: len(curve.polynomial)] = factor * np.array(curve.polynomial)
    elif isinstance(curve, Logarithm):
        bank["kind"][row] = LOGARITHM
        parameters[:] = factor * curve.constant, factor * curve.factor, curve.soc_offset, curve.depth_offset
    elif isinstance(curve, Root):
        bank["kind"][row] = ROOT
        parameters[:2] = factor * curve.factor, curve.soc_offset
    elif isinstance(curve, Shepherd):
        bank["kind"][row] = SHEPHERD
        parameters[:2] = factor * curve.full_v, factor * curve.polarisation_v
    elif isinstance(curve, Inverse):
        bank["kind"][row] = INVERSE
        parameters[:2] = factor * curve.factor, curve.depth_offset
    else:
        from scipy.interpolate import PchipInterpolator

        bank["kind"][row] = TABLE
        grid, values = curve.inside
        depth = 1.0 - np.array(grid[::-1])
        cubic = PchipInterpolator(depth, factor * curve.scale * np.array(values[::-1]))
        pieces = len(depth) - 1
        bank["pieces"][row] = pieces
        bank["knots"][row, :pieces] = depth[:-1]
        bank["coefficients"][row, :pieces, :4] = cubic.c[::-1].T
        bank["coefficients"][row, :pieces, 4] = cubic.antiderivative()(depth[:-1])


NO_FACTOR, ARRHENIUS, FACTORS = range(3)
MOST_FACTORS = 9
FACTOR_FIELDS = [
    ("warming", np.int64),
    ("factor_kind", np.int64, (MOST_FACTORS,)),
    ("factor_energy_k", np.float64, (MOST_FACTORS,)),
    ("factor_reference_k", np.float64, (MOST_FACTORS,)),
    ("factor_pieces", np.int64, (MOST_FACTORS,)),
    ("factor_knots_k", np.float64, (MOST_FACTORS, MOST_TEMPERATURES)),
    ("factor_coefficients", np.float64, (MOST_FACTORS, MOST_TEMPERATURES, 4)),
]
"""Fields of the factors by which temperature multiplies resistances; `warming` tells whether there is any."""


@kernel
def factor_and_slope(bank: Any, row: int, temperature_k: float) -> tuple[float, float]:
    """Return the factor of a resistance at a temperature, and the slope of its logarithm [1/K].

    `f = exp(E / R (1 / T - 1 / T_reference))` for an activation energy E, a cubic between two temperatures of a table.
    """
    kind = bank.factor_kind[row]
    if kind == NO_FACTOR:
        return 1.0, 0.0
    if kind == ARRHENIUS:
        energy_k, reference_k = bank.factor_energy_k[row], bank.factor_reference_k[row]
        return math.exp(energy_k * (1.0 / temperature_k - 1.0 / reference_k)), -energy_k / temperature_k**2
    pieces, knots = bank.factor_pieces[row], bank.factor_knots_k[row]
    t = min(max(temperature_k, knots[0]), knots[pieces])
    piece = 0
    while piece + 1 < pieces and knots[piece + 1] <= t:
        piece += 1
    c, d = bank.factor_coefficients[row, piece], t - knots[piece]
    factor = c[0] + d * (c[1] + d * (c[2] + d * c[3]))
    slope = c[1] + d * (2.0 * c[2] + 3.0 * d * c[3])
    return factor, slope / factor if t == temperature_k else 0.0


@kernel
def piece_of(bank: Any, row: int, x: float) -> int:
    """Return the piece of a table that holds x; the outer pieces reach beyond their ends."""
    low, high = 0, bank.pieces[row] - 1
    while low < high:
        middle = (low + high + 1) // 2
        if bank.knots[row, middle] <= x:
            low = middle
        else:
            high = middle - 1
    return low


@inlined
def value_and_slope(bank: Any, row: int, x: float) -> tuple[float, float]:
    """Return a curve's value and its derivative with respect to x = 1 - SOC."""
    kind = bank.kind[row]
    p = bank.parameters[row]
    if kind == CONSTANT:
        return p[0], 0.0
    if kind == POLYNOMIAL:
        return p[0] + x * (p[1] + x * (p[2] + x * p[3])), p[1] + x * (2.0 * p[2] + 3.0 * x * p[3])
    if kind == LOGARITHM:
        above, below = 1.0 - x + p[2], x + p[3]
        return p[0] + p[1] * math.log(above / below), -p[1] * (1.0 / above + 1.0 / below)
    if kind == ROOT:
        above = 1.0 - x + p[1]
        root = math.sqrt(x * above)
        return p[0] * root, 0.5 * p[0] * (above - x) / root
    if kind == SHEPHERD:
        return p[0] - p[1] * x / (1.0 - x), -p[1] / (1.0 - x) ** 2
    if kind == INVERSE:
        return p[0] / (x + p[1]), -p[0] / (x + p[1]) ** 2
    piece = piece_of(bank, row, x)
    c = bank.coefficients[row, piece]
    d = x - bank.knots[row, piece]
    return c[0] + d * (c[1] + d * (c[2] + d * c[3])), c[1] + d * (2.0 * c[2] + 3.0 * d * c[3])


@kernel
def integral(bank: Any, row: int, x: float) -> float:
    """Return the integral of a curve over SOC, up to a constant; a root has none here and gives NaN."""
    kind = bank.kind[row]
    p = bank.parameters[row]
    if kind == CONSTANT:
        return float(-p[0] * x)
    if kind == POLYNOMIAL:
        return float(-x * (p[0] + x * (p[1] / 2.0 + x * (p[2] / 3.0 + x * p[3] / 4.0))))
    if kind == LOGARITHM:
        above, below = 1.0 - x + p[2], x + p[3]
        lower = below * math.log(below) if below > 0.0 else 0.0
        return float(-p[0] * x + p[1] * (above * math.log(above) + lower))
    if kind == ROOT:
        return math.nan
    if kind == SHEPHERD:
        return float(-p[0] * x - p[1] * (x + math.log(1.0 - x)))
    if kind == INVERSE:
        return float(-p[0] * math.log(x + p[1]))
    piece = piece_of(bank, row, x)
    c = bank.coefficients[row, piece]
    d = x - bank.knots[row, piece]
    return float(-(c[4] + d * (c[0] + d * (c[1] / 2.0 + d * (c[2] / 3.0 + d * c[3] / 4.0)))))
