"""What searches on test functions come to: means, success rates, and whether a difference is one."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.search.benchmark_functions import problem
from pipeline.search.box import History
from pipeline.search.comparison import vargha_delaney
from pipeline.search.function_records import FunctionStudy
from pipeline.search.registry import replicated, replicated_alike

_POINTS_OF_A_CURVE = 120


class Runs(NamedTuple):
    """What the replicates of one search came to on one function in one placement; arrays of shape (r,)."""

    function: str
    placement: str
    search: str
    value: Array
    """Best value at the end."""
    value_at_budget: Array
    """Best value when as many evaluations were spent as the shortest search of the study spends."""
    generations: Array
    """Generations until the value was at or below the threshold; infinite: never."""
    evaluations: Array
    """The same in evaluations."""
    spent: Array
    """Evaluations in all."""


class Curve(NamedTuple):
    """How they converged: quantiles over the replicates at some generations, shape (k,) each."""

    function: str
    placement: str
    search: str
    generation: NDArray[np.int64]
    evaluations: Array
    low: Array
    median: Array
    high: Array
    mean: Array


def run(
    study: FunctionStudy, function: str, seed: int, told: Callable[[str], None] = lambda message: None
) -> Iterator[tuple[Runs, Curve]]:
    """Run every search on one function in every placement.

    Arguments
    ---------
    study : what to run.
    function : name of one of its functions.
    seed : root of the random streams; the placements have it in common with all other functions and searches.
    told : is told what is being run.

    Yields
    ------
    The runs of a search and the curve of their convergence.
    """
    problems = {
        placement: problem(function, placement, study.dimensions, study.shift_share, seed)
        for placement in study.placements
    }
    tasks = {
        (placement, name): (one.objective, one.box, settings)
        for placement, one in problems.items()
        for name, settings in study.searches(float(one.box.high[0])).items()
    }
    alike = {key: task for key, task in tasks.items() if key[1] in study.variants.searches}
    told(f"{function}: {', '.join(study.variants.searches)}")
    histories = dict(zip(alike, replicated_alike(list(alike.values()), seed), strict=True))
    for (placement, name), (objective, _, settings) in tasks.items():
        if (placement, name) not in histories:
            told(f"{function}, {placement}: {name}")
            histories[placement, name] = replicated(objective, settings, seed)
    budget = min(int(history.evaluations[:, -1].max()) for history in histories.values())
    for placement, name in tasks:
        history, names = histories[placement, name], (function, placement, name)
        yield _runs(history, study.threshold, budget, names), _curve(history, names)


def _runs(history: History, threshold: float, budget: int, names: tuple[str, str, str]) -> Runs:
    replicates = np.arange(len(history.value))
    reached = history.value <= threshold
    first = np.argmax(reached, axis=1)
    arrived = reached[:, -1]
    affordable = np.maximum(np.sum(history.evaluations <= budget, axis=1) - 1, 0)
    return Runs(
        *names,
        value=history.best_value(),
        value_at_budget=history.value[replicates, affordable],
        generations=np.where(arrived, first.astype(float), np.inf),
        evaluations=np.where(arrived, history.evaluations[replicates, first].astype(float), np.inf),
        spent=history.evaluations[:, -1].astype(float),
    )


def _curve(history: History, names: tuple[str, str, str]) -> Curve:
    last = history.value.shape[1] - 1
    shown = np.unique(np.rint(np.geomspace(1, last + 1, _POINTS_OF_A_CURVE)).astype(np.int64) - 1)
    values = history.value[:, shown]
    low, median, high = np.quantile(values, [0.25, 0.5, 0.75], axis=0)
    return Curve(*names, shown, history.evaluations[:, shown].mean(axis=0), low, median, high, mean=values.mean(axis=0))


Array = NDArray[np.float64]
Key = tuple[str, str, str]

SIGNIFICANT = 0.05
VALUE, GENERATIONS = "value", "generations"
RESOLUTION = 1e-16
"""Values below are told apart by nobody: they count as equal in tests and ranks, and as 0 in a printed table."""


class Statistics(NamedTuple):
    """One search on one function in one placement, over its replicates."""

    function: str
    placement: str
    search: str
    replicates: int
    mean: float
    deviation: float
    median: float
    best: float
    mean_at_budget: float
    success_share: float
    generations: float
    """Mean generations to the threshold, of the successful runs; NaN: none was."""
    generations_deviation: float
    evaluations: float
    spent: float


class Contest(NamedTuple):
    """A search against the plain one on one function in one placement."""

    function: str
    placement: str
    search: str
    measure: str
    p: float
    """Chance of such a difference between two searches that do not differ: Wilcoxon's signed ranks, in pairs."""
    p_holm: float
    """The same, corrected for the number of tests of this search, placement and measure (Holm, 1979)."""
    larger: float
    """Vargha and Delaney's A: chance that the search's is larger, that is worse."""
    better: bool
    worse: bool


class Ranks(NamedTuple):
    """Friedman's test of the searches over the functions of one placement."""

    placement: str
    measure: str
    mean_rank: dict[str, float]
    """Search -> mean rank of its mean; 1 is best."""
    p: float


def statistics(runs: Iterable[Runs]) -> list[Statistics]:
    """Return a row per search, function and placement."""
    return [_statistics(one) for one in runs]


def contests(runs: Sequence[Runs], plain: str, variants: Sequence[str]) -> list[Contest]:
    """Return the tests of each variant against the plain one, run from the same starts, on every function.

    Arguments
    ---------
    runs : of all searches, functions and placements.
    plain : the variant to compare with.
    variants : all variants; each has as many replicates as the plain one.
    """
    by_key: dict[Key, Runs] = {(one.search, one.function, one.placement): one for one in runs}
    placements, functions = _distinct(one.placement for one in runs), _distinct(one.function for one in runs)
    found: list[Contest] = []
    for search in (name for name in variants if name != plain):
        for placement in placements:
            for measure in (VALUE, GENERATIONS):
                pairs = [
                    [_measured(by_key[one, name, placement], measure) for one in (search, plain)] for name in functions
                ]
                raw = [signed_rank(own, other) for own, other in pairs]
                for name, (own, other), p, p_holm in zip(functions, pairs, raw, holm(raw), strict=True):
                    larger = vargha_delaney(own, other)
                    sure = p_holm < SIGNIFICANT
                    better, worse = bool(sure and larger < 0.5), bool(sure and larger > 0.5)
                    found.append(Contest(name, placement, search, measure, p, p_holm, larger, better, worse))
    return found


def ranks(rows: Sequence[Statistics], variants: Sequence[str]) -> list[Ranks]:
    """Return Friedman's test for each placement, on the mean value at the end and at the shortest search's budget."""
    by_key = {(row.search, row.function, row.placement): row for row in rows}
    placements, functions = _distinct(row.placement for row in rows), _distinct(row.function for row in rows)
    everyone = _distinct(row.search for row in rows)
    found = []
    for placement in placements:
        for measure, searches in (("mean", variants), ("mean_at_budget", everyone)):
            if len(searches) < 2:
                continue
            table = np.array(
                [[getattr(by_key[name, function, placement], measure) for name in searches] for function in functions]
            )
            mean_rank, p = friedman(np.maximum(table, RESOLUTION))
            found.append(Ranks(placement, measure, dict(zip(searches, mean_rank.tolist(), strict=True)), p))
    return found


def signed_rank(first: Array, second: Array) -> float:
    """Return the p of Wilcoxon's signed-rank test on pairs; 1 where no pair differs."""
    from scipy.stats import wilcoxon

    if np.array_equal(first, second):
        return 1.0
    # Exact for small samples without ties or zeros; else its normal approximation.
    return float(wilcoxon(first, second, zero_method="pratt", method="auto", correction=True).pvalue)


def friedman(table: Array) -> tuple[Array, float]:
    """Return mean ranks (k,) and the p of Friedman's test of k searches on n functions, from values (n, k)."""
    from scipy.stats import chi2, rankdata

    ranked = rankdata(table, axis=1)
    n, k = ranked.shape
    mean: Array = ranked.mean(axis=0)
    # Corrected for ties: the ranks' own variance in place of that of 1 ... k.
    spread = float(np.sum((ranked - 0.5 * (k + 1)) ** 2))
    if spread == 0.0:
        return mean, 1.0
    statistic = (k - 1) * n**2 * float(np.sum((mean - 0.5 * (k + 1)) ** 2)) / spread
    return mean, float(chi2.sf(statistic, k - 1))


def holm(p: Sequence[float]) -> list[float]:
    """Return p values corrected for their number (Holm, Scand. J. Stat. 6 (1979) 65)."""
    order = np.argsort(p, kind="stable")
    factors = len(p) - np.arange(len(p))
    rising = np.minimum(np.maximum.accumulate(np.asarray(p, dtype=float)[order] * factors), 1.0)
    corrected = np.empty(len(p))
    corrected[order] = rising
    return [float(value) for value in corrected]


def speedup(rows: Mapping[str, Statistics], plain: Mapping[str, Statistics]) -> float:
    """Return by which factor fewer generations a search needs: geometric mean over functions both always solve."""
    shared = [
        name for name, row in rows.items() if row.success_share == 1.0 and plain[name].success_share == 1.0
        and row.generations > 0.0
    ]  # fmt: skip
    if not shared:
        return np.nan
    return float(np.exp(np.mean([np.log(plain[name].generations / rows[name].generations) for name in shared])))


def _statistics(one: Runs) -> Statistics:
    arrived = np.isfinite(one.generations)
    generations, evaluations = one.generations[arrived], one.evaluations[arrived]
    return Statistics(
        one.function,
        one.placement,
        one.search,
        len(one.value),
        mean=float(np.mean(one.value)),
        deviation=float(np.std(one.value, ddof=1)),
        median=float(np.median(one.value)),
        best=float(np.min(one.value)),
        mean_at_budget=float(np.mean(one.value_at_budget)),
        success_share=float(np.mean(arrived)),
        generations=float(np.mean(generations)) if arrived.any() else np.nan,
        generations_deviation=float(np.std(generations, ddof=1)) if arrived.sum() > 1 else np.nan,
        evaluations=float(np.mean(evaluations)) if arrived.any() else np.nan,
        spent=float(np.mean(one.spent)),
    )


def _measured(one: Runs, measure: str) -> Array:
    """Return what is compared; a run that never arrives counts as slower than any that does."""
    if measure == VALUE:
        return np.maximum(one.value, RESOLUTION)
    return np.where(np.isfinite(one.generations), one.generations, 1e9)


def _distinct(names: Iterable[str]) -> list[str]:
    return list(dict.fromkeys(names))
