"""Speed and result of the genetic algorithm that selects a network's centres, against DEAP and pymoo.

Run as `PYTHONPATH=src python -m benchmarks.genetic`. All minimise the same error with population 20 and 5780
evaluations; ours and pymoo see a population at once, DEAP a string at a time. Medians of interleaved rounds,
compilation outside. The peers are the extra `bench`; without them their rows say so.
"""

from __future__ import annotations

import importlib.util
import random
import statistics
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import yaml

from pipeline.config.sources import split
from pipeline.experiments.network.records import NetworkStudy
from pipeline.experiments.network.sources import every_surface
from pipeline.grnn.error import Form
from pipeline.grnn.selection import genetic
from pipeline.grnn.selection.problem import Problem, problem_of
from pipeline.search.streams import generators

CONF = Path(__file__).parents[1] / "conf"
ROUNDS, REPLICATES = 15, 200
WIDTHS = (0.1, 10.0)


def problem() -> Problem:
    values, _ = split(yaml.safe_load((CONF / "study" / "nicd_grnn.yaml").read_text())["network"])
    study = NetworkStudy(**values)
    data = every_surface(study.data)[study.data.surface]
    form = Form(study.form.kernel, WIDTHS, study.form.extension)
    return problem_of(data, form, study.form.centres, study.selection.genetic, study.selection.generations)


def ours(task: Problem, seed: int) -> float:
    return float(genetic.select(task, generators(seed, 0, 1)).error[0])


def with_deap(task: Problem, seed: int) -> float:
    from deap import base, creator, tools

    if not hasattr(creator, "Least"):
        creator.create("Least", base.Fitness, weights=(-1.0,))
        creator.create("String", list, fitness=creator.Least)
    random.seed(seed)
    settings, letters = task.genetic, len(task.data.rate)

    def evaluated(strings: list) -> list:
        for one in strings:
            one.fitness.values = (float(task.errors(np.array([one]))[0]),)
        return strings

    drawn = [[random.randrange(letters) for _ in range(task.centres)] for _ in range(settings.population)]
    population = evaluated([creator.String(one) for one in drawn])
    for _ in range(task.generations):
        best = tools.selBest(population, settings.elite)
        parents = tools.selTournament(population, settings.population - settings.elite, tournsize=2)
        children = [creator.String(one) for one in parents]
        for one, other in zip(children[::2], children[1::2], strict=True):
            if random.random() < settings.crossover:
                tools.cxUniform(one, other, 0.5)
        for one in children:
            tools.mutUniformInt(one, 0, letters - 1, settings.mutation)
        population = best + evaluated(children)
    return min(one.fitness.values[0] for one in population)


def with_pymoo(task: Problem, seed: int) -> float:
    from pymoo.algorithms.soo.nonconvex.ga import GA
    from pymoo.core.mutation import Mutation
    from pymoo.core.problem import Problem as Vector
    from pymoo.operators.crossover.ux import UniformCrossover
    from pymoo.operators.sampling.rnd import IntegerRandomSampling
    from pymoo.optimize import minimize

    settings, letters = task.genetic, len(task.data.rate)

    class Network(Vector):
        def __init__(self) -> None:
            super().__init__(n_var=task.centres, n_obj=1, xl=0, xu=letters - 1, vtype=int)

        def _evaluate(self, strings, out, *arguments, **options) -> None:
            out["F"] = task.errors(strings.astype(np.int64))

    class Anew(Mutation):
        def _do(self, problem, strings, *arguments, random_state=None, **options):
            changed = random_state.random(strings.shape) < settings.mutation
            return np.where(changed, random_state.integers(letters, size=strings.shape), strings)

    algorithm = GA(
        pop_size=settings.population,
        n_offsprings=settings.population - settings.elite,
        sampling=IntegerRandomSampling(),
        crossover=UniformCrossover(prob=settings.crossover),
        mutation=Anew(),
        eliminate_duplicates=False,
    )
    return float(minimize(Network(), algorithm, ("n_eval", task.evaluations), seed=seed).F[0])


PEERS: dict[str, tuple[str | None, Callable[[Problem, int], float]]] = {
    "this project": (None, ours),
    "DEAP": ("deap", with_deap),
    "pymoo": ("pymoo", with_pymoo),
}


def main() -> None:
    task = problem()
    installed = {
        name: run for name, (package, run) in PEERS.items() if not package or importlib.util.find_spec(package)
    }
    for run in installed.values():
        run(task, 0)
    walls: dict[str, list[float]] = {name: [] for name in installed}
    errors: dict[str, list[float]] = {name: [] for name in installed}
    for seed in range(1, ROUNDS + 1):
        for name, run in installed.items():
            begin = time.perf_counter()
            errors[name].append(run(task, seed))
            walls[name].append(time.perf_counter() - begin)
    own = statistics.median(walls["this project"])
    print(f"GA of {task.generations} generations, {task.evaluations} networks of {len(task.data.rate)} points")
    print(f"{'':14s} {'median s':>9s} {'ratio':>7s} {'median MSE':>11s} {'least MSE':>10s}")
    for name in PEERS:
        if name not in installed:
            print(f"{name:14s} not installed (pip install 'charge-pipeline[bench]')")
            continue
        wall, error = statistics.median(walls[name]), errors[name]
        print(f"{name:14s} {wall:9.4f} {wall / own:7.1f} {statistics.median(error):11.5f} {min(error):10.5f}")
    begin = time.perf_counter()
    genetic.select(task, generators(1, 0, REPLICATES))
    print(f"{REPLICATES} replicates together: {(time.perf_counter() - begin) / REPLICATES:.4f} s each")


if __name__ == "__main__":
    main()
