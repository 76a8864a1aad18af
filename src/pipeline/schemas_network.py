"""Declared tables of the network that commands a charger: its data, its centres, its errors."""

from __future__ import annotations

from pipeline.schemas import QUANTITIES
from pipeline.tables import Column, Table

_TEMPERATURE = Column("temperature_c", "degC", "temperature of the battery")
_GRADIENT = Column("gradient", "see gradient_seconds", "its rate of change, in the data's unit")
_RATE = Column("rate_c", "C-rate", "charging rate")
_SURFACE = Column("surface", "", "name of the surface", "text")
_METHOD = Column("method", "", "how the centres were selected", "text")
_REPLICATE = Column("replicate", "1", "number of the replicate, from 0", "integer")
_MSE = Column("mse", "C-rate2", "mean square error over all points of the data")
_WIDTHS = (
    Column("width_temperature", "1", "width of the kernel over the scaled temperature"),
    Column("width_gradient", "1", "width of the kernel over the scaled gradient"),
)

SURFACE = Table(
    "surface",
    "Charging rate over temperature and gradient, a row per point; `learnt` are the data the network learns",
    (_SURFACE, _TEMPERATURE, _GRADIENT, _RATE, Column("gradient_seconds", "s", "seconds in the gradient's unit")),
)
SURFACE_AGREEMENT = Table(
    "surface_agreement",
    "Surfaces against the legible rows of the paper's Table II",
    (
        _SURFACE,
        Column("row", "1", "number of the row in Table II", "integer"),
        Column("certainty", "", "how well the scan can be read", "text"),
        _TEMPERATURE,
        _GRADIENT,
        Column("printed_rate_c", "C-rate", "charging rate as printed"),
        Column("computed_rate_c", "C-rate", "that of the surface"),
        Column("consistent", "", "whether the two agree as far as the printed one is rounded", "truth"),
    ),
)
NETWORKS = Table(
    "networks",
    "The best network of each method, a row per centre",
    (
        Column("network", "", "name of the network", "text"),
        Column("centre", "1", "number of the centre, from 1", "integer"),
        Column("row", "1", "its row in the data, from 1", "integer"),
        _TEMPERATURE,
        _GRADIENT,
        _RATE,
        Column("kernel", "", "name of the kernel", "text"),
        *_WIDTHS,
        Column("scale_temperature", "degC", "what the temperature is divided by"),
        Column("scale_gradient", "see gradient_seconds", "what the gradient is divided by"),
        Column("extension", "1", "radius of an extended support over the distance of the nearest centre"),
        Column("lowest_temperature_c", "degC", "lower end of the data"),
        Column("highest_temperature_c", "degC", "upper end of the data"),
        Column("lowest_gradient", "see gradient_seconds", "lower end of the data"),
        Column("highest_gradient", "see gradient_seconds", "upper end of the data"),
        Column("gradient_seconds", "s", "seconds in the gradient's unit: 60 for K/min"),
    ),
)
RESPONSE = Table(
    "network_response",
    "What the network and its neuro-fuzzy peer answer at every point of the data",
    (
        _TEMPERATURE,
        _GRADIENT,
        _RATE,
        Column("network_c", "C-rate", "the network's answer"),
        Column("anfis_c", "C-rate", "the neuro-fuzzy system's answer"),
    ),
)
SELECTIONS = Table(
    "network_selections",
    "Error of every selection of centres, a row per method and replicate",
    (_METHOD, _REPLICATE, _MSE, Column("evaluations", "1", "networks evaluated for it", "integer")),
)
TRIALS = Table(
    "network_trials",
    "The widths that were tried with each method",
    (_METHOD, *_WIDTHS, Column("mse", "C-rate2", "mean square error, mean over the trial's replicates")),
)
HISTORY = Table(
    "network_history",
    "The course of the genetic algorithm, a row per replicate and generation",
    (
        _REPLICATE,
        Column("generation", "1", "number of the generation; 0 is the start", "integer"),
        Column("evaluations", "1", "networks evaluated so far", "integer"),
        Column("best_mse", "C-rate2", "mean square error of the best string"),
        Column("mean_mse", "C-rate2", "mean over the strings of the generation"),
    ),
)
LEARNING = Table(
    "anfis_learning",
    "The neuro-fuzzy system's error over the epochs of its hybrid learning",
    (Column("epoch", "1", "number of the epoch, from 1", "integer"), _MSE),
)
SIZES = Table(
    "network_sizes",
    "Error against the number of centres, a row per number, method and replicate",
    (
        Column("centres", "1", "number of centres", "integer"),
        Column("units", "1", "processing units, two a centre and one", "integer"),
        _METHOD,
        _REPLICATE,
        _MSE,
    ),
)
KERNELS = Table(
    "network_kernels",
    "Error of the genetic algorithm's networks under every kernel on every surface, a row per replicate",
    (_SURFACE, Column("kernel", "", "name of the kernel", "text"), *_WIDTHS, _REPLICATE, _MSE),
)
ARTEFACTS: dict[tuple[str, str], tuple[str, Table]] = {
    ("surface", "surface"): ("surface.parquet", SURFACE),
    ("surface", "printed"): ("printed.parquet", SURFACE_AGREEMENT),
    ("network", "networks"): ("networks.parquet", NETWORKS),
    ("network", "selections"): ("selections.parquet", SELECTIONS),
    ("network", "trials"): ("trials.parquet", TRIALS),
    ("network", "course"): ("history.parquet", HISTORY),
    ("network", "response"): ("response.parquet", RESPONSE),
    ("network", "learning"): ("learning.parquet", LEARNING),
    ("network_size", "sizes"): ("sizes.parquet", SIZES),
    ("network_kernels", "kernels"): ("kernels.parquet", KERNELS),
    **{
        (step, "quantities"): ("quantities.parquet", QUANTITIES)
        for step in ("surface", "network", "network_size", "network_kernels")
    },
}
"""(step, table) -> file in its artefact, and its declaration."""
