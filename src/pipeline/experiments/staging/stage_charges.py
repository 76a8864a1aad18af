"""Time and temperature rise of staged charges, a whole population at once, and the objective made of them.

`alpha time + beta rise`, both normalised, after Zhang and Xu, Fast Charging Method based on Improved Cuckoo Algorithm
(2023), section 2.3. Its formulas are lost: how time and rise are normalised, and what counts as infeasible, is ours.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import ZERO_CELSIUS_K
from pipeline.experiments.staging.kernel import END_K, END_V, FOUND, ORDER, PEAK_K, PEAK_V, Grid, charge_stages
from pipeline.experiments.staging.maps import never_limited, stage_maps, weighted
from pipeline.experiments.staging.records import Currents, Reading, Weights

Array = NDArray[np.float64]
BEST_FITNESS = 2.0


class Charges(NamedTuple):
    """What came of n staged charges of s stages."""

    stage_s: Array
    """Time of each stage [s], (n, s)."""
    end_k: Array
    """Temperature rise over the ambient at the end of each stage [K], (n, s)."""
    peak_k: Array
    """Highest rise within each stage [K], (n, s)."""
    peak_v: Array
    """Highest voltage within each stage [V], (n, s)."""
    end_v: Array
    """Voltage at the end of each stage [V], (n, s)."""
    piece_end_k: Array
    """Rise at the end of each piece of the grid [K], (n, p)."""
    piece_peak_k: Array
    """Highest rise within each piece of the grid [K], (n, p)."""

    @property
    def time_s(self) -> Array:
        """Return the time of each charge [s], (n,)."""
        return np.asarray(self.stage_s.sum(axis=1))

    @property
    def stage_rise_k(self) -> Array:
        """Return how much warmer each stage ends than it began [K], (n, s)."""
        return np.diff(self.end_k, axis=1, prepend=0.0)

    def rise_k(self, reading: Reading) -> Array:
        """Return the temperature rise of each charge [K], (n,)."""
        if reading == "final":
            return self.end_k[:, -1]
        if reading == "peak":
            return np.asarray(np.maximum(self.peak_k.max(axis=1), 0.0))
        return np.asarray(np.maximum(self.stage_rise_k, 0.0).sum(axis=1))


class Limits(NamedTuple):
    """What a charge must keep to beside the range of its currents."""

    voltage_v: float
    temperature_c: float


class Scale(NamedTuple):
    """Between which values time and rise are normalised to 0 and 1."""

    fastest_s: float
    slowest_s: float
    hottest_k: float


def charge(grid: Grid, currents: Array) -> Charges:
    """Charge with each candidate's currents; no voltage limit is applied.

    Arguments
    ---------
    currents : of the battery [A], (n, stages).

    Raises
    ------
    ValueError : a current below the least the grid is made for.
    """
    asked = np.ascontiguousarray(currents, dtype=np.float64)
    stages = int(grid.stage[-1]) + 1
    if asked.ndim != 2 or asked.shape[1] != stages:
        raise ValueError(f"currents have the shape {asked.shape}; allowed is (n, {stages})")
    if asked.size and not asked.min() >= grid.slowest_a * (1.0 - 1e-12):
        raise ValueError(f"a current of {asked.min():g} A; the grid is made for {grid.slowest_a:g} A and more")
    pieces = np.zeros((len(asked), len(grid.stage), FOUND))
    charge_stages(grid, asked, np.zeros((4, ORDER + 2)), np.zeros((len(asked), 1 + len(grid.tau_s))), pieces)
    first = np.searchsorted(grid.stage, np.arange(stages))
    ends, peaks = pieces[:, np.append(first[1:], len(grid.stage)) - 1], np.maximum.reduceat(pieces, first, axis=1)
    return Charges(
        stage_s=np.add.reduceat(grid.charge_as, first) / asked,
        end_k=ends[:, :, END_K],
        peak_k=peaks[:, :, PEAK_K],
        peak_v=peaks[:, :, PEAK_V],
        end_v=ends[:, :, END_V],
        piece_end_k=pieces[:, :, END_K],
        piece_peak_k=pieces[:, :, PEAK_K],
    )


def scale_of(grid: Grid, currents: Currents, reading: Reading) -> Scale:
    """Return the scale of a range of currents: every stage at its least and at its largest; no rise counts as 0."""
    ends = charge(grid, np.full((2, int(grid.stage[-1]) + 1), [[currents.high], [currents.low]]))
    return Scale(float(ends.time_s[0]), float(ends.time_s[1]), float(ends.rise_k(reading)[0]))


def value_of(
    found: Charges, scale: Scale, weights: Weights, reading: Reading, limits: Limits, ambient_c: float
) -> Array:
    """Return the objective of charges: 0 to 1 where they keep to the limits, 1 and their excess where they do not."""
    time = (found.time_s - scale.fastest_s) / (scale.slowest_s - scale.fastest_s)
    rise = found.rise_k(reading) / scale.hottest_k
    wanted = (weights.time * time + weights.rise * rise) / (weights.time + weights.rise)
    excess = excess_of(found, limits, ambient_c)
    return np.where(excess > 0.0, 1.0 + excess, wanted)


def excess_of(found: Charges, limits: Limits, ambient_c: float) -> Array:
    """Return by which share of a limit each charge exceeds it, summed over voltage and temperature, (n,)."""
    hottest = found.peak_k.max(axis=1) + ambient_c + ZERO_CELSIUS_K
    voltage = np.maximum(found.peak_v.max(axis=1) / limits.voltage_v - 1.0, 0.0)
    return np.asarray(voltage + np.maximum(hottest / (limits.temperature_c + ZERO_CELSIUS_K) - 1.0, 0.0))


def objective_of(
    grid: Grid, currents: Currents, weights: Weights, reading: Reading, limits: Limits
) -> Callable[[Array], Array]:
    """Return the objective as a search takes it: currents (n, stages) to values (n,).

    Where no current of the range reaches a limit and the rise at the stages' ends is all that counts, it is compiled.
    """
    scale, ambient_c = scale_of(grid, currents, reading), grid.ambient_k - ZERO_CELSIUS_K
    if reading != "peak" and never_limited(grid, currents, limits.voltage_v, limits.temperature_c + ZERO_CELSIUS_K):
        total = weights.time + weights.rise
        of_time = weights.time / total / (scale.slowest_s - scale.fastest_s)
        of_rise = weights.rise / total / scale.hottest_k
        return weighted(stage_maps(grid, currents), of_time, of_rise, -of_time * scale.fastest_s, reading == "positive")

    def objective(candidates: Array) -> Array:
        return value_of(charge(grid, candidates), scale, weights, reading, limits, ambient_c)

    return objective


def fitness(value: Array) -> Array:
    """Return the paper's fitness: 2 at the least objective there could be, 0 at the largest allowed and beyond."""
    return np.asarray(np.clip(BEST_FITNESS * (1.0 - value), 0.0, BEST_FITNESS))
