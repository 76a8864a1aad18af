"""The numbers that the steps of network find: names, units, meanings."""

from __future__ import annotations

from collections.abc import Iterable
from typing import get_args

from pipeline.experiments.network.records import Surfaces
from pipeline.grnn.records import Kernel, Method
from pipeline.quantity import Vocabulary

_ERROR = "C-rate2"

_MOST_CENTRES = 100
"""More centres than this are no small network."""

SURFACE = Vocabulary(
    {
        "points": ("1", "points of the data"),
        "temperatures": ("1", "different temperatures among them"),
        "gradients": ("1", "different gradients among them"),
        "gradient_seconds": ("s", "seconds in the unit of dT/dt; 60: K/min"),
        "legible_rows": ("1", "legible rows of Table II"),
        "consistent_surfaces": ("1", "surfaces consistent with all of them"),
        "learnt_consistent": ("1", "1: the surface that is learnt is"),
        "{surface}_variance": (_ERROR, "variance of {surface}"),
        "{surface}_rows_consistent": ("1", "legible rows with which {surface} is consistent"),
        "{surface}_largest_deviation": ("C-rate", "largest deviation of {surface} from them"),
        "{surface}_consistent": ("1", "1: {surface} agrees with all of them"),
    }
)

NETWORK = Vocabulary(
    {
        "points": ("1", "points of the data"),
        "centres": ("1", "centres of the network"),
        "units": ("1", "its processing units, two a centre and one"),
        "units_of_all_data": ("1", "units of a network with every point as a centre"),
        "nodes_of_anfis": ("1", "nodes of the neuro-fuzzy system, as MATLAB counts them"),
        "rules_of_anfis": ("1", "its rules"),
        "population": ("1", "strings of a generation"),
        "crossover": ("1", "chance that a child has two parents"),
        "mutation": ("1", "chance that a gene is drawn anew"),
        "elite": ("1", "best strings that go on unchanged"),
        "generations": ("1", "generations behind the network that is used"),
        "long_generations": ("1", "generations that are followed in all"),
        "{method}_mse": (_ERROR, "error of the best network by {words}"),
        "{method}_mse_median": (_ERROR, "median over its replicates"),
        "{method}_mse_mean": (_ERROR, "mean over its replicates"),
        "{method}_mse_worst": (_ERROR, "worst of its replicates"),
        "{method}_share_at_printed": ("1", "share of its replicates at the printed error or below"),
        "{method}_evaluations": ("1", "networks it evaluates for each"),
        "{method}_replicates": ("1", "its replicates"),
        "{method}_width_temperature": ("1", "width over the scaled temperature"),
        "{method}_width_gradient": ("1", "width over the scaled gradient"),
        "genetic_population_mean": (_ERROR, "mean error of the last population behind the network that is used"),
        "genetic_mse_long": (_ERROR, "error of the best after all generations"),
        "genetic_mse_median_long": (_ERROR, "median over the replicates then"),
        "genetic_population_mean_long": (_ERROR, "mean error of the last population of the best replicate then"),
        "least_squares_linear_mse": (
            _ERROR,
            "error of orthogonal least squares' own network, with a constant and linear output weights",
        ),
        "anfis_mse": (_ERROR, "error of the neuro-fuzzy system"),
        "uncovered_share": (
            "1",
            "share of the data no support of the network would reach if it did not extend: 0/0 there",
        ),
        "printed_temperatures": ("1", "different temperatures legible in Table II"),
        "printed_temperatures_selected": ("1", "those that are centres here too"),
        "genetic_over_{rival}": (
            "1",
            "chance that the genetic algorithm's error is larger than that by {words}; 0.5: no difference",
        ),
        "genetic_over_{rival}_low": ("1", "lower end of its 95 % interval"),
        "genetic_over_{rival}_high": ("1", "upper end of its 95 % interval"),
    }
)

SIZES = Vocabulary(
    {
        "size_{size}_units": ("1", "units with {size} centres"),
        "size_{size}_mse": (_ERROR, "least error with {size} centres"),
        "size_{size}_mse_median": (_ERROR, "median over the replicates"),
        "size_{size}_forward_mse": (_ERROR, "the same by forward selection"),
        "smallest_size_at_printed": ("1", "fewest centres whose median error is the printed or less"),
        "best_size": ("1", "fewest centres of the least median error, rounding left out"),
        "forward_as_good_from": (
            "1",
            "fewest centres from which on forward selection is as good as the genetic algorithm's median",
        ),
    }
)

KERNELS = Vocabulary(
    {
        "{surface}_{kernel}_mse": (_ERROR, "least error, {kernel} kernel on {surface}"),
        "{surface}_{kernel}_mse_median": (_ERROR, "median over the replicates, {kernel} kernel on {surface}"),
    }
)


def fields() -> dict[str, dict[str, Iterable[object]]]:
    """Return step -> field -> the values it may take, also methods and sizes that a run leaves out."""
    methods, kernels, surfaces = get_args(Method), get_args(Kernel), tuple(Surfaces.model_fields)
    return {
        "surface": {"surface": surfaces},
        "network": {"method": methods, "rival": [method for method in methods if method != "genetic"]},
        "network_size": {"size": range(1, _MOST_CENTRES + 1)},
        "network_kernels": {"surface": surfaces, "kernel": kernels},
    }
