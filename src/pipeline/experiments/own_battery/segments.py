"""What a measurement consists of: rests, pulses, constant currents and voltages, and what each of them tells."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import ZERO_CELSIUS_K
from pipeline.experiments.own_battery.reading import Series
from pipeline.experiments.own_battery.records import HeldOut
from pipeline.experiments.own_battery.replay import Drive

Array = NDArray[np.float64]
REST, CONSTANT_CURRENT, CONSTANT_VOLTAGE, PULSE, OTHER = (
    "rest",
    "constant current",
    "constant voltage",
    "pulse",
    "other",
)
LONGEST_PULSE_S = 60.0
_STILL, _STEADY, _JUMP = 0.005, 0.03, 0.05
_HELD_SHARE = 2e-3
_SETTLED_S = 1200.0
_FEWEST_RESTS, _START_S = 3, 300.0
_SMOOTH, _SMOOTHED = 0.03, 10
_LEVELS_V = 200
"""Parts of the voltage's span that a thinned measurement tells apart."""


class Segment(NamedTuple):
    """A stretch of rows.

    Arguments
    ---------
    kind : rest, constant current, constant voltage, pulse, other.
    first, last : its rows, both within.
    start_s, length_s : when, and how long, the way from the row before included [s].
    current_a : mean current [A].
    charge_ah : charge put in [Ah].
    soc : state of charge at its start, by counting on the start card [1].
    start_v, end_v : voltage of its first and last row [V].
    """

    kind: str
    first: int
    last: int
    start_s: float
    length_s: float
    current_a: float
    charge_ah: float
    soc: float
    start_v: float
    end_v: float


def charge_ah(series: Series) -> Array:
    """Return the charge put in since the first row, shape (n,) [Ah]."""
    flowing = series.current_a[1:] if series.jumps else 0.5 * (series.current_a[1:] + series.current_a[:-1])
    return np.append(0.0, np.cumsum(flowing * np.diff(series.time_s))) / 3600.0


def segments(series: Series, soc: float, capacity_ah: float) -> list[Segment]:
    """Return the segments of a measurement, in order.

    Arguments
    ---------
    soc : state of charge at the first row [1].
    capacity_ah : of the start card [Ah].
    """
    current, counted = series.current_a, charge_ah(series)
    edges = [0, *_edges(series), len(current)]
    found = []
    for first, end in itertools.pairwise(edges):
        for begin, stop in _by_kind(series, first, end):
            before = max(begin - 1, 0)
            put_in = counted[stop - 1] - counted[before]
            length = series.time_s[stop - 1] - series.time_s[before]
            mean = 3600.0 * put_in / length if length > 0.0 else float(current[begin])
            found.append(
                Segment(
                    _kind(series, begin, stop, length), begin, stop - 1, float(series.time_s[before]), float(length),
                    float(mean), float(put_in), soc + float(counted[before]) / capacity_ah,
                    float(series.voltage_v[begin]), float(series.voltage_v[stop - 1]),
                )
            )  # fmt: skip
    return found


def _edges(series: Series) -> list[int]:
    """Return the rows at which the current is another than before: jumps, and where it begins or ceases to flow."""
    current = series.current_a
    span = float(np.max(np.abs(current))) + 1e-30
    still = np.abs(current) < _STILL * span
    changed = np.abs(np.diff(current)) > _JUMP * span
    changed |= still[1:] != still[:-1]
    if (series.step >= 0).all():
        changed |= np.diff(series.step) != 0
    return list(np.flatnonzero(changed) + 1)


def _by_kind(series: Series, first: int, end: int) -> Iterator[tuple[int, int]]:
    """Divide a stretch without jumps where a held voltage begins."""
    volts, current = series.voltage_v[first:end], series.current_a[first:end]
    top = float(np.max(volts)) if np.mean(current) >= 0.0 else float(np.min(volts))
    held = np.abs(volts - top) < _HELD_SHARE * abs(top)
    moved = np.ptp(current) > 0.1 * np.max(np.abs(current) + 1e-30)
    begins = int(np.argmax(held)) if held.any() else 0
    if moved and held[begins:].mean() > 0.9 and begins > 3 and end - first - begins > 10:
        yield first, first + begins
        yield first + begins, end
    else:
        yield first, end


def _kind(series: Series, begin: int, stop: int, length: float) -> str:
    current, volts = series.current_a[begin:stop], series.voltage_v[begin:stop]
    span = float(np.max(np.abs(series.current_a))) + 1e-30
    if np.max(np.abs(current)) < _STILL * span:
        return REST
    if np.ptp(current) < 2.0 * _STEADY * span or np.ptp(current) < 0.1 * abs(float(np.mean(current))):
        return PULSE if length <= LONGEST_PULSE_S else CONSTANT_CURRENT
    if np.ptp(volts) < 3.0 * _HELD_SHARE * abs(float(np.mean(volts))):
        return CONSTANT_VOLTAGE
    return OTHER


def held_out(series: Series, found: Sequence[Segment], wanted: HeldOut, place: int) -> NDArray[np.bool_]:
    """Return the rows that the fit may not see, shape (n,).

    Arguments
    ---------
    found : the segments of the series.
    place : whether other files are there: 0 for the only file.
    """
    time_s = series.time_s
    rows = np.zeros(len(time_s), dtype=bool)
    if wanted.takes(series.file):
        rows[:] = True
    for begin, end in wanted.windows_s:
        rows |= (time_s >= begin) & (time_s <= end)
    for level in wanted.around_soc:
        for one in found:
            near = abs(one.soc - level) <= wanted.width_soc
            if near and one.kind in (PULSE, REST):
                rows[one.first : one.last + 1] = True
    named = bool(wanted.files or wanted.windows_s or wanted.around_soc)
    if not named and wanted.share > 0.0 and place == 0:
        rows |= time_s > (1.0 - wanted.share) * time_s[-1]
    return rows


class Thinned(NamedTuple):
    """A measurement with fewer rows and the same charge: what is replayed and what it is held against.

    Arguments
    ---------
    drive : the replay's form; `kept` : its rows in the series.
    voltage_v, temperature_k : measured there; temperature NaN where it is not.
    step_v, shared_v : step of the logger's voltages, 0 where they have none, and the error that rows share whose volts
        stay within one step, root of the mean of the squares [V].
    start_k : temperature at the start: as measured, its first rows averaged, else that of the surroundings [K].
    """

    drive: Drive
    kept: NDArray[np.int64]
    voltage_v: Array
    temperature_k: Array
    step_v: float
    shared_v: float
    start_k: float


def whole(series: Series, ambient_c: float) -> Thinned:
    """Return a measurement with all of its rows, as it is replayed."""
    return _thinned(series, np.arange(len(series.time_s)), ambient_c)


def thinned(series: Series, ambient_c: float, rows: int = 2500) -> Thinned:
    """Return a measurement with rows close together behind a change of current and further apart later on.

    Arguments
    ---------
    ambient_c : temperature of the surroundings where it was not measured [degC].
    rows : about how many rows a steady measurement keeps.
    """
    time_s, current = series.time_s, series.current_a
    span = float(np.max(np.abs(current))) + 1e-30
    counted = charge_ah(series)
    total = float(np.abs(np.diff(counted)).sum()) + 1e-30
    edges = np.zeros(len(current), dtype=bool)
    edges[[0, *_edges(series)]] = True
    longest_s = max(time_s[-1] / rows, 0.0)
    most_ah = 2.0 * total / rows
    # Smoothed: single rows that noise lifts must not be chosen for it.
    volts = _smooth(series.voltage_v)
    quiet = float(np.median(np.abs(np.diff(volts)))) if len(volts) > 1 else 0.0
    most_v = max(float(np.ptp(volts)) / _LEVELS_V, 6.0 * quiet)
    kept, edge, last = [0], 0, 0
    for row in range(1, len(current)):
        if edges[row]:
            if row - 1 != last:
                kept.append(row - 1)
            kept.append(row)
            edge = last = row
            continue
        since, gone = time_s[row] - time_s[edge], time_s[row] - time_s[last]
        moved = abs(counted[row] - counted[last]) >= most_ah or abs(current[row] - current[last]) > 2 * _JUMP * span
        if abs(volts[row] - volts[last]) > most_v:
            kept.append(row)
            last = row
            continue
        if gone >= min(0.12 * since, 4.0 * longest_s) and (
            since <= 20.0 or gone >= longest_s or moved or gone > 0.1 * since
        ):
            kept.append(row)
            last = row
    if kept[-1] != len(current) - 1:
        kept.append(len(current) - 1)
    return _thinned(series, np.array(kept), ambient_c)


def with_held_voltages(series: Thinned, found: Sequence[Segment], volts: Array) -> Thinned:
    """Return a measurement that the held voltage drives, not the current, where a charger held one.

    Arguments
    ---------
    found : the segments of its series; `volts` : all voltages of that [V].
    """
    held, limit = series.drive.held_v.copy(), series.drive.limit_a.copy()
    for one in found:
        if one.kind == CONSTANT_VOLTAGE:
            own = (series.kept > one.first) & (series.kept <= one.last)
            held[own] = float(np.mean(volts[one.first : one.last + 1]))
            # The charger's limit is what flowed when the voltage was reached.
            reached = (series.kept >= one.first - 1) & (series.kept <= one.last)
            flowed = series.drive.read_a[reached]
            limit[own] = flowed[int(np.argmax(np.abs(flowed)))]
    return series._replace(drive=series.drive._replace(held_v=held, limit_a=limit))


def _smooth(values: Array) -> Array:
    """Return the means of values over a few rows on both sides."""
    half = min(_SMOOTHED, (len(values) - 1) // 2)
    total = np.concatenate([[0.0], np.cumsum(values)])
    rows = np.arange(len(values))
    low, high = np.maximum(rows - half, 0), np.minimum(rows + half + 1, len(values))
    return np.asarray((total[high] - total[low]) / (high - low))


def _thinned(series: Series, kept: NDArray[np.int64], ambient_c: float) -> Thinned:
    time_s, counted, current = series.time_s, charge_ah(series), series.current_a
    length = np.diff(time_s[kept])
    put_in = 3600.0 * np.diff(counted[kept])
    mean = np.divide(put_in, length, out=current[kept][1:].copy(), where=length > 0.0)
    if series.jumps:
        jump = np.zeros(len(current) + 1, dtype=bool)
        jump[_edges(series)] = True
        before, after = _straight(mean, length, current[kept[0]], jump[kept[1:-1] + 1])
    else:
        shift = mean - 0.5 * (current[kept[1:]] + current[kept[:-1]])
        before = np.append(current[kept[0]], current[kept[1:]] + shift)
        after = np.append(current[kept[:-1]] + shift, current[kept[-1]])
    around = np.where(np.isnan(series.ambient_c[kept]), ambient_c, series.ambient_c[kept]) + ZERO_CELSIUS_K
    drive = Drive(
        time_s=time_s[kept],
        before_a=before,
        after_a=after,
        read_a=current[kept],
        ambient_k=around,
        given_k=np.full(len(kept), np.nan),
        held_v=np.full(len(kept), np.nan),
        limit_a=np.zeros(len(kept)),
    )
    first = series.temperature_c[: _first_rows(series)]
    known = first[~np.isnan(first)]
    start_k = float(known.mean()) + ZERO_CELSIUS_K if len(known) else float(around[0])
    volts, warm = series.voltage_v[kept], series.temperature_c[kept] + ZERO_CELSIUS_K
    return Thinned(drive, kept, volts, warm, *_steps(series), start_k)


def _steps(series: Series) -> tuple[float, float]:
    """Return the step of the logger's voltages and the error that it leaves in the mean of many rows [V].

    Noise of a standard deviation s spreads a voltage over neighbouring steps of q: what is left of the error of
    rounding in a mean is a wave of the amplitude q / pi exp(-2 pi^2 s^2 / q^2) over the true voltage.
    """
    volts = series.voltage_v
    gaps = np.diff(np.unique(np.round(volts, 9)))
    if len(gaps) < 3:
        return 0.0, 0.0
    step = float(np.min(gaps))
    multiples = gaps / step
    if step < 1e-6 or np.max(np.abs(multiples - np.round(multiples))) > 0.05:
        return 0.0, 0.0
    squares = np.sort(np.diff(volts) ** 2)
    squares = squares[: max(int(0.95 * len(squares)), 1)]
    noise = max(0.5 * float(np.mean(squares)) - step**2 / 12.0, 0.0)
    wave = step / np.pi * np.exp(-2.0 * np.pi**2 * noise / step**2)
    return step, float(min(wave / np.sqrt(2.0), step / np.sqrt(12.0)))


def _first_rows(series: Series) -> int:
    """Return over how many rows the temperature is still that of the start: a rest of some minutes, else a few."""
    still = np.abs(series.current_a) < _STILL * (np.max(np.abs(series.current_a)) + 1e-30)
    ends = int(np.argmin(still)) if not still.all() else len(still)
    early = int(np.searchsorted(series.time_s, _START_S, side="right"))
    return max(min(ends, early), 3)


def _straight(mean: Array, length: Array, first_a: float, jump: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Return the current before and after each row, straight in every interval, its mean kept.

    Where it does not jump it passes through the mean of both sides: single rows are too noisy to begin and end with.

    Arguments
    ---------
    mean, length : of the intervals, shape (m - 1,) [A], [s].
    first_a : current of the first row [A].
    jump : whether the current is another behind each row between two intervals, shape (m - 2,); a tail that ends is
        one however small it has become.
    """
    before, after = np.append(first_a, mean), np.append(mean, mean[-1])
    near = np.abs(np.diff(mean)) < _SMOOTH * (np.max(np.abs(mean)) + 1e-30)
    weight = length[:-1] + length[1:]
    near &= (length[:-1] > 0.0) & (length[1:] > 0.0) & ~jump
    between = np.divide(
        mean[:-1] * length[1:] + mean[1:] * length[:-1], weight, out=mean[1:].copy(), where=weight > 0.0
    )
    start, end = np.append(False, near), np.append(near, False)
    first = np.where(start, np.append(0.0, between), np.nan)
    last = np.where(end, np.append(between, 0.0), np.nan)
    first = np.where(np.isnan(first), np.where(np.isnan(last), mean, 2.0 * mean - last), first)
    last = np.where(np.isnan(last), 2.0 * mean - first, last)
    shift = mean - 0.5 * (first + last)
    after[:-1], before[1:] = first + shift, last + shift
    return before, after


def sensors_apart_k(series: Series, found: Sequence[Segment]) -> float:
    """Return by how much the battery's sensor reads above the room's at the end of long rests; 0 where unknown [K]."""
    apart = series.temperature_c - series.ambient_c
    ends = [float(apart[one.last]) for one in found if one.kind == REST and one.length_s >= _SETTLED_S]
    ends = [one for one in ends if not np.isnan(one)]
    return float(np.median(ends)) if len(ends) >= _FEWEST_RESTS else 0.0


def resting_points(series: Series, found: Sequence[Segment]) -> list[tuple[float, float, float]]:
    """Return what rests tell of the open-circuit voltage: counted state of charge, voltage [V], their length [s]."""
    return [
        (one.soc, one.end_v, one.length_s)
        for one in found
        if one.kind == REST and one.length_s >= min(_SETTLED_S, 0.02 * float(series.time_s[-1]))
    ]
