"""The state of a run and the names of its rows."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import MOST_RELAXATIONS, REFERENCE_K
from pipeline.cell.relaxation import MOST_SLOTS, PASSED, WEIGHT_FIELDS
from pipeline.jit import inlined, new_record

# What a charger holds. Blocked: the battery stands above the voltage limit, and a charger does not draw from it; the
# circuit is then solved for a current of nothing.
CURRENT_CONTROL, VOLTAGE_CONTROL, POWER_CONTROL, BLOCKED = range(4)

# State of the battery: 1 - SOC, temperature [K], hysteresis [V], then the relaxations.
DEPTH, TEMPERATURE, HYSTERESIS, RELAXATIONS = range(4)

# What a step adds, per battery; dissipation of the pairs follows.
(
    CHARGE,
    SIDE_CHARGE,
    VOLTAGE_TIME,
    ELECTRICAL,
    SERIES_HEAT,
    TRANSFER_HEAT,
    REVERSIBLE_HEAT,
    SIDE_HEAT,
    HYSTERESIS_HEAT,
    TO_AMBIENT,
    PAIR_HEAT,
) = range(11)

# Rows of the quantities at a moment: columns are the three nodes and, fourth, the start of the step.
(
    MAIN,
    SIDE,
    TOTAL,
    X,
    T,
    NODE_V,
    SLOW_V,
    OHM,
    ETA,
    ENTROPY,
    REVERSIBLE,
    HEAT,
    TERMINAL_V,
    SIDE_SLOPE,
    ETA_SLOPE,
    HYSTERESIS_V,
    QUANTITIES,
) = range(17)
START = 3

# Share of 1 - SOC that a step may move for straight lines to follow every curve, its square being nothing.
NEAR = 1e-5

MOST_REMEMBERED = 16
_ALIGNMENT = 64

RUN = np.dtype(
    [
        # Rows of four first, each on an alignment of its own.
        ("at", np.float64, (QUANTITIES, 4)),
        ("forcing", np.float64, (MOST_RELAXATIONS, 4)),
        ("value", np.float64, (MOST_RELAXATIONS, 4)),
        ("resistance", np.float64, (MOST_RELAXATIONS, 4)),
        ("slope", np.float64, (MOST_RELAXATIONS, 4)),
        ("inverse", np.float64, (MOST_RELAXATIONS, 4)),
        ("bend", np.float64, (MOST_RELAXATIONS,)),
        ("conductance", np.float64, (MOST_RELAXATIONS, 4)),
        # How the logarithm of a pair's resistance changes with temperature [1/K].
        ("warming", np.float64, (MOST_RELAXATIONS, 4)),
        ("depth_slope", np.float64, (4, 4)),
        ("residual", np.float64, (4,)),
        ("jacobian", np.float64, (3, 4)),
        # Of each segment's steps in the last period: currents, rises in temperature at the moments, length, control.
        ("memory", np.float64, (3, MOST_REMEMBERED, 12)),
        # Of each segment in a period: how its pairs follow, and how side current and temperature rise in it.
        ("leak_weights", np.float64, (3, MOST_RELAXATIONS, 6, 4)),
        ("leak", np.float64, (3, 4)),
        *WEIGHT_FIELDS,
        ("state", np.float64, (RELAXATIONS + MOST_RELAXATIONS,)),
        ("end", np.float64, (RELAXATIONS + MOST_RELAXATIONS,)),
        ("gain", np.float64, (PAIR_HEAT + MOST_RELAXATIONS,)),
        ("proposal_s", np.float64, (3, 4)),
        # Lengths of whole segments and how their pairs follow, of each segment.
        ("plain_s", np.float64, (3,)),
        ("plain", np.float64, (3, MOST_RELAXATIONS, 6)),
        ("leak_start_a", np.float64, (3,)),
        ("guess_a", np.float64),
        # What a held voltage of one cell changes by with the battery's temperature [V/K].
        ("lift_v_k", np.float64),
        ("relaxed_v", np.float64),
        ("segment", np.int64),
        ("place", np.int64),
        ("control", np.int64),
        ("bypassed", np.int64),
        # Whether the last step was so short that straight lines from its start served for every curve.
        ("near", np.bool_),
        ("next_slot", np.int64),
        # Slot of the step integrated last; whether a slot has served since it was last passed over.
        ("slot", np.int64),
        ("served", np.int64, (MOST_SLOTS,)),
        ("steps", np.int64),
        ("edges", np.int64),
        ("changes", np.int64),
        # Highest voltage of a cell since the current was last lowered, that current, and the net heat at the start.
        ("peak_v", np.float64),
        ("peak_a", np.float64),
        ("start_heat_w", np.float64),
        # Whether the course that begins next was begun before: what it has seen and decided then holds on.
        ("resumed", np.bool_),
        # Whether it is the supply that limits the power, not the sheet.
        ("supplied", np.bool_),
    ],
    align=True,
)
"""Everything of a run that changes, in one record: nothing is allocated in a step."""

Run = Any


def new_run() -> Run:
    """Return the record of a run that has not begun."""
    run = new_record(RUN, _ALIGNMENT)
    run["length_s"][:] = run["plain_s"][:] = -1.0
    return run


# Rows of the slopes with x.
OPEN_SLOPE, OHM_SLOPE, ENTROPY_SLOPE, ETA_BY_DEPTH = range(4)


@inlined
def put(row: NDArray[np.float64], a: float, b: float, c: float, d: float) -> None:
    """Write the values of the four moments."""
    row[0], row[1], row[2], row[3] = a, b, c, d


@inlined
def passed(of: NDArray[np.float64], j: int) -> float:
    """Return the integral of a quantity from the start to moment j, per unit of step length."""
    return float(PASSED[0, j] * of[0] + PASSED[1, j] * of[1] + PASSED[2, j] * of[2])


@inlined
def recall(run: Run, length_s: float) -> None:
    """Guess what the same step of the last period came to, if it was of this length and under this control."""
    if run.place >= MOST_REMEMBERED:
        return
    last, main, t = run.memory[run.segment, run.place], run.at[MAIN], run.at[T]
    if last[8] == length_s and last[9] == run.control:
        start = t[START]
        put(main, last[0], last[1], last[2], main[START])
        put(t, start + last[4], start + last[5], start + last[6], start + last[7])


@inlined
def remember(run: Run, length_s: float) -> None:
    """Keep what a step came to, for the same step of the next period."""
    if run.place >= MOST_REMEMBERED:
        return
    last, main, t = run.memory[run.segment, run.place], run.at[MAIN], run.at[T]
    start = t[START]
    put(last, main[0], main[1], main[2], main[3])
    put(last[4:], t[0] - start, t[1] - start, t[2] - start, t[3] - start)
    last[8], last[9] = length_s, run.control
    run.place += 1


class Demand(NamedTuple):
    """What a segment asks for: current of the battery, voltage limit of one cell, power at the terminals.

    The battery's temperature lifts every voltage of the sheet: by `lift_v` at 25 degC and `lift_v_k` for each kelvin
    above, between the lowest and the highest temperature, where another line begins.
    """

    current_a: float
    limit_v: float
    power_w: float
    charging: bool
    lift_v: float = 0.0
    lift_v_k: float = 0.0
    lowest_k: float = -math.inf
    highest_k: float = math.inf


@inlined
def lift_at(demand: Demand, temperature_k: float) -> float:
    """Return what the temperature adds to the voltages of the sheet, per cell [V]."""
    return demand.lift_v + demand.lift_v_k * (temperature_k - REFERENCE_K)
