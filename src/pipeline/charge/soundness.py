"""Is nothing wrong with many charges, beyond doubt? What is in doubt is left to `checks.check`, which says what it is.

Curves are looked at in the kernels' form, with margins that are wider than what its cubics and rounding differ from the
straight lines and Python's arithmetic of the check; a sheet is held once against the worst of a group of batteries.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import ENTROPIC, EXCHANGE, FIRST_PAIR, OPEN_CIRCUIT, SERIES, Cell
from pipeline.cell.curves import CONSTANT, TABLE, piece_of, value_and_slope
from pipeline.charge.checks import NEARLY_EMPTY, NEARLY_FULL, Facts, check_sheet, needs_resistance
from pipeline.charge.feasible import NEVER_FULL, emptied
from pipeline.charge.protocol import Resolver, lift_of
from pipeline.charge.records import Mode
from pipeline.errors import UserError
from pipeline.jit import kernel

Array = NDArray[np.float64]

FAULTS = (UserError, ValueError, ArithmeticError, LookupError)
"""What a check, or what it makes of numbers that fit nothing, may raise."""
# Columns of what is found of each charge.
SOUND, START_V, EMPTY_V, FULL_V, WARM_FULL_V, FOUND = range(6)
_POINTS = 100
# Of a potential, and of what falls of it: half of what the check allows is left for what is not looked at.
_FALL, _LEAST = 0.0025, 0.34
_CLEAR = 1e-9


@kernel
def look(cells: NDArray[Any], cell_of: NDArray[np.int64], asked: Array, held: NDArray[np.bool_], found: Array) -> None:
    """Look at the curves of each charge.

    Arguments
    ---------
    cell_of : row of the battery of each charge, (n,).
    asked : SOC at the start, lowest and highest SOC visited, temperature at the start [degC], (n, 4).
    held : whether a voltage is held, (n,).
    found : written: 1 where nothing is wrong with the curves, then voltages at rest, the start's and the empty one's
        from above, those of the full one from below, (n, FOUND).
    """
    for n in range(len(cell_of)):
        cell = cells[cell_of[n]]
        soc, low, high, warmth = asked[n, 0], asked[n, 1], asked[n, 2], asked[n, 3] - 25.0
        found[n, START_V] = _resting_v(cell, soc, warmth, 1)
        found[n, EMPTY_V] = _resting_v(cell, NEARLY_EMPTY, warmth, 1)
        found[n, FULL_V] = _resting_v(cell, NEARLY_FULL, warmth, 0)
        found[n, WARM_FULL_V] = _resting_v(cell, NEARLY_FULL, 0.0, 0)
        good = _potential_is_sound(cell, low, high, warmth)
        for row in range(SERIES, FIRST_PAIR + cell.pairs):
            least, most = _range_of(cell, row, low, high, row == EXCHANGE)
            positive = row == EXCHANGE or (row == SERIES and held[n] and cell.transfer == 0)
            # A constant is what it is; elsewhere the least must stand clear of zero.
            allowed = least >= 0.0 and (least > 0.0 or not positive)
            if least != most:
                allowed = least > _CLEAR * most
            if not allowed or not math.isfinite(most):
                good = False
        volts = found[n, START_V] + found[n, EMPTY_V] + found[n, FULL_V] + found[n, WARM_FULL_V]
        found[n, SOUND] = 1.0 if good and math.isfinite(volts) else 0.0


@kernel
def _resting_v(cell: Cell, soc: float, warmth_k: float, above: int) -> float:
    """Return a bound of the voltage of a battery at rest, from above or from below."""
    low_v, high_v = _bounds(cell, OPEN_CIRCUIT, soc)
    low_e, high_e = _bounds(cell, ENTROPIC, soc)
    a, b = low_e * warmth_k, high_e * warmth_k
    if above == 1:
        volts = high_v + max(a, b)
        return float(cell.cells * (volts + _CLEAR * abs(volts)))
    volts = low_v + min(a, b)
    return float(cell.cells * (volts - _CLEAR * abs(volts)))


@kernel
def _bounds(cell: Cell, row: int, soc: float) -> tuple[float, float]:
    """Return two values between which a curve lies at an SOC, read by a cubic or by a straight line."""
    value, _ = value_and_slope(cell, row, 1.0 - soc)
    low, high = value, value
    if cell.kind[row] == TABLE:
        piece = piece_of(cell, row, 1.0 - soc)
        # A point of the table may be taken for the end of the piece on either side.
        for place in range(max(piece - 1, 0), piece + 3):
            knot = _knot(cell, row, place)
            low, high = min(low, knot), max(high, knot)
    return low, high


@kernel
def _knot(cell: Cell, row: int, place: int) -> float:
    """Return the value at a point of a table, the last where there are none beyond it."""
    x = cell.knots[row, place] if place < cell.pieces[row] else 1.0
    return float(value_and_slope(cell, row, x)[0])


@kernel
def _range_of(cell: Cell, row: int, low: float, high: float, inside: bool) -> tuple[float, float]:
    """Return the least and the largest value of a curve over a range of SOC; infinite where one is not finite.

    Arguments
    ---------
    inside : leave out the ends, empty and full.
    """
    least, most = math.inf, -math.inf
    sound = True
    if cell.kind[row] == CONSTANT:
        least = most = cell.parameters[row, 0]
        return (least, most) if math.isfinite(least) else (-math.inf, math.inf)
    for n in range(_POINTS + 1):
        soc = low + (high - low) * n / _POINTS if n < _POINTS else high
        value, _ = value_and_slope(cell, row, 1.0 - soc)
        sound = sound and math.isfinite(value)
        if not inside or 0.0 < soc < NEVER_FULL:
            least, most = min(least, value), max(most, value)
    if cell.kind[row] == TABLE:
        first, last = _places(cell, row, low, high)
        for place in range(first, last + 1):
            value = _knot(cell, row, place)
            least, most = min(least, value), max(most, value)
    return (least, most) if sound else (-math.inf, math.inf)


@kernel
def _places(cell: Cell, row: int, low: float, high: float) -> tuple[int, int]:
    """Return the first and the last point of a table of those that reach over a range of SOC."""
    return max(piece_of(cell, row, 1.0 - high) - 1, 0), min(piece_of(cell, row, 1.0 - low) + 2, cell.pieces[row])


@kernel
def _potential_is_sound(cell: Cell, low: float, high: float, warmth_k: float) -> bool:
    """Tell whether the potential is clear of what is allowed: a third of the full one, and to fall by a little."""
    table = cell.kind[OPEN_CIRCUIT] == TABLE
    if cell.kind[ENTROPIC] == TABLE and not table:
        return False
    least_e, most_e = _range_of(cell, ENTROPIC, low, high, False)
    a, b = least_e * warmth_k, most_e * warmth_k
    swing, lowest = 1.1 * abs(b - a), min(a, b)
    least, top, fallen = math.inf, -math.inf, 0.0
    if not math.isfinite(swing):
        return False
    for n in range(_POINTS + 1):
        soc = low + (high - low) * n / _POINTS if n < _POINTS else high
        value, _ = value_and_slope(cell, OPEN_CIRCUIT, 1.0 - soc)
        if not math.isfinite(value):
            return False
        top, least = max(top, value), min(least, value)
        fallen = max(fallen, top - value)
    if table:
        top = -math.inf
        first, last = _places(cell, OPEN_CIRCUIT, low, high)
        for place in range(last, first - 1, -1):
            value = _knot(cell, OPEN_CIRCUIT, place)
            top, least = max(top, value), min(least, value)
            fallen = max(fallen, top - value)
    least_v = least + lowest - 0.1 * swing
    return bool(
        least_v > _LEAST * (top + lowest + swing)
        and least_v > _CLEAR
        and fallen <= _FALL * least
        and fallen + swing <= 2.0 * 0.9 * _FALL * least_v
    )


class Looked(NamedTuple):
    """What is known of charges: capacity in use [A h], sampling interval [s]; `asked` and `found` as in `look`."""

    capacity_ah: Array
    interval_s: Array
    asked: Array
    found: Array


class Group(NamedTuple):
    """What charges must have in common, beside their sheet, to be held against it together."""

    cells: int
    fills: bool


class Sheet:
    """A mode, held against the worst of what is known of many charges: what it passes for, it passes for all.

    Every comparison of `check_sheet` is with a straight line in each fact, so that the ends of a range decide.
    """

    def __init__(self, mode: Mode) -> None:
        self.mode = mode
        self.held = any(needs_resistance(phase) for phase in mode.phases.values())
        self._passed: dict[Group, list[Facts]] = {}
        self._emptied: dict[tuple[float, float, int], tuple[bool, float]] = {}

    def visited(self, group: Group, least_ah: float, most_ah: float, soc: Array) -> tuple[Array, Array]:
        """Return the lowest and the highest SOC that charges may visit, as `feasible.visited`, or a wider range.

        Arguments
        ---------
        least_ah, most_ah : between which the capacities in use lie [A h].
        soc : at their starts.
        """
        key = least_ah, most_ah, group.cells
        if key not in self._emptied:
            try:
                ends = [emptied(Resolver(self.mode, ah, group.cells), self.mode, _CLEAR) for ah in key[:2]]
            except FAULTS:
                # The sheet is refused below.
                ends = [(True, 1.0)]
            self._emptied[key] = any(empties for empties, _ in ends), ends[0][1]
        empties, stop = self._emptied[key]
        low = np.zeros_like(soc) if empties else soc
        return low, np.minimum(np.minimum(1.0, np.maximum(stop, low)), 1.0 if group.fills else NEVER_FULL)

    def doubtful(self, group: Group, members: NDArray[np.int64], looked: Looked) -> list[int]:
        """Return the members of a group that the sheet may not fit.

        Arguments
        ---------
        members : rows of what was looked at; the curves of each are sound.
        """
        if len(members) == 0:
            return []
        at, begin, ah = looked.found[members], looked.asked[members], looked.capacity_ah[members]
        coldest_c, warmest_c = float(begin[:, 3].min()), float(begin[:, 3].max())
        lift = lift_of(self.mode)
        worst = Facts(
            float(ah.min()),
            group.cells,
            group.fills,
            float(begin[:, 0].max()),
            warmest_c,
            "",
            float(looked.interval_s[members].min()),
            float(at[:, START_V].max()),
            float(at[:, EMPTY_V].max()),
            float(at[:, FULL_V].min()),
            float(at[:, WARM_FULL_V].min()),
            group.cells * min(lift.per_cell_v(coldest_c), lift.per_cell_v(warmest_c)),
        )
        if self._passes(group, worst, float(ah.max())):
            return []
        if len(members) == 1:
            return [int(members[0])]
        half = len(members) // 2
        parts = (members[:half], members[half:])
        return [n for part in parts for n in self.doubtful(group, part, looked)]

    def _passes(self, group: Group, worst: Facts, most_ah: float) -> bool:
        ends = [worst, worst._replace(capacity_in_use_ah=most_ah)]
        passed = self._passed.get(group)
        if passed is not None and _hull(ends, passed) == passed:
            return True
        # What has passed before is widened, so that fewer and fewer have to be looked at.
        for wider in ([] if passed is None else [_hull(ends, passed)]) + [ends]:
            if self._check(wider):
                self._passed[group] = wider
                return True
        return False

    def _check(self, ends: list[Facts]) -> bool:
        try:
            used = [check_sheet(self.mode, facts).used for facts in ends]
        except FAULTS:
            return False
        return all(set(self.mode.knobs) <= one for one in used)


_SMALLEST = ("capacity_in_use_ah", "sample_interval_s", "full_v", "warm_full_v", "lift_v")
_LARGEST = ("initial_soc", "start_c", "start_v", "empty_v")


def _hull(ends: list[Facts], passed: list[Facts]) -> list[Facts]:
    """Return the ends of what reaches over both."""
    low = {name: min(getattr(ends[0], name), getattr(passed[0], name)) for name in _SMALLEST}
    high = {name: max(getattr(ends[0], name), getattr(passed[0], name)) for name in _LARGEST}
    first = ends[0]._replace(**low, **high)
    return [first, first._replace(capacity_in_use_ah=max(ends[1].capacity_in_use_ah, passed[1].capacity_in_use_ah))]
