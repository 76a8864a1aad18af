"""What the periods of a stride that were run added, and what that tells of the stride."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import REFERENCE_K, Cell
from pipeline.cell.relaxation import NODES
from pipeline.charge.program import Program, lift_line
from pipeline.charge.record_keeping import CHARGE_IN, CHARGE_OUT, ENERGY_IN, ENERGY_OUT, HIGHEST_V, Book
from pipeline.charge.state import (
    CHARGE,
    DEPTH,
    ELECTRICAL,
    HYSTERESIS,
    HYSTERESIS_HEAT,
    PAIR_HEAT,
    RELAXATIONS,
    REVERSIBLE_HEAT,
    SERIES_HEAT,
    SIDE_CHARGE,
    SIDE_HEAT,
    TEMPERATURE,
    TO_AMBIENT,
    TRANSFER_HEAT,
    Run,
)
from pipeline.charge.stride import (
    CHANGES,
    END,
    FIRST,
    GAINS_FROM,
    PEAK_K,
    Stride,
    at_node_fraction,
    copy,
    highest,
    keep_ratios,
)
from pipeline.jit import inlined

# What the quadratics miss at the start of a stride, where it is known, weighs this much.
_SHARE = 3e-2


@inlined
def keep_period(run: Run, scratch: Book, stride: Stride) -> None:
    """Keep the sums of the period just run, and what was seen in it."""
    added, seen = stride.added[stride.at], stride.seen[stride.at]
    copy(added, scratch.sums)
    copy(added[GAINS_FROM:], scratch.recent_gains)
    added[CHANGES] = run.changes - stride.changes_before
    copy(seen, scratch.extremes)
    seen[PEAK_K] = scratch.peak_k[0]


@inlined
def learn(cell: Cell, run: Run, stride: Stride, period_s: float) -> None:
    """Take from the period at the start what a period leaves of the state, and the scales of what it adds."""
    added = stride.added[FIRST]
    keep_ratios(cell, stride, period_s, (added[CHARGE_IN] + added[CHARGE_OUT]) * cell.per_as)
    measure(cell, run, stride)
    _set_scales(cell, stride, period_s)


@inlined
def measure(cell: Cell, run: Run, stride: Stride) -> None:
    """Write what the period just run added to each part of the state."""
    row = stride.at
    place, measured = stride.place[row], stride.measured[row]
    for k in range(stride.parts):
        measured[k] = run.state[k] - stride.kept[k] * place[k]
    # From the sums themselves, not from the small difference of two states.
    gains = stride.added[row, GAINS_FROM:]
    if abs(gains[CHARGE]) * cell.per_as < place[DEPTH]:
        measured[DEPTH] = (gains[SIDE_CHARGE] - gains[CHARGE]) * cell.per_as
    measured[TEMPERATURE] = (_heat_of(cell, gains, False) - gains[TO_AMBIENT]) / cell.heat_capacity_j_k


@inlined
def _heat_of(cell: Cell, gains: NDArray[np.float64], magnitudes: bool) -> float:
    heat = 0.0
    for path in (SERIES_HEAT, TRANSFER_HEAT, REVERSIBLE_HEAT, SIDE_HEAT, HYSTERESIS_HEAT):
        heat += abs(gains[path]) if magnitudes else gains[path]
    for k in range(cell.pairs + cell.acceptance):
        heat += gains[PAIR_HEAT + k]
    return float(heat)


@inlined
def _set_scales(cell: Cell, stride: Stride, period_s: float) -> None:
    """Write the scale of what a period adds to each part of the state, and by how much to nudge each for slopes."""
    added, scale, step = stride.added[FIRST], stride.scale, stride.nudge
    gains = added[GAINS_FROM:]
    moved_as = added[CHARGE_IN] + added[CHARGE_OUT] + 1e-12 * cell.charge_as
    ohmic_v = gains[SERIES_HEAT] / (cell.cells * moved_as) + 1e-4
    scale[DEPTH] = moved_as * cell.per_as
    scale[TEMPERATURE] = (_heat_of(cell, gains, True) + 1e-6 * moved_as) / cell.heat_capacity_j_k
    scale[HYSTERESIS] = -math.expm1(-stride.ratio[HYSTERESIS]) * ohmic_v + 1e-300
    step[DEPTH], step[TEMPERATURE], step[HYSTERESIS] = min(1e-4, 1e-3 * stride.before[DEPTH]), 1e-2, 1e-2 * ohmic_v
    for k in range(cell.relaxations):
        unit = ohmic_v if k < cell.pairs + cell.acceptance else moved_as / period_s
        scale[RELAXATIONS + k] = -math.expm1(-stride.ratio[RELAXATIONS + k]) * unit
        step[RELAXATIONS + k] = 1e-2 * unit


@inlined
def predict(stride: Stride) -> None:
    """Guess the forcings: those of the last stride extrapolated, through what the first period measured."""
    past, last, count = stride.past, float(stride.last), stride.count
    for k in range(stride.parts):
        a, b, c, first = past[0, k], past[1, k], past[2, k], stride.measured[FIRST, k]
        stride.forcing[:, k] = first
        if last > 0.0 and count <= 2.0 * last:
            known = at_node_fraction(a, b, c, 1.0 + 0.5 / last)
            for j in range(3):
                theta = 1.0 + NODES[j] * count / last
                stride.forcing[j, k] = first + at_node_fraction(a, b, c, theta) - known


@inlined
def meets_stop(program: Program, stride: Stride, course: int) -> bool:
    """Tell whether a voltage or temperature that changes or stops the charge may lie between the nodes."""
    limits, seen = program.limits[course], stride.seen
    volt = highest(seen[0, HIGHEST_V], seen[1, HIGHEST_V], seen[2, HIGHEST_V])
    warm = highest(seen[0, PEAK_K], seen[1, PEAK_K], seen[2, PEAK_K])
    seen_v = max(seen[0, HIGHEST_V], max(seen[1, HIGHEST_V], seen[2, HIGHEST_V]))
    least_v = most_v = 0.0
    if program.lift_v_k != 0.0:
        place = stride.place
        cold = min(place[0, TEMPERATURE], min(place[2, TEMPERATURE], place[END, TEMPERATURE]))
        hot = max(place[0, TEMPERATURE], max(place[2, TEMPERATURE], place[END, TEMPERATURE]))
        cold, hot = min(cold, stride.before[TEMPERATURE]), max(hot, stride.before[TEMPERATURE])
        lift_v, lift_v_k, _, highest_k = lift_line(program, cold)
        if hot > highest_k:
            return True
        one, other = lift_v + lift_v_k * (cold - REFERENCE_K), lift_v + lift_v_k * (hot - REFERENCE_K)
        least_v, most_v = min(one, other), max(one, other)
    unseen = seen_v < program.limit_v[course] + most_v and program.limit_v[course] + least_v <= volt
    return bool(unseen or volt >= min(limits[1], limits[5]) + least_v or warm >= min(limits[3], limits[7]))


@inlined
def stride_error(cell: Cell, stride: Stride) -> float:
    """Return the error of a stride in units of its own sums, per unit of tolerance 1.

    The quadratics through what the nodes add, extrapolated to the start, against the period run there.
    """
    added, count = stride.added, stride.count
    first = added[FIRST]
    moved_as = first[CHARGE_IN] + first[CHARGE_OUT] + 1e-12 * cell.charge_as
    energy_j = first[ENERGY_IN] + first[ENERGY_OUT] + 1e-12 * cell.charge_as
    charge = _miss(added[:, CHARGE_IN], count) - _miss(added[:, CHARGE_OUT], count)
    electrical = _miss(added[:, GAINS_FROM + ELECTRICAL], count)
    depth = _miss(stride.measured[:, DEPTH], count) / stride.scale[DEPTH]
    warmth = _miss(stride.measured[:, TEMPERATURE], count) / stride.scale[TEMPERATURE]
    return float(_SHARE * max(max(abs(charge) / moved_as, abs(electrical) / energy_j), max(abs(depth), abs(warmth))))


@inlined
def _miss(values: NDArray[np.float64], count: int) -> float:
    return float(at_node_fraction(values[0], values[1], values[2], 0.5 / count) - values[FIRST])
