"""Objective: a waveform, a battery's pairs and its switches in; loss against frequency and what moves the best out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline import quantity, schemas, tables
from pipeline.objective.loss import breakdown, error_mw, integral_square_error, switching_energy_j
from pipeline.objective.optimum import contour_energy_j, frequency_map_hz, optimal_frequency_hz
from pipeline.objective.records import Pairs, ReflexFrequency, Waveform
from pipeline.objective.ripple import Steps, steps, switched_currents_a
from pipeline.objective.summary import of_modes, quantities

Array = NDArray[np.float64]

FREQUENCIES_HZ = np.geomspace(0.5, 2000.0, 721)
MAP_POINTS = 41
MAP_SPAN = 10.0
"""The map goes from a tenth to ten times the configured energy and capacitance."""
CONTOUR_HZ = 90.0


def run(settings: Mapping[str, Any], inputs: Mapping[str, Path], output: Path) -> None:
    """Compute the loss over frequency, the map of the best frequency, and the named numbers."""
    chosen = ReflexFrequency.model_validate(settings["objective"])
    waveforms = {name: Waveform.model_validate(waveform) for name, waveform in settings["waveforms"].items()}
    pairs = Pairs(*(tuple(part) for part in settings["pairs"]))
    series = float(settings["series_resistance_ohm"])
    waveform = waveforms[chosen.mode]
    period, energy = steps(waveform), switching_energy_j(chosen.transistor, switched_currents_a(waveform))
    numbers = [*quantities(chosen, waveform, pairs, series), *of_modes(chosen, waveforms, pairs)]
    loss = _loss(period, pairs, series, energy, chosen.window_s)
    tables.write(schemas.OBJECTIVE_LOSS, loss, output / "loss.parquet")
    tables.write(schemas.FREQUENCY_MAP, _map(period, pairs, energy), output / "map.parquet")
    tables.write(schemas.FREQUENCY_CONTOUR, _contour(period, pairs), output / "contour.parquet")
    tables.write(schemas.QUANTITIES, quantity.columns(numbers), output / "quantities.parquet")


def _loss(period: Steps, pairs: Pairs, series_ohm: float, energy_j: float, window_s: float) -> dict[str, Array]:
    parts = breakdown(period, pairs, series_ohm, energy_j, FREQUENCIES_HZ)
    error = error_mw(period, pairs, energy_j, FREQUENCIES_HZ)
    ise = integral_square_error(error, window_s)
    names = ("frequency_hz", "pair_ripple_w", "series_ripple_w", "switching_w", "total_w")
    best = optimal_frequency_hz(period, pairs, energy_j)
    least = np.nanmin([ise.min(), integral_square_error(error_mw(period, pairs, energy_j, best), window_s)])
    return {name: parts[name] for name in names} | {
        "error_mw": error,
        "ise_mw2_s": ise,
        "share_over_minimum": ise / least - 1.0,
    }


def _capacitances(pairs: Pairs) -> tuple[int, Array]:
    """Return the fastest pair and the capacitances of the map; none where the battery has no pair."""
    if not pairs.time_constant_s:
        return 0, np.empty(0)
    fast = int(np.argmin(pairs.time_constant_s))
    nominal = pairs.time_constant_s[fast] / pairs.resistance_ohm[fast]
    return fast, np.geomspace(nominal / MAP_SPAN, nominal * MAP_SPAN, MAP_POINTS)


def _map(period: Steps, pairs: Pairs, energy_j: float) -> dict[str, Array]:
    fast, capacitances = _capacitances(pairs)
    energies = np.geomspace(energy_j / MAP_SPAN, energy_j * MAP_SPAN, MAP_POINTS)
    best = frequency_map_hz(period, pairs, fast, capacitances, energies) if len(capacitances) else np.empty(0)
    return {
        "switching_energy_j": np.tile(energies, len(capacitances)),
        "capacitance_f": np.repeat(capacitances, MAP_POINTS),
        "optimal_frequency_hz": best.ravel(),
    }


def _contour(period: Steps, pairs: Pairs) -> dict[str, Array]:
    fast, capacitances = _capacitances(pairs)
    energies = contour_energy_j(period, pairs, fast, capacitances, CONTOUR_HZ)
    return {"capacitance_f": capacitances, "switching_energy_j": energies}
