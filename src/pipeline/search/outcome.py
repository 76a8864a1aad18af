"""What searches for a frequency come to, as named numbers: found values, how soon, how near, chaos against the rest."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from pipeline.quantity import Quantity
from pipeline.search.comparison import Difference, Summary, compare, final_distance, iterations_within
from pipeline.search.history import History

SWEEP = "sweep"
WITHIN_HZ = 1.0
ITERATIONS, DISTANCE = "iterations_to_within_1_hz", "final_distance_hz"


class Outcome(NamedTuple):
    """Found frequency, statistics of each search, comparisons of all pairs, and the named numbers."""

    frequency_hz: float
    statistics: list[Summary]
    differences: list[Difference]
    quantities: list[Quantity]


def outcome(histories: Mapping[str, History], seed: int) -> Outcome:
    """Return what searches for one frequency come to.

    Arguments
    ---------
    histories : search -> its history; the first is the one whose result is used, `sweep` the one all are held against.
        The first is compared with those of as many replicates.
    seed : of the bootstrap's resamples.
    """
    first = next(iter(histories))
    target, _ = _best(histories[SWEEP])
    measures = {ITERATIONS: iterations_within(target, WITHIN_HZ), DISTANCE: final_distance(target)}
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(1,)))
    peers = {name: history for name, history in histories.items() if _peer(name, history, histories[first])}
    statistics, differences = compare(peers, measures, rng)
    others = {name: history for name, history in histories.items() if name not in peers}
    statistics += compare(others, measures, rng)[0]
    frequency, ise = _best(histories[first])
    found = [
        Quantity("frequency_hz", frequency, "Hz", "the frequency found, best over the replicates"),
        Quantity("ise_mw2_s", ise, "mW2 s", "integral square error there"),
        Quantity("difference_from_sweep_hz", frequency - target, "Hz", "the frequency found less the sweep's"),
    ]
    for name, history in histories.items():
        found += _of_search(name, history, statistics)
    found += _of_differences(first, differences)
    return Outcome(frequency, statistics, differences, found)


def _peer(name: str, history: History, first: History) -> bool:
    return name != SWEEP and len(history.value) == len(first.value)


def _best(history: History) -> tuple[float, float]:
    """Return the first variable and the value of the replicate that ended best."""
    best = int(np.argmin(history.best_value()))
    return float(history.best_position()[best, 0]), float(history.best_value()[best])


def _of_search(name: str, history: History, statistics: list[Summary]) -> list[Quantity]:
    frequency, ise = _best(history)
    ends = history.best_position()[:, 0]
    spread = float(np.std(ends, ddof=1)) if len(ends) > 1 else np.nan
    measured = {row.measure: row for row in statistics if row.search == name}
    return [
        Quantity(f"{name}_frequency_hz", frequency, "Hz", f"best frequency of {name}"),
        Quantity(f"{name}_frequency_mean_hz", float(np.mean(ends)), "Hz", "mean over its replicates"),
        Quantity(f"{name}_frequency_deviation_hz", spread, "Hz", "standard deviation over its replicates"),
        Quantity(f"{name}_ise_mw2_s", ise, "mW2 s", "integral square error of its best replicate"),
        Quantity(f"{name}_ise_mean_mw2_s", float(np.mean(history.best_value())), "mW2 s", "mean over its replicates"),
        Quantity(f"{name}_iterations", float(history.value.shape[1] - 1), "1", "its iterations"),
        Quantity(f"{name}_evaluations", float(history.evaluations[0, -1]), "1", "its evaluations in a replicate"),
        Quantity(f"{name}_replicates", float(len(ends)), "1", "its replicates"),
        Quantity(f"{name}_{ITERATIONS}", measured[ITERATIONS].mean.value, "1", "mean over those that got there"),
        Quantity(f"{name}_arrived_share", measured[ITERATIONS].arrived_share, "1", "share of those that got there"),
        Quantity(f"{name}_final_distance_hz", measured[DISTANCE].mean.value, "Hz", "mean distance from the sweep's"),
    ]


def _of_differences(first: str, differences: list[Difference]) -> list[Quantity]:
    found = []
    words = {ITERATIONS: ("iterations", "needs more iterations"), DISTANCE: ("distance", "ends farther off")}
    for row in differences:
        if row.first != first:
            continue
        short, says = words[row.measure]
        name = f"{short}_{first}_over_{row.second}"
        found += [
            Quantity(name, row.larger.value, "1", f"chance that {first} {says} than {row.second}; 0.5: no difference"),
            Quantity(f"{name}_low", row.larger.low, "1", "lower end of its 95 % interval"),
            Quantity(f"{name}_high", row.larger.high, "1", "upper end of its 95 % interval"),
        ]
    return found
