"""The numbers that the steps of frequency find: names, units, meanings."""

from __future__ import annotations

from pipeline.quantity import Vocabulary

PLACES = {"optimum": "the optimum", "classic": "the classic rate", "impedance_minimum": "the least impedance"}

OF_A_PLACE = {
    "ise_at_{place}": ("mW2 s", "integral square error at {words}"),
    "pair_ripple_at_{place}_w": ("W", "ripple in pairs at {words}"),
    "switching_at_{place}_w": ("W", "switching loss at {words}"),
    "ripple_and_switching_at_{place}_w": ("W", "both and R0 at {words}"),
}

OBJECTIVE_NUMBERS = Vocabulary(
    {
        "optimal_frequency_hz": ("Hz", "frequency of least loss, where its derivative is zero"),
        "band_low_hz": ("Hz", "lower end of the band about it that makes no difference"),
        "band_high_hz": ("Hz", "upper end of that band"),
        "switching_energy_j": ("J", "energy of the switches in a period"),
        "impedance_minimum_hz": ("Hz", "frequency of least impedance, which is not least loss"),
        "resonance_hz": ("Hz", "frequency at which the impedance is real"),
        "discharge_resistor_w": ("W", "power the discharge resistor turns to heat, at any frequency"),
        "mean_current_w": ("W", "loss of the mean current in all resistances, at any frequency"),
        "switching_energy_{mode}_j": ("J", "energy of the switches in a period of {mode}"),
        "optimal_frequency_{mode}_hz": ("Hz", "frequency of least loss of {mode}"),
    }
    | {
        name.format(place=place): (unit, text.format(words=words))
        for place, words in PLACES.items()
        for name, (unit, text) in OF_A_PLACE.items()
    }
)
"""The numbers of the loss against frequency; `mode` is a charging mode with pulses."""

_DISTANCE = "largest distance between the distribution function of the values at r = 4 and the {} one"

CHAOS_NUMBERS = Vocabulary(
    {
        "most_disordered_r_{bins}_bins": ("1", "r of most entropy, {bins} bins"),
        "most_entropy_{bins}_bins_nats": ("nat", "entropy there"),
        "entropy_at_4_{bins}_bins_nats": ("nat", "entropy at r = 4"),
        "exact_entropy_at_4_{bins}_bins_nats": ("nat", "the same, exactly"),
        "uniform_entropy_{bins}_bins_nats": ("nat", "entropy of uniform numbers"),
        "most_unstable_r": ("1", "r of the largest Lyapunov exponent"),
        "lyapunov_at_4_nats": ("nat/step", "Lyapunov exponent at r = 4"),
        "mean_at_4": ("1", "mean of the values at r = 4; 1/2 for uniform numbers"),
        "variance_at_4": ("1", "their variance; 1/12 for uniform numbers"),
        "distance_to_uniform": ("1", _DISTANCE.format("uniform")),
        "distance_to_arcsine": ("1", _DISTANCE.format("arcsine")),
    }
)
"""The numbers of the logistic map; `bins` is a number of bins."""
