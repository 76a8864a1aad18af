"""A string of cells in groups with bypass diodes under uneven light, and where each tracker ends on its curve.

In series all groups carry one current; a group that cannot is bridged by its diode (Bishop 1988, DOI
10.1016/0379-6787(88)90059-2, without the breakdown of reverse-biased cells, which a bypass diode forestalls).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.experiments.tracking.records import TRACKING_NUMBERS, Shading, Tracking
from pipeline.panel.records import REFERENCE_IRRADIANCE_W_M2
from pipeline.quantity import Quantity
from pipeline.tracker.loop import Light, available, course, run
from pipeline.tracker.records import AnyTracker
from pipeline.tracker.source import Source, of_all_panels

Array = NDArray[np.float64]

POINTS = 4001
"""Points of a tabled curve."""
_CURRENTS = 20_001
_STEPS = 100


class Curve(NamedTuple):
    """Currents [A] at equal steps of the voltage [V] from 0 to open circuit, shape (m,)."""

    step_v: float
    current_a: Array

    @property
    def voltage_v(self) -> Array:
        """Return the voltages [V], shape (m,)."""
        return np.asarray(self.step_v * np.arange(len(self.current_a)), dtype=np.float64)


def curve(
    source: Source,
    irradiances_w_m2: Sequence[float],
    cell_temperature_c: float,
    bypass_voltage_v: float,
    step_v: float | None = None,
) -> Curve:
    """Return the curve of all panels, whose cells are split evenly into groups in series.

    Arguments
    ---------
    source : the panels.
    irradiances_w_m2 : of each group, shape (k,).
    cell_temperature_c : of all cells.
    bypass_voltage_v : forward voltage of the diode across each group.
    step_v : distance of the points; without, open circuit is the last.
    """
    groups = len(irradiances_w_m2)
    parameters, series = of_all_panels(source, np.asarray(irradiances_w_m2), cell_temperature_c)
    most = float(parameters[0].max())
    # Close together where a group's current comes to its end.
    near = [photo * (1.0 + sign * np.geomspace(1e-9, 0.1, 2000)) for photo in parameters[0] for sign in (-1.0, 1.0)]
    currents = np.unique(np.clip(np.concatenate([np.linspace(0.0, most, _CURRENTS), *near]), 0.0, most))
    total = np.zeros_like(currents)
    for photo, saturation, shunt, ideality in parameters.T:
        inside = group_voltage(currents, photo, saturation, shunt * groups, ideality / groups)
        total += np.maximum(inside - currents * series / groups, -bypass_voltage_v)
    open_v = float(total[0])
    step = open_v / (POINTS - 1) if step_v is None else step_v
    voltages = step * np.arange(int(np.ceil(open_v / step - 1e-9)) + 1)
    falling = total[::-1]
    found = np.interp(voltages, falling, currents[::-1])
    return Curve(step, found)


def group_voltage(current: Array, photo: float, saturation: float, shunt: float, ideality: float) -> Array:
    """Return the diode voltage at which a group gives a current, by Newton's method from open circuit [V]."""
    left = photo + saturation - current
    # Without the shunt, or without the diode: the lower of the two lies above the root.
    with np.errstate(invalid="ignore", divide="ignore"):
        alone = ideality * np.log(np.maximum(left, 1e-300) / saturation)
    inside = np.where(left > saturation, alone, (left - saturation) / shunt)
    for _ in range(_STEPS):
        grown = saturation * np.exp(inside / ideality)
        step = (left - grown - inside * shunt) / (grown / ideality + shunt)
        inside = inside + step
        if np.all(np.abs(step) < 1e-12 * ideality + 1e-12 * np.abs(inside)):
            break
    return np.asarray(inside)


def ends(
    source: Source, trackers: Mapping[str, AnyTracker], shading: Shading, cell_temperature_c: float
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Let each tracker find the maximum in full light, then let the shadow of each scene fall.

    Returns
    -------
    The columns of the tables of curves and of ends; the ends are means over the last fifth of the shadow.
    """
    curves: dict[str, list[Any]] = {name: [] for name in ("scene", "voltage_v", "current_a", "power_w")}
    rows: list[tuple[Any, ...]] = []
    for scene, levels in shading.scenes.items():
        full = curve(source, [REFERENCE_IRRADIANCE_W_M2] * len(levels), cell_temperature_c, shading.bypass_voltage_v)
        dim = curve(source, levels, cell_temperature_c, shading.bypass_voltage_v, full.step_v)
        volts, current = dim.voltage_v[::10], dim.current_a[::10]
        columns = (np.full(volts.shape, scene, object), volts, current, volts * current)
        for name, column in zip(curves, columns, strict=True):
            curves[name].append(column)
        best = float((dim.voltage_v * dim.current_a).max())
        rows += [(scene, name, *_end(source, tracker, shading, full, dim, best)) for name, tracker in trackers.items()]
    names = ("scene", "tracker", "voltage_v", "power_w", "best_w", "share", "searched_s")
    found = {name: [row[number] for row in rows] for number, name in enumerate(names)}
    return {name: np.concatenate(parts) for name, parts in curves.items()}, found


def _end(
    source: Source, tracker: AnyTracker, shading: Shading, full: Curve, dim: Curve, best_w: float
) -> tuple[float, float, float, float, float]:
    row_s = tracker.perturbation_period_s
    bright, dark = (max(1, round(span / row_s)) for span in (shading.light_s, shading.shade_s))
    which = np.repeat([0, 1], [bright, dark]).astype(np.int64)
    curves = np.zeros((2, max(len(full.current_a), len(dim.current_a) + 1)))
    curves[0], curves[1] = _beyond(full, curves.shape[1]), _beyond(dim, curves.shape[1])
    light = Light(np.full(len(which), row_s), np.zeros((4, 1)), 0.0, curves, full.step_v, which)
    made = run(source, tracker, light)
    power, last = made.energy_j[bright:] / row_s, slice(-max(1, dark // 5), None)
    mean = float(power[last].mean())
    return float(made.voltage_v[last].mean()), mean, best_w, mean / best_w, settling(power, row_s, 0.02)


def _beyond(found: Curve, count: int) -> Array:
    """Return a curve with as many points as asked for; beyond open circuit it goes on falling as it did there."""
    slope = found.current_a[-1] - found.current_a[-2]
    more = found.current_a[-1] + slope * np.arange(1, count - len(found.current_a) + 1)
    return np.concatenate([found.current_a, more])


NEAR_OPEN_CIRCUIT = 0.95
"""Share of V_oc from which the settling time at the start is taken."""


def summary(
    source: Source, trackers: Mapping[str, AnyTracker], tracking: Tracking, ramps: Mapping[str, Any]
) -> list[Quantity]:
    """Return the numbers of every tracker in steady light and over all ramps.

    Arguments
    ---------
    source : panels and converter.
    trackers, tracking : the trackers by name, and how they are tried.
    ramps : the columns of the table of ramps.
    """
    found: list[Quantity] = []
    for name, tracker in trackers.items():
        own = np.array(ramps["efficiency"])[np.array(ramps["tracker"]) == name]
        found += steady(source, name, tracker, tracking)
        found += [
            TRACKING_NUMBERS.quantity("{tracker}_ramps_efficiency", own.mean(), tracker=name),
            TRACKING_NUMBERS.quantity("{tracker}_worst_ramp", own.min(), tracker=name),
        ]
    return found


def steady(source: Source, name: str, tracker: AnyTracker, tracking: Tracking) -> list[Quantity]:
    """Return a tracker's efficiency and ripple at 1000 W/m2, and its settling times from start and after a step.

    Arguments
    ---------
    source : panels and converter.
    name : the first word of each number's name.
    tracker, tracking : the tracker, and how it is tried.
    """
    row_s, cells = tracker.perturbation_period_s, tracking.cell_temperature_c
    time = np.arange(0.0, tracking.steady_s, row_s)
    full = np.full(time.shape, REFERENCE_IRRADIANCE_W_M2)
    most = float(available(source, REFERENCE_IRRADIANCE_W_M2, cells)[0])
    afar = tracker.model_copy(update={"start_voltage_share": NEAR_OPEN_CIRCUIT})
    made = course(source, afar, time, full, cells)
    power, last = made.energy_j / row_s, slice(-(len(time) // 3), None)
    before = np.arange(-tracking.steady_s, 0.0, row_s)
    stepped = course(
        source,
        tracker,
        np.concatenate([before, time]),
        np.concatenate([np.full(before.shape, tracking.start_w_m2), full]),
        cells,
    )
    after = stepped.energy_j[len(before) :] / row_s
    found = {
        "{tracker}_steady_efficiency": float(power[last].mean()) / most,
        "{tracker}_ripple_v": float(np.ptp(made.voltage_v[last])),
        "{tracker}_ripple_w": float(np.ptp(power[last])),
        "{tracker}_start_s": settling(power, row_s, tracking.settled_share),
        "{tracker}_step_s": settling(after, row_s, tracking.settled_share),
    }
    return [TRACKING_NUMBERS.quantity(pattern, value, tracker=name) for pattern, value in found.items()]


def settling(power: Array, row_s: float, band: float) -> float:
    """Return the time until the power stays within a band about its mean in the last third [s].

    Arguments
    ---------
    power : mean of each row [W], shape (n,).
    row_s : length of a row [s].
    band : half the width of the band over that mean [1].
    """
    final = float(power[-(len(power) // 3) :].mean())
    outside = np.flatnonzero(np.abs(power - final) > band * final)
    return row_s * float(outside[-1] + 1) if outside.size else 0.0
