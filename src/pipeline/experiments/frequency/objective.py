"""Objective: a waveform, a battery's pairs and its switches in; loss against frequency and what moves the best out."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.experiments.frequency.tuning_tables import OBJECTIVE_NUMBERS
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.objective.optimum import (
    Steps,
    band_hz,
    breakdown,
    contour_energy_j,
    discharge_resistor_loss_w,
    error_mw,
    frequency_map_hz,
    impedance_minimum_hz,
    integral_square_error,
    mean_current_a,
    optimal_frequency_hz,
    resonance_hz,
    steps,
    switched_currents_a,
    switching_energy_j,
)
from pipeline.objective.records import Pairs, ReflexFrequency, Waveform
from pipeline.quantity import Quantity


def quantities(
    settings: ReflexFrequency,
    waveform: Waveform,
    pairs: Pairs,
    series_resistance_ohm: float,
    thermal_resistance_k_w: float = math.nan,
) -> list[Quantity]:
    """Return the numbers that describe the loss of a waveform against its frequency.

    Arguments
    ---------
    settings : the objective.
    waveform : of the mode the objective means.
    pairs : the battery's pairs, whole battery; the fastest is taken for the impedance.
    series_resistance_ohm : of the whole battery, at the objective's SOC [ohm].
    thermal_resistance_k_w : from the battery to the surroundings [K/W].
    """
    period, energy = steps(waveform), switching_energy_j(settings.transistor, switched_currents_a(waveform))
    best = float(optimal_frequency_hz(period, pairs, energy))
    band = band_hz(period, pairs, energy, settings.band_share)
    impedance, resonance = _of_impedance(settings.inductance_h, pairs, series_resistance_ohm)
    number = OBJECTIVE_NUMBERS.quantity
    found = [
        number("optimal_frequency_hz", best),
        number("band_low_hz", band.low_hz),
        number("band_high_hz", band.high_hz),
        number("switching_energy_j", energy),
        number("impedance_minimum_hz", impedance),
        number("resonance_hz", resonance),
        number("discharge_resistor_w", discharge_resistor_loss_w(waveform, settings.discharge_voltage_v)),
    ]
    places = {"optimum": best, "classic": settings.classic_frequency_hz, "impedance_minimum": impedance}
    for place, frequency in places.items():
        parts = breakdown(period, pairs, series_resistance_ohm, energy, frequency if frequency > 0.0 else np.nan)
        ise = float(integral_square_error(error_mw(period, pairs, energy, parts["frequency_hz"][0]), settings.window_s))
        found += [
            number(f"ise_at_{place}", ise),
            number(f"pair_ripple_at_{place}_w", parts["pair_ripple_w"][0]),
            number(f"switching_at_{place}_w", parts["switching_w"][0]),
            number(f"ripple_and_switching_at_{place}_w", parts["total_w"][0]),
        ]
    at_best = breakdown(period, pairs, series_resistance_ohm, energy, best)
    mean, least = at_best["mean_current_w"][0], at_best["total_w"][0]
    classic = breakdown(period, pairs, series_resistance_ohm, energy, settings.classic_frequency_hz)["total_w"][0]
    resistor = discharge_resistor_loss_w(waveform, settings.discharge_voltage_v)
    charged_w = settings.discharge_voltage_v * mean_current_a(period)
    return [
        *found,
        number("mean_current_w", mean),
        number("all_losses_at_classic_w", mean + classic + resistor),
        number("classic_warmer_k", thermal_resistance_k_w * (classic - least)),
        number("classic_less_efficient_share", (classic - least) / charged_w),
    ]


def of_modes(settings: ReflexFrequency, waveforms: Mapping[str, Waveform], pairs: Pairs) -> list[Quantity]:
    """Return what the switches take and which frequency would be best, for each mode with pulses.

    Arguments
    ---------
    settings : the objective, whose switches all modes use.
    waveforms : mode -> its waveform.
    pairs : the battery's pairs, whole battery.
    """
    found = []
    for mode, waveform in waveforms.items():
        energy = switching_energy_j(settings.transistor, switched_currents_a(waveform))
        best = float(optimal_frequency_hz(steps(waveform), pairs, energy))
        found += [
            OBJECTIVE_NUMBERS.quantity("switching_energy_{mode}_j", energy, mode=mode),
            OBJECTIVE_NUMBERS.quantity("optimal_frequency_{mode}_hz", best, mode=mode),
        ]
    return found


def _of_impedance(inductance_h: float, pairs: Pairs, series_resistance_ohm: float) -> tuple[float, float]:
    """Return the frequencies [Hz] of least and of real impedance with the fastest pair; NaN without a pair."""
    if not pairs.time_constant_s:
        return math.nan, math.nan
    fast = int(np.argmin(pairs.time_constant_s))
    resistance, capacitance = pairs.resistance_ohm[fast], pairs.time_constant_s[fast] / pairs.resistance_ohm[fast]
    least = impedance_minimum_hz(inductance_h, series_resistance_ohm, resistance, capacitance)
    return least, resonance_hz(inductance_h, resistance, capacitance)


Array = NDArray[np.float64]

FREQUENCIES_HZ = np.geomspace(0.5, 2000.0, 721)
MAP_POINTS = 41
MAP_SPAN = 10.0
"""The map goes from a tenth to ten times the configured energy and capacitance."""
CONTOUR_HZ = 90.0


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Compute the loss over frequency, the map of the best frequency, and the named numbers."""
    chosen = ReflexFrequency.model_validate(settings["objective"])
    waveforms = {name: Waveform.model_validate(waveform) for name, waveform in settings["waveforms"].items()}
    pairs = Pairs(*(tuple(part) for part in settings["pairs"]))
    series, thermal = float(settings["series_resistance_ohm"]), float(settings["thermal_resistance_k_w"])
    waveform = waveforms[chosen.mode]
    period, energy = steps(waveform), switching_energy_j(chosen.transistor, switched_currents_a(waveform))
    output.write("loss", _loss(period, pairs, series, energy, chosen.window_s))
    output.write("map", _map(period, pairs, energy))
    output.write("contour", _contour(period, pairs))
    output.numbers([*quantities(chosen, waveform, pairs, series, thermal), *of_modes(chosen, waveforms, pairs)])


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
