"""Cuckoo search against mealpy's and NiaPy's on one problem and budget: time and result.

Run as `make bench`, or `PYTHONPATH=src python benchmarks/searches.py`; medians of the processor's time over interleaved
rounds, everything compiled, imported and configured before. All get the same compiled objective, each in the form that
costs it least: a population at once where a library can ask so, else one compiled function of a point, without any
wrapper around it. A library that is not installed is said to be so: see the extra `bench`.
"""

from __future__ import annotations

import importlib.util
import logging
import statistics
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numba
import numpy as np
import yaml

from pipeline.search.benchmark_functions import Problem, problem
from pipeline.search.box import Box
from pipeline.search.moves import Compiled
from pipeline.search.registry import algorithm, replicated, settings_from

CONF = Path(__file__).parents[1] / "conf"
NESTS, EVALUATIONS, DIMENSIONS = 25, 6000, 8
ROUNDS, FEWER_ROUNDS = 30, 5
MEALPY, NIAPY = "mealpy, OriginalCSA", "NiaPy, CuckooSearch"
Run = Callable[[int], tuple[float, int]]
"""Seed to the best value and the evaluations spent."""
Search = Callable[[Problem], Run]


class Entry(NamedTuple):
    """A search, and in how many rounds it takes part."""

    search: Search | None
    rounds: int = ROUNDS


def ours(kind: str, **own: object) -> Search:
    def prepare(where: Problem) -> Run:
        module, settings = algorithm(kind), settings_from({"kind": kind, "title": kind, "variables": box(where), **own})

        def run(seed: int) -> tuple[float, int]:
            history = module.minimise(where.objective, where.box, settings, np.random.default_rng(seed))
            return float(history.best_value()[0]), int(history.evaluations[0, -1])

        return run

    return prepare


def many(runs: int, **own: object) -> Search:
    """Return cuckoo search with many runs advanced together, as studies run it; time and evaluations are of all."""

    def prepare(where: Problem) -> Run:
        named = {"kind": "cuckoo", "title": "cuckoo", "variables": box(where), "replicates": runs}
        settings = settings_from(named | own)

        def run(seed: int) -> tuple[float, int]:
            history = replicated(where.objective, settings, seed)
            return float(np.median(history.best_value())), int(history.evaluations[:, -1].sum())

        return run

    return prepare


def box(where: Problem) -> dict[str, dict[str, float]]:
    edges = zip(where.box.low.tolist(), where.box.high.tolist(), strict=True)
    return {f"x{number}": {"low": low, "high": high} for number, (low, high) in enumerate(edges)}


def of_a_point(objective: Compiled) -> Callable[[np.ndarray], float]:
    """Return the objective compiled for one point, (d,) to a number: the least that a call from Python costs."""
    kernel, numbers = objective.jitted, objective.numbers

    @numba.njit
    def value(x):  # type: ignore[no-untyped-def]
        point, found = np.empty((1, len(x))), np.empty(1)
        point[0] = x
        kernel(numbers, point, found)
        return found[0]

    return value  # type: ignore[no-any-return]


def mealpy_search() -> Search | None:
    try:
        from mealpy import FloatVar
        from mealpy.swarm_based.CSA import OriginalCSA
    except ImportError:
        return None

    def prepare(where: Problem) -> Run:
        function = of_a_point(where.objective)
        bounds = FloatVar(lb=where.box.low.tolist(), ub=where.box.high.tolist())

        def run(seed: int) -> tuple[float, int]:
            # An epoch takes 1 to 2 evaluations of each nest, depending on pa; the budget stops it.
            model = OriginalCSA(epoch=EVALUATIONS, pop_size=NESTS, p_a=0.25)
            task: dict[str, Any] = {"obj_func": function, "bounds": bounds, "minmax": "min", "log_to": None}
            best = model.solve(task, termination={"max_fe": EVALUATIONS}, seed=seed)
            return float(best.target.fitness), int(model.nfe_counter)

        return run

    return prepare


def niapy_search() -> Search | None:
    try:
        from niapy.algorithms.basic import CuckooSearch
        from niapy.problems import Problem as NiapyProblem
        from niapy.task import Task
    except ImportError:
        return None

    def prepare(where: Problem) -> Run:
        class Ours(NiapyProblem):  # type: ignore[misc]
            _evaluate = staticmethod(of_a_point(where.objective))

        posed = Ours(dimension=len(where.box.low), lower=where.box.low, upper=where.box.high)

        def run(seed: int) -> tuple[float, int]:
            task = Task(problem=posed, max_evals=EVALUATIONS)
            _, best = CuckooSearch(population_size=NESTS, pa=0.25, seed=seed).run(task)
            return float(best), int(task.evals)

        return run

    return prepare


def problems() -> Iterator[tuple[str, Problem]]:
    for name in ("sphere", "rastrigin"):
        yield f"{name}, shifted", problem(name, "shifted", DIMENSIONS, 0.4, 1)
    if importlib.util.find_spec("pipeline.experiments.staging"):
        yield "stage currents", staged_charge()


def staged_charge() -> Problem:
    """Return the currents of eight stages, time and rise of equal weight."""
    from pipeline.cell.records import Battery
    from pipeline.experiments.staging.kernel import make_grid
    from pipeline.experiments.staging.records import Currents, Weights
    from pipeline.experiments.staging.stage_charges import Limits, objective_of

    sheet = yaml.safe_load((CONF / "battery/lfp_8ah.yaml").read_text())
    sheet.pop("sources", None)
    grid = make_grid(Battery(**sheet), np.linspace(0.1, 0.9, DIMENSIONS + 1), 25.0, 8.0)
    span, weights = Currents(low=8.0, high=40.0), Weights(time=5.0, rise=5.0)
    objective = objective_of(grid, span, weights, "positive", Limits(3.65, 55.0))
    edge = np.ones(DIMENSIONS)
    return Problem(objective, Box(8.0 * edge, 40.0 * edge), np.full(DIMENSIONS, np.nan))


def measured(where: Problem, searches: dict[str, Entry]) -> dict[str, tuple[float, float]]:
    """Return the median time of an evaluation [s] and the median best value of each search that is installed."""
    runs = {name: entry.search(where) for name, entry in searches.items() if entry.search is not None}
    times: dict[str, list[float]] = {name: [] for name in runs}
    values: dict[str, list[float]] = {name: [] for name in runs}
    for run in runs.values():
        run(0)
    for seed in range(ROUNDS):
        order = [name for name in runs if seed < searches[name].rounds]
        # A search that follows a large library finds the processor's caches full of that: each does in its turn.
        for place in np.random.default_rng(seed).permutation(len(order)):
            name = order[place]
            begin = time.process_time()
            value, evaluations = runs[name](seed)
            times[name].append((time.process_time() - begin) / evaluations)
            values[name].append(value)
    return {name: (statistics.median(times[name]), statistics.median(values[name])) for name in runs}


def told(searches: dict[str, Entry], found: dict[str, tuple[float, float]]) -> Iterator[str]:
    """Yield the table, with how much faster each search is than the peers; `*` where its result is no worse."""
    yield f"{'search':34s} {'ms a run':>9s} {'us/evaluation':>14s} {'mealpy':>9s} {'NiaPy':>9s} {'median best':>12s}"
    for name in searches:
        if name not in found:
            yield f"{name:34s} not installed"
            continue
        each, best = found[name]
        row = f"{name:34s} {1e3 * each * EVALUATIONS:9.2f} {1e6 * each:14.3f}"
        for peer in (MEALPY, NIAPY):
            if peer in found:
                seconds, result = found[peer]
                row += f" {seconds / each:7.1f}x" + ("*" if best <= result else " ")
            else:
                row += f" {'-':>9s}"
        yield f"{row} {best:12.6g}"


def main() -> None:
    logging.disable(logging.CRITICAL)
    own = {"nests": NESTS, "generations": (EVALUATIONS // NESTS - 1) // 2}
    swarm = {"w": 0.73, "c1": 1.5, "c2": 1.5, "velocity_limit": 0.5, "position_limit": "clamp", "rand": "uniform"}
    searches = {
        "cuckoo, plain": Entry(ours("cuckoo", **own)),
        "cuckoo, as programmed": Entry(ours("cuckoo", pa=0.75, **own)),
        "cuckoo, inertia": Entry(ours("cuckoo", inertia=0.9, inertia_end=0.4, **own)),
        "cuckoo, integral": Entry(ours("cuckoo", ki=0.05, **own)),
        "cuckoo, plain, 30 runs at once": Entry(many(30, **own)),
        "cuckoo, integral, 30 runs at once": Entry(many(30, ki=0.05, **own)),
        "swarm": Entry(ours("swarm", particles=NESTS, iterations=EVALUATIONS // NESTS - 1, **swarm)),
        "scipy, differential evolution": Entry(
            ours("differential_evolution", population=40, generations=149), FEWER_ROUNDS
        ),
        "pymoo, genetic": Entry(ours("genetic", population=40, generations=149), FEWER_ROUNDS),
        "pymoo, swarm": Entry(ours("particle_swarm", population=40, generations=149), FEWER_ROUNDS),
        MEALPY: Entry(mealpy_search()),
        NIAPY: Entry(niapy_search()),
    }
    print("mealpy, NiaPy: how many times faster than theirs, * where the result is no worse than theirs")
    for name, where in problems():
        found = measured(where, searches)
        print(f"\n{name}, {DIMENSIONS} dimensions, {EVALUATIONS} evaluations, {ROUNDS} rounds")
        print(*told(searches, found), sep="\n", flush=True)


if __name__ == "__main__":
    main()
