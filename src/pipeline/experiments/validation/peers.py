"""The engine against an independent code on the model they have in common: differences moment by moment."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.records import Battery
from pipeline.experiments.validation.common import (
    Case,
    Circuit,
    Trace,
    by_engine,
    cases,
    circuit,
    differences,
    reduced,
    thinned,
)
from pipeline.experiments.validation.records import Curve, Found, PeerSettings, Row, at_most, largest

UNITS = {"voltage": "V", "SOC": "1", "temperature": "K"}
Array = NDArray[np.float64]
Run = Callable[[Circuit, Case, Array], Trace]


def common_model(settings: PeerSettings) -> tuple[Battery, Circuit, list[Case]]:
    """Return the reduced battery, its parameters, and the charges it is compared on."""
    cell = reduced(settings.battery)
    own = circuit(cell)
    current_a = settings.current_c_rate * own.capacity_ah
    return cell, own, cases(current_a, settings.held_voltage_v, settings.initial_soc, settings.ambient_c)


def compare(settings: PeerSettings, bounds: Mapping[str, float], run: Run) -> Found:
    """Return the largest difference of each quantity in each charge, and the differences over time.

    Arguments
    ---------
    bounds : largest difference allowed of voltage [V], SOC [1] and temperature [K], by name.
    run : the other code.
    """
    cell, own, chosen = common_model(settings)
    rows: list[Row] = []
    curves: list[Curve] = []
    for case in chosen:
        if settings.version is None:
            rows += [at_most(f"{case.name}: {name}", None, bounds[name], UNITS[name]) for name in UNITS]
            continue
        ours = by_engine(cell, case)
        for name, gap in differences(ours, run(own, case, ours.time_s)).items():
            rows.append(at_most(f"{case.name}: {name}", largest(gap), bounds[name], UNITS[name]))
            curves.append(difference(case, name, "same heat", ours.time_s, gap))
    return Found(rows, curves)


def difference(case: Case, quantity: str, series: str, time_s: Array, gap: Array) -> Curve:
    """Return a difference over time as a line, its largest values kept."""
    up = f"{quantity} [{UNITS[quantity]}]"
    return Curve(f"{case.name}: {quantity}", series, "time [s]", up, *thinned(time_s, gap))
