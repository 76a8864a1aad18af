"""What the networks come to, as named numbers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from pipeline.grnn.anfis import Learning, nodes
from pipeline.grnn.comparison import Comparison, Result, Size, Variety, after, units
from pipeline.grnn.error import candidates
from pipeline.grnn.network import EDGE
from pipeline.grnn.records import Data, FormSettings, Method, SelectionSettings
from pipeline.grnn.selection.least_squares import least_squares
from pipeline.grnn.selection.methods import Task
from pipeline.grnn.surfaces import Agreement
from pipeline.quantity import Quantity
from pipeline.search.comparison import effect

Array = NDArray[np.float64]

_MSE = "C-rate2"
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
    quantities = [
        Quantity("points", float(len(learnt.rate)), "1", "points of the data"),
        Quantity("temperatures", float(len(np.unique(learnt.inputs[:, 0]))), "1", "different temperatures among them"),
        Quantity("gradients", float(len(np.unique(learnt.inputs[:, 1]))), "1", "different gradients among them"),
        Quantity("gradient_seconds", learnt.gradient_seconds, "s", "seconds in the unit of dT/dt; 60: K/min"),
        Quantity("legible_rows", float(len({one.printed.row for one in found})), "1", "legible rows of Table II"),
        Quantity("consistent_surfaces", float(sum(consistent.values())), "1", "surfaces consistent with all of them"),
        Quantity("learnt_consistent", float(consistent.get(name, np.nan)), "1", "1: the surface that is learnt is"),
    ]
    for surface, ones in rows.items():
        apart = [abs(one.computed_c - one.printed.rate_c) for one in ones]
        agree = float(sum(one.consistent for one in ones))
        quantities += [
            Quantity(f"{surface}_variance", float(np.var(surfaces[surface].rate)), _MSE, f"variance of {surface}"),
            Quantity(f"{surface}_rows_consistent", agree, "1", f"legible rows with which {surface} is consistent"),
            Quantity(f"{surface}_largest_deviation", max(apart), "C-rate", f"largest deviation of {surface} from them"),
            Quantity(f"{surface}_consistent", float(consistent[surface]), "1", f"1: {surface} agrees with all of them"),
        ]
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
    quantities = [
        Quantity("points", float(points), "1", "points of the data"),
        Quantity("centres", float(form.centres), "1", "centres of the network"),
        Quantity("units", float(units(form.centres)), "1", "its processing units, two a centre and one"),
        Quantity("units_of_all_data", float(units(points)), "1", "units of a network with every point as a centre"),
        Quantity("nodes_of_anfis", float(nodes(sets)), "1", "nodes of the neuro-fuzzy system, as MATLAB counts them"),
        Quantity("rules_of_anfis", float(sets[0] * sets[1]), "1", "its rules"),
        Quantity("population", float(settings.genetic.population), "1", "strings of a generation"),
        Quantity("crossover", settings.genetic.crossover, "1", "chance that a child has two parents"),
        Quantity("mutation", settings.genetic.mutation, "1", "chance that a gene is drawn anew"),
        Quantity("elite", float(settings.genetic.elite), "1", "best strings that go on unchanged"),
        Quantity("generations", float(settings.generations), "1", "generations behind the network that is used"),
        Quantity("long_generations", float(settings.long_generations), "1", "generations that are followed in all"),
    ]
    for method, result in found.results.items():
        quantities += _of_method(method, result, printed_mse)
    quantities += _of_course(settings, found)
    used = found.results["genetic"].form
    task = Task(data, used.kernel, used.extension, form.centres, settings.genetic)
    if "least_squares" in found.results:
        left = min(float(least_squares(task.problem(pair, 1)).error[-1]) for pair in form.widths.pairs())
        says = "error of orthogonal least squares' own network, with a constant and linear output weights"
        quantities.append(Quantity("least_squares_linear_mse", left, _MSE, says))
    quantities += [
        Quantity("anfis_mse", float(np.min(learning.error)), _MSE, "error of the neuro-fuzzy system"),
        Quantity("uncovered_share", uncovered(data, found.results["genetic"]), "1", "share of the data no support of "
                 "the network would reach if it did not extend: 0/0 there"),
    ]  # fmt: skip
    theirs = set(printed)
    ours = set(data.inputs[found.results["genetic"].selected.best(), 0].tolist())
    quantities += [
        Quantity("printed_temperatures", float(len(theirs)), "1", "different temperatures legible in Table II"),
        Quantity("printed_temperatures_selected", float(len(theirs & ours)), "1", "those that are centres here too"),
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
        name = f"size_{one.centres}"
        quantities += [
            Quantity(f"{name}_units", float(units(one.centres)), "1", f"units with {one.centres} centres"),
            Quantity(f"{name}_mse", float(np.min(one.error)), _MSE, f"least error with {one.centres} centres"),
            Quantity(f"{name}_mse_median", float(np.median(one.error)), _MSE, "median over the replicates"),
            Quantity(f"{name}_forward_mse", one.forward_error, _MSE, "the same by forward selection"),
        ]
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
        Quantity("smallest_size_at_printed", smallest, "1", "fewest centres whose median error is the printed or less"),
        Quantity("best_size", float(best.centres), "1", "fewest centres of the least median error, rounding left out"),
        Quantity("forward_as_good_from", sooner, "1", "fewest centres from which on forward selection is as good as "
                 "the genetic algorithm's median"),
    ]  # fmt: skip


def of_varieties(found: Iterable[Variety]) -> list[Quantity]:
    """Return the numbers of every kernel on every surface."""
    quantities = []
    for one in found:
        name = f"{one.surface}_{one.kernel}"
        words = f"{one.kernel} kernel on {one.surface}"
        quantities += [
            Quantity(f"{name}_mse", float(np.min(one.error)), _MSE, f"least error, {words}"),
            Quantity(f"{name}_mse_median", float(np.median(one.error)), _MSE, f"median over the replicates, {words}"),
        ]
    return quantities


def _of_method(method: Method, result: Result, printed_mse: float) -> list[Quantity]:
    error = result.selected.error
    words = method.replace("_", " ")
    return [
        Quantity(f"{method}_mse", float(np.min(error)), _MSE, f"error of the best network by {words}"),
        Quantity(f"{method}_mse_median", float(np.median(error)), _MSE, "median over its replicates"),
        Quantity(f"{method}_mse_mean", float(np.mean(error)), _MSE, "mean over its replicates"),
        Quantity(f"{method}_mse_worst", float(np.max(error)), _MSE, "worst of its replicates"),
        Quantity(f"{method}_share_at_printed", float(np.mean(error <= printed_mse)), "1",
                 "share of its replicates at the printed error or below"),
        Quantity(f"{method}_evaluations", float(result.selected.evaluations), "1", "networks it evaluates for each"),
        Quantity(f"{method}_replicates", float(len(error)), "1", "its replicates"),
        Quantity(f"{method}_width_temperature", result.form.widths[0], "1", "width over the scaled temperature"),
        Quantity(f"{method}_width_gradient", result.form.widths[1], "1", "width over the scaled gradient"),
    ]  # fmt: skip


def _of_course(settings: SelectionSettings, found: Comparison) -> list[Quantity]:
    used, last = settings.generations, settings.long_generations
    late = after(found.course, last)
    return [
        Quantity("genetic_population_mean", _mean_of_best(found, used), _MSE,
                 "mean error of the last population behind the network that is used"),
        Quantity("genetic_mse_long", float(np.min(late.error)), _MSE, "error of the best after all generations"),
        Quantity("genetic_mse_median_long", float(np.median(late.error)), _MSE, "median over the replicates then"),
        Quantity("genetic_population_mean_long", _mean_of_best(found, last), _MSE,
                 "mean error of the last population of the best replicate then"),
    ]  # fmt: skip


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
        name = f"genetic_over_{method}"
        larger = effect(own, result.selected.error, rng)
        words = f"chance that the genetic algorithm's error is larger than that by {method.replace('_', ' ')}"
        quantities += [
            Quantity(name, larger.value, "1", f"{words}; 0.5: no difference"),
            Quantity(f"{name}_low", larger.low, "1", "lower end of its 95 % interval"),
            Quantity(f"{name}_high", larger.high, "1", "upper end of its 95 % interval"),
        ]
    return quantities
