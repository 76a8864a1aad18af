"""Cuckoo search against mealpy's and NiaPy's on one problem and budget: time and result.

Run as `make bench`, or `PYTHONPATH=src python benchmarks/searches.py`; medians of the processor's time over interleaved
rounds, everything compiled and imported before. All get the same compiled objective, each in the way it takes one: a
population at once, or a point at a time. A library that is not installed is said to be so: see the extra `bench`.
"""

from __future__ import annotations

import importlib.util
import logging
import statistics
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import yaml

from pipeline.search.benchmark_functions import Problem, problem
from pipeline.search.box import Box
from pipeline.search.registry import algorithm, replicated, settings_from

CONF = Path(__file__).parents[1] / "conf"
NESTS, EVALUATIONS, ROUNDS, DIMENSIONS = 25, 6000, 7, 8
Search = Callable[[Problem, int], tuple[float, int]]
"""Problem and seed to the best value and the evaluations spent."""


def ours(kind: str, **own: object) -> Search:
    def run(where: Problem, seed: int) -> tuple[float, int]:
        settings = settings_from({"kind": kind, "title": kind, "variables": variables(where), **own})
        history = algorithm(kind).minimise(where.objective, where.box, settings, np.random.default_rng(seed))
        return float(history.best_value()[0]), int(history.evaluations[0, -1])

    return run


def many(runs: int, **own: object) -> Search:
    """Return cuckoo search with many runs advanced together, as studies run it; time and evaluations are of all."""

    def run(where: Problem, seed: int) -> tuple[float, int]:
        settings = settings_from({"kind": "cuckoo", "title": "cuckoo", "variables": variables(where), **own})
        history = replicated(where.objective, settings.model_copy(update={"replicates": runs}), seed)
        return float(np.median(history.best_value())), int(history.evaluations[:, -1].sum())

    return run


def variables(where: Problem) -> dict[str, dict[str, float]]:
    edges = zip(where.box.low.tolist(), where.box.high.tolist(), strict=True)
    return {f"x{number}": {"low": low, "high": high} for number, (low, high) in enumerate(edges)}


def counted(where: Problem) -> tuple[Callable[[np.ndarray], float], list[int]]:
    calls = [0]

    def function(x: np.ndarray) -> float:
        calls[0] += 1
        return float(where.objective(np.asarray(x, dtype=float)[None])[0])

    return function, calls


def mealpy_search() -> Search | None:
    try:
        from mealpy import FloatVar
        from mealpy.swarm_based.CSA import OriginalCSA
    except ImportError:
        return None

    def run(where: Problem, seed: int) -> tuple[float, int]:
        function, calls = counted(where)
        bounds = FloatVar(lb=where.box.low.tolist(), ub=where.box.high.tolist())
        # An epoch takes 1 to 2 evaluations of each nest, depending on pa; the budget stops it.
        model = OriginalCSA(epoch=EVALUATIONS, pop_size=NESTS, p_a=0.25)
        task = {"obj_func": function, "bounds": bounds, "minmax": "min", "log_to": None}
        best = model.solve(task, termination={"max_fe": EVALUATIONS}, seed=seed)
        return float(best.target.fitness), calls[0]

    return run


def niapy_search() -> Search | None:
    try:
        from niapy.algorithms.basic import CuckooSearch
        from niapy.problems import Problem as NiapyProblem
        from niapy.task import Task
    except ImportError:
        return None

    def run(where: Problem, seed: int) -> tuple[float, int]:
        function, calls = counted(where)

        class Ours(NiapyProblem):  # type: ignore[misc]
            def _evaluate(self, x: np.ndarray) -> float:
                return function(x)

        posed = Ours(dimension=len(where.box.low), lower=where.box.low, upper=where.box.high)
        task = Task(problem=posed, max_evals=EVALUATIONS)
        _, best = CuckooSearch(population_size=NESTS, pa=0.25, seed=seed).run(task)
        return float(best), calls[0]

    return run


def problems() -> Iterator[tuple[str, Problem]]:
    for name in ("sphere", "rastrigin"):
        yield f"{name}, shifted", problem(name, "shifted", DIMENSIONS, 0.4, 1)
    if importlib.util.find_spec("pipeline.objective.staging"):
        yield "stage currents", staged_charge()


def staged_charge() -> Problem:
    """Return the currents of eight stages, time and rise of equal weight."""
    from pipeline.cell.records import Battery
    from pipeline.objective.staging import Limits, objective_of
    from pipeline.objective.staging_grid import make_grid
    from pipeline.objective.staging_records import Currents, Weights

    sheet = yaml.safe_load((CONF / "battery/lfp_8ah.yaml").read_text())
    sheet.pop("sources", None)
    grid = make_grid(Battery(**sheet), np.linspace(0.1, 0.9, DIMENSIONS + 1), 25.0, 8.0)
    span, weights = Currents(low=8.0, high=40.0), Weights(time=5.0, rise=5.0)
    objective = objective_of(grid, span, weights, "positive", Limits(3.65, 55.0))
    edge = np.ones(DIMENSIONS)
    return Problem(objective, Box(8.0 * edge, 40.0 * edge), np.full(DIMENSIONS, np.nan))


def main() -> None:
    logging.disable(logging.CRITICAL)
    generations = (EVALUATIONS // NESTS - 1) // 2
    own = {"nests": NESTS, "generations": generations}
    swarm = {"w": 0.73, "c1": 1.5, "c2": 1.5, "velocity_limit": 0.5, "position_limit": "clamp", "rand": "uniform"}
    searches: dict[str, Search | None] = {
        "cuckoo, plain": ours("cuckoo", **own),
        "cuckoo, as programmed": ours("cuckoo", pa=0.75, **own),
        "cuckoo, inertia": ours("cuckoo", inertia=0.9, inertia_end=0.4, **own),
        "cuckoo, integral": ours("cuckoo", ki=0.05, **own),
        "cuckoo, plain, 30 runs at once": many(30, **own),
        "cuckoo, integral, 30 runs at once": many(30, ki=0.05, **own),
        "swarm": ours("swarm", particles=NESTS, iterations=EVALUATIONS // NESTS - 1, **swarm),
        "scipy, differential evolution": ours("differential_evolution", population=40, generations=149),
        "pymoo, genetic": ours("genetic", population=40, generations=149),
        "pymoo, swarm": ours("particle_swarm", population=40, generations=149),
        "mealpy, OriginalCSA": mealpy_search(),
        "NiaPy, CuckooSearch": niapy_search(),
    }
    for name, where in problems():
        times: dict[str, list[float]] = {}
        found: dict[str, list[tuple[float, int]]] = {}
        for seed in range(-1, ROUNDS):
            for search, run in searches.items():
                if run is None:
                    continue
                begin = time.process_time()
                result = run(where, seed % 1000)
                if seed >= 0:
                    times.setdefault(search, []).append(time.process_time() - begin)
                    found.setdefault(search, []).append(result)
        print(f"\n{name}, {DIMENSIONS} dimensions, {EVALUATIONS} evaluations, {ROUNDS} rounds")
        print(f"{'search':34s} {'ms a run':>9s} {'us/evaluation':>14s} {'over plain':>11s} {'median best':>12s}")
        each = {
            search: statistics.median(times[search]) / statistics.median(count for _, count in found[search])
            for search in times
        }
        for search in searches:
            if search not in times:
                print(f"{search:34s} not installed")
                continue
            best = statistics.median(value for value, _ in found[search])
            ratio = each[search] / each["cuckoo, plain"]
            row = f"{1e3 * each[search] * EVALUATIONS:9.2f} {1e6 * each[search]:14.2f} {ratio:10.1f}x {best:12.6g}"
            print(f"{search:34s} {row}")


if __name__ == "__main__":
    main()
