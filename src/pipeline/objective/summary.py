"""What the loss against frequency comes to, as named numbers."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipeline.objective.error import error_mw, integral_square_error
from pipeline.objective.impedance import impedance_minimum_hz, resonance_hz
from pipeline.objective.loss import breakdown, discharge_resistor_loss_w, switching_energy_j
from pipeline.objective.optimum import band_hz, optimal_frequency_hz
from pipeline.objective.records import Pairs, ReflexFrequency, Waveform
from pipeline.objective.waveform import steps, switched_currents_a


class Quantity(NamedTuple):
    """A named number with its unit and meaning."""

    name: str
    value: float
    unit: str
    description: str


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
    fast = int(np.argmin(pairs.time_constant_s))
    resistance, capacitance = pairs.resistance_ohm[fast], pairs.time_constant_s[fast] / pairs.resistance_ohm[fast]
    impedance = impedance_minimum_hz(settings.inductance_h, series_resistance_ohm, resistance, capacitance)
    resonance = resonance_hz(settings.inductance_h, resistance, capacitance)
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
    for name, frequency in (("optimum", best), ("classic", classic), ("impedance_minimum", impedance)):
        if not 0.0 < frequency < np.inf:
            continue
        parts = breakdown(period, pairs, series_resistance_ohm, energy, frequency)
        error = error_mw(period, pairs, energy, frequency)
        ise = float(integral_square_error(error, settings.window_s))
        place = {"optimum": "the optimum", "classic": "the classic rate", "impedance_minimum": "the least impedance"}[
            name
        ]
        found += [
            Quantity(f"ise_at_{name}", ise, "mW2 s", f"integral square error at {place}"),
            Quantity(f"pair_ripple_at_{name}_w", float(parts["pair_ripple_w"][0]), "W", f"ripple in pairs at {place}"),
            Quantity(f"switching_at_{name}_w", float(parts["switching_w"][0]), "W", f"switching loss at {place}"),
            Quantity(f"ripple_and_switching_at_{name}_w", float(parts["total_w"][0]), "W", f"both and R0 at {place}"),
        ]
    mean = float(breakdown(period, pairs, series_resistance_ohm, energy, best)["mean_current_w"][0])
    found.append(Quantity("mean_current_w", mean, "W", "loss of the mean current in all resistances, at any frequency"))
    return found
