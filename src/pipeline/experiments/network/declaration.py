"""The network that commands a charger: its data, the selections of its centres, its size, its kernel."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any

from pipeline.errors import UserError
from pipeline.experiments.network.numbers import KERNELS, NETWORK, SIZES, SURFACE, fields
from pipeline.experiments.network.records import GRADIENT_SECONDS, LONG, NetworkPart
from pipeline.files import profiles
from pipeline.kernel import digest
from pipeline.kernel.experiment import Effort, Experiment, Node, Step
from pipeline.kernel.footprint import Footprint
from pipeline.kernel.tables import CHAOTIC, NUMBERS, Column, Table, TableFile
from pipeline.published.ensemble import ANSWERS, NAME, asked

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

SURFACE_TABLE = Table(
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

SIZES_TABLE = Table(
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

KERNELS_TABLE = Table(
    "network_kernels",
    "Error of the genetic algorithm's networks under every kernel on every surface, a row per replicate",
    (_SURFACE, Column("kernel", "", "name of the kernel", "text"), *_WIDTHS, _REPLICATE, _MSE),
)

MADE = {
    "surface": TableFile("surface.parquet", SURFACE_TABLE),
    "printed": TableFile("printed.parquet", SURFACE_AGREEMENT),
    **NUMBERS,
}
"""What the step `surface` writes."""

SELECTED = {
    "networks": TableFile("networks.parquet", NETWORKS),
    "selections": TableFile("selections.parquet", SELECTIONS),
    "trials": TableFile("trials.parquet", TRIALS, elsewhere={"mse": CHAOTIC}),
    "course": TableFile("history.parquet", HISTORY, elsewhere={"*_mse": CHAOTIC}),
    "response": TableFile("response.parquet", RESPONSE),
    "learning": TableFile("learning.parquet", LEARNING),
    **NUMBERS,
}
"""What the step `network` writes."""

SIZED = {"sizes": TableFile("sizes.parquet", SIZES_TABLE), **NUMBERS}
"""What the step `network_size` writes."""

VARIED = {"kernels": TableFile("kernels.parquet", KERNELS_TABLE), **NUMBERS}
"""What the step `network_kernels` writes."""


_GRID = ("network.data.grid.temperatures", "network.data.grid.gradients")
REFERENCE = "conf/published/reference/nicd_*.csv"


def _data(config: Any) -> dict[str, Any]:
    """Return where the data come from; a table of a person's own stands in the key with its content."""
    data = config.network.data
    if data.table is None:
        return {"data": data}
    return {"data": data, "table_sha256": digest.of_file(Path(data.table))}


def _selecting(config: Any) -> dict[str, Any]:
    chosen = config.network
    return {"form": chosen.form, "selection": chosen.selection, "anfis": chosen.anfis, "seed": config.seed}


def _sizing(config: Any) -> dict[str, Any]:
    chosen = config.network
    return {"form": chosen.form, "genetic": chosen.selection.genetic, "size": chosen.size, "seed": config.seed}


def _varying(config: Any) -> dict[str, Any]:
    chosen = config.network
    return {"form": chosen.form, "genetic": chosen.selection.genetic, "kernels": chosen.kernels, "seed": config.seed}


def _points(data: Any) -> float:
    if data.table is None:
        return float(data.grid.temperatures * data.grid.gradients)
    return float(_rows(data.table, GRADIENT_SECONDS[data.gradient_unit], digest.of_file(Path(data.table))))


@lru_cache(maxsize=8)
def _rows(table: str, gradient_seconds: float, content: str) -> int:
    return len(profiles.read(Path(table), gradient_seconds).rate_c)


def _making_effort(config: Any) -> Effort:
    points = _points(config.network.data)
    return Effort(400.0 * points, 1e-6 * points, (*_GRID, "network.data.table"))


def _selection_effort(config: Any, form: Any, selections: float, strings: float, paths: tuple[str, ...]) -> Effort:
    """Return the effort of some selections of centres, each of a number of strings whose errors are computed."""
    points = _points(config.network.data)
    memory_b = 8.0 * points * (form.centres + 8.0) * 4.0 + 100.0 * selections
    counts = (*(f"network.{path}" for path in paths), "network.selection.genetic.population", "network.form.centres")
    return Effort(memory_b, 3e-9 * points * form.centres * selections * strings, (*counts, *_GRID))


def _selecting_effort(config: Any) -> Effort:
    chosen, anfis = config.network.selection, config.network.anfis
    form, population = config.network.form, chosen.genetic.population
    pairs, methods = len(form.widths.pairs()), len(chosen.methods)
    trials = pairs * form.widths.trial_replicates * form.widths.trial_generations
    whole = chosen.replicates * (form.widths.finalists * chosen.generations + chosen.long_generations)
    found = _selection_effort(config, form, methods, population * (trials + whole), (
        *("selection.replicates", "selection.generations", "selection.long_generations"),
        *(f"form.widths.{name}" for name in type(form.widths).model_fields),
        *(f"anfis.{name}" for name in type(anfis).model_fields),
    ))  # fmt: skip
    planes = 3.0 * anfis.temperature_sets * anfis.gradient_sets
    learning_b = 8.0 * _points(config.network.data) * planes * 4.0
    course_b = 40.0 * chosen.replicates * chosen.long_generations
    memory_b = max(found.memory_b, learning_b) + course_b
    learning_s = 1e-9 * anfis.epochs * _points(config.network.data) * planes**2
    return found._replace(memory_b=memory_b, time_s=found.time_s + learning_s)


def _sizing_effort(config: Any) -> Effort:
    chosen = config.network.size
    form = config.network.form.model_copy(update={"centres": chosen.largest})
    sizes = chosen.largest - chosen.smallest + 1
    strings = config.network.selection.genetic.population * chosen.generations
    paths = tuple(f"size.{name}" for name in ("generations", "replicates", "largest"))
    return _selection_effort(config, form, sizes * chosen.replicates, 0.5 * strings, paths)


def _varying_effort(config: Any) -> Effort:
    chosen, form = config.network.kernels, config.network.form
    strings = config.network.selection.genetic.population * chosen.generations * len(form.widths.pairs())
    return _selection_effort(
        config, form, 15.0 * chosen.replicates, strings, ("kernels.generations", "kernels.replicates")
    )


MAKE = Step(
    "surface",
    rule="make_surface",
    message="Surface: the data of the network, and what could stand in for them: {chunk}",
    settings=_data,
    effort=_making_effort,
    reads=("network.data",),
    tables=MADE,
    quantities=SURFACE,
    target="network",
    chunk=(1, 8),
    files=(REFERENCE,),
)
SELECT = Step(
    "network",
    rule="select_centres",
    message="Network: centres selected by every method: {chunk}",
    settings=_selecting,
    effort=Footprint(_selecting_effort, node_s=8.0),
    reads=("network.form", "network.selection", "network.anfis", "seed"),
    takes=("surface",),
    tables=SELECTED,
    quantities=NETWORK,
    target="network",
    chunk=(1, 4),
    files=(REFERENCE,),
    finds=True,
)
SIZE = Step(
    "network_size",
    rule="size_network",
    priority=10,
    message="Network size: error against the number of centres: {chunk}",
    settings=_sizing,
    effort=Footprint(_sizing_effort, node_s=35.0),
    reads=("network.form", "network.selection.genetic", "network.size", "seed"),
    takes=("surface",),
    tables=SIZED,
    quantities=SIZES,
    target="network",
    chunk=(1, 4),
    files=(REFERENCE,),
)
VARY = Step(
    "network_kernels",
    rule="vary_kernel",
    priority=5,
    message="Network kernels: error under every kernel on every surface: {chunk}",
    settings=_varying,
    effort=Footprint(_varying_effort, node_s=15.0),
    reads=("network.form", "network.selection.genetic", "network.kernels", "seed"),
    takes=("surface",),
    tables=VARIED,
    quantities=KERNELS,
    target="network",
    chunk=(1, 4),
)


def _resampling(config: Any) -> dict[str, Any]:
    return {
        "experiments": config.ensemble.points,
        "seed": config.seed,
        "asked": asked(config, ("network", "network_size"), "search"),
    }


RESAMPLE = Step(
    "network_ensemble",
    rule="resample_selections",
    message="Network: resampled runs of the selections: {chunk}",
    effort=Footprint(node_s=1.0),
    settings=_resampling,
    reads=("ensemble", "seed", "published", "answer"),
    takes=("network", "network_size"),
    tables=ANSWERS,
    shown=False,
)


def nodes(study: Any) -> Iterator[Node]:
    """Yield the data of a study's network, its selection, and what is tried with its size and its kernel."""
    if study.network is None:
        return
    yield Node(MAKE, "surface", "surface", shown=MAKE.places("surface"))
    made = ((SELECT, True), (SIZE, study.network.size is not None), (VARY, study.network.kernels is not None))
    for step in (step for step, wanted in made if wanted):
        inputs = {"surface": "surface"}
        yield Node(step, step.name, study.study.name, inputs=inputs, shown=step.places(step.name))
    if study.ensemble.points and asked(study, ("network", "network_size"), "search"):
        inputs = {step.name: step.name for step, wanted in made if wanted and step is not VARY}
        shown = {"ensemble.parquet": "published/ensemble_of_selections.parquet"}
        yield Node(RESAMPLE, f"{NAME}/network", study.study.name, inputs=inputs, shown=shown)


def check(study: Any) -> None:
    """Refuse a user's table that cannot be learnt.

    Raises
    ------
    UserError : with the key path and the path of the file.
    """
    if study.network is None:
        return
    data = study.network.data
    if data.table is not None:
        try:
            profiles.read(Path(data.table), GRADIENT_SECONDS[data.gradient_unit])
        except UserError as error:
            raise UserError(f"network.data.table: {error}") from None
    points = int(_points(data))
    size = study.network.size
    for path, centres in (("form.centres", study.network.form.centres), ("size.largest", size.largest if size else 1)):
        if centres > points:
            raise UserError(f"network.{path}: {centres} centres of {points} points; allowed is as many as there are")


def _found(study: Any) -> dict[str, tuple[str, ...]]:
    return {} if study.network is None else {SELECT.name: (*study.network.selection.methods, LONG)}


STEPS = (MAKE, SELECT, SIZE, VARY)
"""Those that make what statements read."""
EXPERIMENT = Experiment(
    title="the network that commands a charger",
    steps=(*STEPS, RESAMPLE),
    nodes=nodes,
    part=NetworkPart,
    parameters=("network",),
    checks=(check,),
    finds=_found,
    inputs=lambda study: () if study.network is None else [step.name for step in STEPS],
    fields=lambda study: fields(),
)
