"""The windows at the resolution of the switches as columns of their tables."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from pipeline.experiments.switched.view import View

Columns = dict[str, list[Any]]

SHOWN_BEFORE_S = 1e-4
SHOWN_AFTER_S = 6e-4
_PERIODS = (
    *("duty", "inductor_mean_a", "battery_mean_a", "battery_min_a", "battery_max_a"),
    *("voltage_mean_v", "voltage_min_v", "voltage_max_v"),
)
_EDGES = ("before_a", "after_a", "overshoot_a", "settling_s", "ringing_j", "deviation_j")


class Place(NamedTuple):
    """Which window of which charge."""

    comparison: str
    mode: str
    window: int


Views = Iterable[tuple[Place, View]]


def periods(views: Views) -> dict[str, Any]:
    """Return the columns of the table of periods."""
    rows = []
    for place, view in views:
        own = {"time_s": view.time_s, "reference_a": view.reference_a} | {n: view.run.periods[n] for n in _PERIODS}
        rows.append(_placed(place, own))
    return _joined(rows, ("time_s", "reference_a", *_PERIODS))


def waveform(views: Views, period_s: float, samples: int) -> dict[str, Any]:
    """Return the columns of the table of samples.

    Arguments
    ---------
    period_s : length of a switching period [s].
    samples : samples of each.
    """
    before, after = round(SHOWN_BEFORE_S / period_s), round(SHOWN_AFTER_S / period_s)
    rows = []
    for place, view in views:
        for edge in view.last_edges:
            first = max(edge.period - before, 0) * samples
            points = view.run.samples[:, first : (edge.period + after) * samples + 1]
            time = (np.arange(points.shape[1]) + first - edge.period * samples) * (period_s / samples)
            own = {
                "edge": np.full(len(time), view.edges.index(edge)),
                "kind": np.full(len(time), edge.kind, dtype=object),
            }
            own |= {"time_s": time, "inductor_a": points[0], "battery_a": points[1], "voltage_v": points[2]}
            rows.append(_placed(place, own))
    return _joined(rows, ("edge", "kind", "time_s", "inductor_a", "battery_a", "voltage_v"))


def edges(views: Views) -> Columns:
    """Return the columns of the table of steps."""
    rows = [
        {**place._asdict(), "edge": number, "kind": edge.kind, "time_s": float(view.time_s[edge.period])}
        | {name: getattr(edge, name) for name in _EDGES}
        for place, view in views
        for number, edge in enumerate(view.edges)
    ]
    return {name: [row[name] for row in rows] for name in (*Place._fields, "edge", "kind", "time_s", *_EDGES)}


def modes(views: Views, bus_voltage_v: float) -> Columns:
    """Return the columns of the table of modes.

    Arguments
    ---------
    bus_voltage_v : voltage of the bus [V].
    """
    rows = [{**place._asdict(), **_came_to(view, bus_voltage_v)} for place, view in views]
    names = ("pulses_hz", "ripple_a", "conduction_efficiency", "overshoot_a", "settling_s", "ringing_j", "ringing_w")
    return {name: [row[name] for row in rows] for name in (*Place._fields, *names)}


def _came_to(view: View, bus_voltage_v: float) -> dict[str, float | None]:
    found = view.last_edges
    ringing = sum(edge.ringing_j for edge in found)
    length = _pulse_length_s(view)
    charging = view.reference_a > 0.0
    steady = charging & (np.abs(view.run.periods["battery_mean_a"] - view.reference_a) < 0.02 * view.reference_a)
    ripple = (view.run.periods["battery_max_a"] - view.run.periods["battery_min_a"])[steady]
    return {
        "pulses_hz": 1.0 / length if length else None,
        "ripple_a": float(ripple.max()) if len(ripple) else 0.0,
        "conduction_efficiency": _efficiency(view, bus_voltage_v),
        "overshoot_a": max((edge.overshoot_a for edge in found), default=0.0),
        "settling_s": max((edge.settling_s for edge in found), default=0.0),
        "ringing_j": ringing,
        "ringing_w": ringing / length if length else 0.0,
    }


def _pulse_length_s(view: View) -> float:
    """Return the mean time between two beginnings of the charging part [s]; 0 where there are no two."""
    begins = np.flatnonzero(np.diff((view.reference_a > 0.0).astype(int)) > 0)
    return float(np.mean(np.diff(view.time_s[begins + 1]))) if len(begins) > 1 else 0.0


def _efficiency(view: View, bus_voltage_v: float) -> float:
    """Return what reaches the battery while it is charged, over what the bus gives: without switching losses."""
    _, current, voltage = view.run.samples
    power = (current * voltage)[:-1].reshape(len(view.time_s), -1).mean(axis=1)
    taken = bus_voltage_v * view.run.periods["source_mean_a"]
    given = power[view.reference_a >= 0.0].sum()
    return float(given / taken.sum()) if taken.sum() > 0.0 else 0.0


def _placed(place: Place, columns: dict[str, Any]) -> dict[str, Any]:
    length = len(next(iter(columns.values())))
    return {
        "comparison": np.full(length, place.comparison, dtype=object),
        "mode": np.full(length, place.mode, dtype=object),
        "window": np.full(length, place.window, dtype=np.int64),
    } | columns


def _joined(rows: list[dict[str, Any]], names: tuple[str, ...]) -> dict[str, Any]:
    return {name: np.concatenate([row[name] for row in rows]) if rows else [] for name in (*Place._fields, *names)}
