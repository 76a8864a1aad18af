"""What the loss against frequency comes to, as named numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from pipeline.objective.loss import (
    breakdown,
    discharge_resistor_loss_w,
    error_mw,
    integral_square_error,
    switching_energy_j,
)
from pipeline.objective.optimum import band_hz, optimal_frequency_hz
from pipeline.objective.records import Pairs, ReflexFrequency, Waveform
from pipeline.objective.ripple import impedance_minimum_hz, resonance_hz, steps, switched_currents_a
from pipeline.quantity import Quantity


def quantities(
    settings: ReflexFrequency, waveform: Waveform, pairs: Pairs, series_resistance_ohm: float
) -> list[Quantity]:
    """Return the numbers that describe the loss of a waveform against its frequency.

    Arguments
    ---------
    settings : the objective.
    waveform : of the mode the objective means.
    pairs : the battery's pairs, whole battery; the fastest is taken for the impedance.
    series_resistance_ohm : of the whole battery, at the objective's SOC [ohm].
    """
    period, energy = steps(waveform), switching_energy_j(settings.transistor, switched_currents_a(waveform))
    best = float(optimal_frequency_hz(period, pairs, energy))
    band = band_hz(period, pairs, energy, settings.band_share)
    impedance, resonance = _of_impedance(settings.inductance_h, pairs, series_resistance_ohm)
    classic = settings.classic_frequency_hz
    found = [
        Quantity("optimal_frequency_hz", best, "Hz", "frequency of least loss, where its derivative is zero"),
        Quantity("band_low_hz", band.low_hz, "Hz", "lower end of the band about it that makes no difference"),
        Quantity("band_high_hz", band.high_hz, "Hz", "upper end of that band"),
        Quantity("switching_energy_j", energy, "J", "energy of the switches in a period"),
        Quantity("impedance_minimum_hz", impedance, "Hz", "frequency of least impedance, which is not least loss"),
        Quantity("resonance_hz", resonance, "Hz", "frequency at which the impedance is real"),
        Quantity(
            "discharge_resistor_w",
            discharge_resistor_loss_w(waveform, settings.discharge_voltage_v),
            "W",
            "power the discharge resistor turns to heat, at any frequency",
        ),
    ]
    places = {
        "optimum": (best, "the optimum"),
        "classic": (classic, "the classic rate"),
        "impedance_minimum": (impedance, "the least impedance"),
    }
    for name, (frequency, place) in places.items():
        parts = breakdown(period, pairs, series_resistance_ohm, energy, frequency if frequency > 0.0 else np.nan)
        ise = float(integral_square_error(error_mw(period, pairs, energy, parts["frequency_hz"][0]), settings.window_s))
        found += [
            Quantity(f"ise_at_{name}", ise, "mW2 s", f"integral square error at {place}"),
            Quantity(f"pair_ripple_at_{name}_w", float(parts["pair_ripple_w"][0]), "W", f"ripple in pairs at {place}"),
            Quantity(f"switching_at_{name}_w", float(parts["switching_w"][0]), "W", f"switching loss at {place}"),
            Quantity(f"ripple_and_switching_at_{name}_w", float(parts["total_w"][0]), "W", f"both and R0 at {place}"),
        ]
    mean = float(breakdown(period, pairs, series_resistance_ohm, energy, best)["mean_current_w"][0])
    found.append(Quantity("mean_current_w", mean, "W", "loss of the mean current in all resistances, at any frequency"))
    return found


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
            Quantity(f"switching_energy_{mode}_j", energy, "J", f"energy of the switches in a period of {mode}"),
            Quantity(f"optimal_frequency_{mode}_hz", best, "Hz", f"frequency of least loss of {mode}"),
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
