"""What the networks come to, as named numbers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from pipeline.experiments.network.comparison import Comparison, Result, Size, Variety, after, units
from pipeline.experiments.network.numbers import KERNELS, NETWORK, SIZES, SURFACE
from pipeline.experiments.network.records import FormSettings, SelectionSettings
from pipeline.experiments.network.sources import Agreement
from pipeline.grnn.anfis import Learning, nodes
from pipeline.grnn.error import candidates
from pipeline.grnn.network import EDGE
from pipeline.grnn.records import Data, Method
from pipeline.grnn.selection.least_squares import least_squares
from pipeline.grnn.selection.methods import Task
from pipeline.quantity import Quantity
from pipeline.search.comparison import effect

Array = NDArray[np.float64]

# Errors below this are rounding: the network meets every point.
_ROUNDING = 1e-12


def of_surfaces(learnt: Data, surfaces: Mapping[str, Data], found: list[Agreement], name: str) -> list[Quantity]:
    """Return the numbers of the data and of the surfaces' agreement with the printed rows.

    Arguments
    ---------
    learnt : the data the network learns.
    surfaces : all surfaces.
    found : their agreement.
    name : of the surface that is learnt; another name where a table is.
    """
    rows = {surface: [one for one in found if one.surface == surface] for surface in surfaces}
    consistent = {surface: all(one.consistent for one in ones) for surface, ones in rows.items()}
    numbers = {
        "points": len(learnt.rate),
        "temperatures": len(np.unique(learnt.inputs[:, 0])),
        "gradients": len(np.unique(learnt.inputs[:, 1])),
        "gradient_seconds": learnt.gradient_seconds,
        "legible_rows": len({one.printed.row for one in found}),
        "consistent_surfaces": sum(consistent.values()),
        "learnt_consistent": consistent.get(name, np.nan),
    }
    quantities = [SURFACE.quantity(key, value) for key, value in numbers.items()]
    for surface, ones in rows.items():
        of_surface: dict[str, float] = {
            "{surface}_variance": float(np.var(surfaces[surface].rate)),
            "{surface}_rows_consistent": sum(one.consistent for one in ones),
            "{surface}_largest_deviation": max(abs(one.computed_c - one.printed.rate_c) for one in ones),
            "{surface}_consistent": consistent[surface],
        }
        quantities += [SURFACE.quantity(key, value, surface=surface) for key, value in of_surface.items()]
    return quantities


def of_networks(
    form: FormSettings,
    settings: SelectionSettings,
    data: Data,
    found: Comparison,
    learning: Learning,
    printed: Iterable[float],
    printed_mse: float,
    seed: int,
) -> list[Quantity]:
    """Return the numbers of the selections and of the neuro-fuzzy peer.

    Arguments
    ---------
    printed : temperatures that can be read in the paper's Table II [degC].
    printed_mse : the error the paper prints for the network [C-rate^2].
    seed : of the bootstrap's resamples.
    """
    sets = (len(learning.system.bells[0]), len(learning.system.bells[1]))
    points = len(data.rate)
    numbers = {
        "points": points,
        "centres": form.centres,
        "units": units(form.centres),
        "units_of_all_data": units(points),
        "nodes_of_anfis": nodes(sets),
        "rules_of_anfis": sets[0] * sets[1],
        "population": settings.genetic.population,
        "crossover": settings.genetic.crossover,
        "mutation": settings.genetic.mutation,
        "elite": settings.genetic.elite,
        "generations": settings.generations,
        "long_generations": settings.long_generations,
    }
    quantities = [NETWORK.quantity(key, value) for key, value in numbers.items()]
    for method, result in found.results.items():
        quantities += _of_method(method, result, printed_mse)
    quantities += _of_course(settings, found)
    used = found.results["genetic"].form
    task = Task(data, used.kernel, used.extension, form.centres, settings.genetic)
    if "least_squares" in found.results:
        left = min(float(least_squares(task.problem(pair, 1)).error[-1]) for pair in form.widths.pairs())
        quantities.append(NETWORK.quantity("least_squares_linear_mse", left))
    theirs = set(printed)
    ours = set(data.inputs[found.results["genetic"].selected.best(), 0].tolist())
    quantities += [
        NETWORK.quantity("anfis_mse", float(np.min(learning.error))),
        NETWORK.quantity("uncovered_share", uncovered(data, found.results["genetic"])),
        NETWORK.quantity("printed_temperatures", len(theirs)),
        NETWORK.quantity("printed_temperatures_selected", len(theirs & ours)),
    ]
    return quantities + _effects(found, seed)


def uncovered(data: Data, result: Result) -> float:
    """Return the share of the data that lies outside every Wendland support of the best network's centres."""
    distance = candidates(data, result.form).distance[result.selected.best()]
    return float(np.mean(np.min(distance, axis=0) >= EDGE))


def of_sizes(found: list[Size], printed_mse: float) -> list[Quantity]:
    """Return the numbers of the error against the number of centres."""
    quantities = []
    for one in found:
        numbers = {
            "size_{size}_units": units(one.centres),
            "size_{size}_mse": float(np.min(one.error)),
            "size_{size}_mse_median": float(np.median(one.error)),
            "size_{size}_forward_mse": one.forward_error,
        }
        quantities += [SIZES.quantity(key, value, size=one.centres) for key, value in numbers.items()]
    medians = np.array([np.median(one.error) for one in found])
    reached = [one.centres for one in found if np.median(one.error) <= printed_mse]
    smallest = float(min(reached)) if reached else np.nan
    best = found[int(np.argmin(np.where(medians > _ROUNDING, medians, 0.0)))]
    forward = np.array([one.forward_error for one in found]) <= np.maximum(medians, _ROUNDING)
    # From the last size at which it is not, one further on.
    from_here = len(found) - int(np.argmin(np.append(forward[::-1], False)))
    sooner = float(found[from_here].centres) if from_here < len(found) else np.nan
    return [
        *quantities,
        SIZES.quantity("smallest_size_at_printed", smallest),
        SIZES.quantity("best_size", best.centres),
        SIZES.quantity("forward_as_good_from", sooner),
    ]


def of_varieties(found: Iterable[Variety]) -> list[Quantity]:
    """Return the numbers of every kernel on every surface."""
    quantities = []
    for one in found:
        numbers = {
            "{surface}_{kernel}_mse": float(np.min(one.error)),
            "{surface}_{kernel}_mse_median": float(np.median(one.error)),
        }
        named = {"surface": one.surface, "kernel": one.kernel}
        quantities += [KERNELS.quantity(key, value, **named) for key, value in numbers.items()]
    return quantities


def _of_method(method: Method, result: Result, printed_mse: float) -> list[Quantity]:
    error = result.selected.error
    numbers = {
        "{method}_mse": float(np.min(error)),
        "{method}_mse_median": float(np.median(error)),
        "{method}_mse_mean": float(np.mean(error)),
        "{method}_mse_worst": float(np.max(error)),
        "{method}_share_at_printed": float(np.mean(error <= printed_mse)),
        "{method}_evaluations": result.selected.evaluations,
        "{method}_replicates": len(error),
        "{method}_width_temperature": result.form.widths[0],
        "{method}_width_gradient": result.form.widths[1],
    }
    words = method.replace("_", " ")
    return [NETWORK.quantity(key, value, method=method, words=words) for key, value in numbers.items()]


def _of_course(settings: SelectionSettings, found: Comparison) -> list[Quantity]:
    used, last = settings.generations, settings.long_generations
    late = after(found.course, last)
    numbers = {
        "genetic_population_mean": _mean_of_best(found, used),
        "genetic_mse_long": float(np.min(late.error)),
        "genetic_mse_median_long": float(np.median(late.error)),
        "genetic_population_mean_long": _mean_of_best(found, last),
    }
    return [NETWORK.quantity(key, value) for key, value in numbers.items()]


def _mean_of_best(found: Comparison, generation: int) -> float:
    best = int(np.argmin(found.course.history.value[:, generation]))
    return float(found.course.mean[best, generation])


def _effects(found: Comparison, seed: int) -> list[Quantity]:
    """Return the chance that the genetic algorithm's error is the larger one, against each other method."""
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(1,)))
    own, quantities = found.results["genetic"].selected.error, []
    for method, result in found.results.items():
        if method == "genetic":
            continue
        larger = effect(own, result.selected.error, rng)
        numbers = {
            "genetic_over_{rival}": larger.value,
            "genetic_over_{rival}_low": larger.low,
            "genetic_over_{rival}_high": larger.high,
        }
        named = {"rival": method, "words": method.replace("_", " ")}
        quantities += [NETWORK.quantity(key, value, **named) for key, value in numbers.items()]
    return quantities
