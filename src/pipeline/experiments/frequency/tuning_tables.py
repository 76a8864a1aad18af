"""The numbers of the frequency's steps, and the tables of the tuning, from arrays to columns."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.quantity import Vocabulary
from pipeline.taguchi.analysis import Anova, agreement, level_sums, signal_to_noise_db

Array = NDArray[np.float64]
Levels = NDArray[np.int64]
Factors = Mapping[str, tuple[float, ...]]
Columns = dict[str, Any]

KNOBS = ("c1", "c2", "w")
SEARCHES_PER_RUN = (1, 2, 5, 10, 25)
"""How many searches a result is the mean of where the array is held against the factorial; the paper takes 5."""


def runs(factors: Factors, array: Levels, values: Array) -> Columns:
    """Return a row per run and replicate; values (m, n)."""
    count, replicates = values.shape
    knobs = _knobs(factors, array)
    return {
        "run": np.repeat(np.arange(1, count + 1), replicates),
        "replicate": np.tile(np.arange(replicates), count),
        **{name: np.repeat(column, replicates) for name, column in knobs.items()},
        "result": values.ravel(),
    }


def levels(factors: Factors, array: Levels, values: Array) -> Columns:
    """Return a row per factor and level; values (m, n)."""
    means, noise = np.mean(values, axis=1), signal_to_noise_db(values)
    rows: list[tuple[Any, ...]] = []
    of_means, of_noise = level_sums(array, means), level_sums(array, noise)
    for place, (name, settings) in enumerate(factors.items()):
        counts = np.bincount(array[:, place], minlength=len(settings))
        for level, setting in enumerate(settings):
            total = float(of_means[place][level])
            ratio = float(of_noise[place][level] / counts[level])
            chosen = bool(level == np.argmin(of_means[place]))
            rows.append((name, level + 1, setting, total, total / float(counts[level]), ratio, chosen))
    names = ("factor", "level", "setting", "sum", "mean", "signal_to_noise_db", "chosen")
    return {column: [row[place] for row in rows] for place, column in enumerate(names)}


def sums(factors: Factors, array: Levels, values: Array) -> Columns:
    """Return a row per level, a column per factor; values (m, n)."""
    by_factor = dict(zip(factors, level_sums(array, np.mean(values, axis=1)), strict=True))
    most = max(len(column) for column in by_factor.values())
    padded = {name: np.append(column, np.full(most - len(column), np.nan)) for name, column in by_factor.items()}
    return {"level": np.arange(1, most + 1)} | {name: padded.get(name, np.full(most, np.nan)) for name in KNOBS}


def variance(found: Anova) -> Columns:
    """Return the lines of an analysis of variance."""
    rows = found.rows()
    return {
        "source": [row.name for row in rows],
        "sum_of_squares": [row.sum_of_squares for row in rows],
        "degrees_of_freedom": [row.degrees_of_freedom for row in rows],
        "mean_square": [row.mean_square for row in rows],
        "f": [row.f for row in rows],
        "p": [row.p for row in rows],
    }


def factorial(factors: Factors, combinations: Levels, values: Array, in_array: Levels) -> Columns:
    """Return a row per combination; values (m, n), `in_array` the rows that the array holds."""
    means = np.mean(values, axis=1)
    ranks = np.argsort(np.argsort(means, kind="stable"), kind="stable") + 1
    spread = np.std(values, axis=1, ddof=1) if values.shape[1] > 1 else np.full(len(means), np.nan)
    return _knobs(factors, combinations) | {
        "mean": means,
        "standard_deviation": spread,
        "rank": ranks,
        "in_array": np.isin(np.arange(len(means)), in_array),
    }


def agreements(names: tuple[str, ...], array: Levels, counts: tuple[int, ...], values: Array) -> Columns:
    """Return a row per number of searches behind a result, as far as the factorial's replicates (m, n) allow."""
    found = [agreement(array, counts, values, size) for size in SEARCHES_PER_RUN if 2 * size <= values.shape[1]]
    shares = {f"{name}_share": [row.factor_shares[names.index(name)] if name in names else None for row in found]
              for name in KNOBS}  # fmt: skip
    own = ("searches_per_run", "experiments", "found_share", "factorial_found_share")
    last = ("mean_rank", "mean_rank_of_best_run", "mean_regret")
    return {name: [getattr(row, name) for row in found] for name in (*own, *last)} | shares


def _knobs(factors: Factors, array: Levels) -> dict[str, Array]:
    """Return what each knob is set to in each run; NaN for one that the design does not vary."""
    place = {name: index for index, name in enumerate(factors)}
    return {
        name: np.array(factors[name])[array[:, place[name]]] if name in place else np.full(len(array), np.nan)
        for name in KNOBS
    }


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
        "all_losses_at_classic_w": ("W", "mean current, ripple, switches and discharge resistor at the classic rate"),
        "classic_warmer_k": ("K", "rise of what the classic rate loses more than the optimum, once settled"),
        "classic_less_efficient_share": ("1", "the same loss over the power charged"),
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
