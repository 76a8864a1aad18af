"""What searches for a frequency come to, as named numbers: found values, how soon, how near, chaos against the rest."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import NamedTuple

import numpy as np

from pipeline.quantity import Quantity, Vocabulary
from pipeline.search.box import History
from pipeline.search.comparison import Difference, Summary, compare, final_distance, iterations_within

VARIABLE = "frequency_hz"
"""What is searched, and the value found."""
SWEEP = "sweep"
WITHIN_HZ = 1.0
ITERATIONS, DISTANCE = "iterations_to_within_1_hz", "final_distance_hz"
_SHORT = {ITERATIONS: "iterations", DISTANCE: "distance"}
_LOW, _HIGH = ("1", "lower end of its 95 % interval"), ("1", "upper end of its 95 % interval")
VOCABULARY = Vocabulary(
    {
        "frequency_hz": ("Hz", "the frequency found, best over the replicates"),
        "ise_mw2_s": ("mW2 s", "integral square error there"),
        "difference_from_sweep_hz": ("Hz", "the frequency found less the sweep's"),
        "{search}_frequency_hz": ("Hz", "best frequency of {search}"),
        "{search}_frequency_mean_hz": ("Hz", "mean over its replicates"),
        "{search}_frequency_deviation_hz": ("Hz", "standard deviation over its replicates"),
        "{search}_ise_mw2_s": ("mW2 s", "integral square error of its best replicate"),
        "{search}_ise_mean_mw2_s": ("mW2 s", "mean over its replicates"),
        "{search}_iterations": ("1", "its iterations"),
        "{search}_evaluations": ("1", "its evaluations in a replicate"),
        "{search}_replicates": ("1", "its replicates"),
        f"{{search}}_{ITERATIONS}": ("1", "mean over those that got there"),
        "{search}_arrived_share": ("1", "share of those that got there"),
        f"{{search}}_{DISTANCE}": ("Hz", "mean distance from the sweep's"),
        "iterations_{first}_over_{other}": (
            "1",
            "chance that {first} needs more iterations than {other}; 0.5: no difference",
        ),
        "iterations_{first}_over_{other}_low": _LOW,
        "iterations_{first}_over_{other}_high": _HIGH,
        "distance_{first}_over_{other}": (
            "1",
            "chance that {first} ends farther off than {other}; 0.5: no difference",
        ),
        "distance_{first}_over_{other}_low": _LOW,
        "distance_{first}_over_{other}_high": _HIGH,
    }
)
"""The numbers of the searches; `search` is any, `first` the one whose result is used, `other` any of the others."""


class Outcome(NamedTuple):
    """Found frequency, statistics of each search, comparisons of all pairs, and the named numbers."""

    frequency_hz: float
    statistics: list[Summary]
    differences: list[Difference]
    quantities: list[Quantity]


def outcome(histories: Mapping[str, History], seed: int, first_only: bool = False, resamples: int = 2000) -> Outcome:
    """Return what searches for one frequency come to.

    Arguments
    ---------
    histories : search -> its history; the first is the one whose result is used, `sweep` the one all are held against.
        The first is compared with those of as many replicates.
    seed : of the bootstrap's resamples.
    resamples : of the bootstrap, for each interval.
    first_only : whether only the first is compared with the others, and not these with each other.
    """
    first = next(iter(histories))
    target, _ = _best(histories[SWEEP])
    measures = {ITERATIONS: iterations_within(target, WITHIN_HZ), DISTANCE: final_distance(target)}
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(1,)))
    peers = {name: history for name, history in histories.items() if _peer(name, history, histories[first])}
    statistics, differences = compare(peers, measures, rng, resamples, first_only)
    others = {name: history for name, history in histories.items() if name not in peers}
    statistics += compare(others, measures, rng, resamples)[0]
    frequency, ise = _best(histories[first])
    found = [
        VOCABULARY.quantity("frequency_hz", frequency),
        VOCABULARY.quantity("ise_mw2_s", ise),
        VOCABULARY.quantity("difference_from_sweep_hz", frequency - target),
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
    number = partial(VOCABULARY.quantity, search=name)
    return [
        number("{search}_frequency_hz", frequency),
        number("{search}_frequency_mean_hz", float(np.mean(ends))),
        number("{search}_frequency_deviation_hz", spread),
        number("{search}_ise_mw2_s", ise),
        number("{search}_ise_mean_mw2_s", float(np.mean(history.best_value()))),
        number("{search}_iterations", history.value.shape[1] - 1),
        number("{search}_evaluations", history.evaluations[0, -1]),
        number("{search}_replicates", len(ends)),
        number(f"{{search}}_{ITERATIONS}", measured[ITERATIONS].mean.value),
        number("{search}_arrived_share", measured[ITERATIONS].arrived_share),
        number(f"{{search}}_{DISTANCE}", measured[DISTANCE].mean.value),
    ]


def _of_differences(first: str, differences: list[Difference]) -> list[Quantity]:
    found = []
    for row in differences:
        if row.first != first:
            continue
        pattern = f"{_SHORT[row.measure]}_{{first}}_over_{{other}}"
        number = partial(VOCABULARY.quantity, first=first, other=row.second)
        found += [
            number(pattern, row.larger.value),
            number(f"{pattern}_low", row.larger.low),
            number(f"{pattern}_high", row.larger.high),
        ]
    return found
