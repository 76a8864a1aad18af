"""Searches on test functions: what is run, and the numbers that come of it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pydantic import Field

from pipeline.experiments.functions.numbers import VOCABULARY, fields
from pipeline.kernel.experiment import Effort, Experiment, Node, Step
from pipeline.kernel.footprint import Footprint
from pipeline.kernel.tables import CHAOTIC, ELSEWHERE, Column, Table, TableFile, numbers
from pipeline.record import Record
from pipeline.search import registry
from pipeline.search.box import evaluations, kept_b
from pipeline.search.function_records import FunctionStudy

_WHERE = (
    Column("function", "", "name of the test function", "text"),
    Column("placement", "", "centred, shifted or rotated", "text"),
    Column("search", "", "name of the search", "text"),
)

FUNCTION_RUNS = Table(
    "function_runs",
    "What each run of a search on a test function came to",
    (
        *_WHERE,
        Column("replicate", "1", "number of the run, from 0", "integer"),
        Column("value", "1", "best value at the end; the minimum is 0"),
        Column("value_at_budget", "1", "best value at as many evaluations as the shortest search spends"),
        Column("generations", "1", "generations until the threshold was reached; empty: never", optional=True),
        Column("evaluations", "1", "the same in evaluations", optional=True),
        Column("spent", "1", "evaluations in all"),
    ),
)

FUNCTION_CURVES = Table(
    "function_curves",
    "How the runs of a search converge: their best values so far, at generations evenly spaced by their logarithm",
    (
        *_WHERE,
        Column("generation", "1", "number of the generation; 0 is the start", "integer"),
        Column("evaluations", "1", "evaluations so far, mean over the runs"),
        Column("low", "1", "first quartile of the runs"),
        Column("median", "1", "their median"),
        Column("high", "1", "third quartile"),
        Column("mean", "1", "their mean"),
    ),
)

FUNCTION_STATISTICS = Table(
    "function_statistics",
    "What a search came to on a test function, over its runs",
    (
        *_WHERE,
        Column("replicates", "1", "runs", "integer"),
        Column("mean", "1", "mean of the best values at the end"),
        Column("deviation", "1", "their standard deviation"),
        Column("median", "1", "their median"),
        Column("best", "1", "the best of them"),
        Column("mean_at_budget", "1", "mean of the best values at the shortest search's budget"),
        Column("success_share", "1", "share of the runs that reach the threshold"),
        Column("generations", "1", "mean generations until they do; empty: none does", optional=True),
        Column("generations_deviation", "1", "their standard deviation", optional=True),
        Column("evaluations", "1", "mean evaluations until they do", optional=True),
        Column("spent", "1", "evaluations in all, mean over the runs"),
    ),
)

FUNCTION_TESTS = Table(
    "function_tests",
    "Each variant against plain search, in pairs from the same start",
    (
        *_WHERE,
        Column("measure", "", "value: at the end; generations: to the threshold", "text"),
        Column("p", "1", "Wilcoxon's signed-rank test: chance of such a difference if there is none"),
        Column("p_holm", "1", "the same, corrected for the number of functions"),
        Column("larger", "1", "Vargha and Delaney's A: chance that the variant's is larger, that is worse"),
        Column("better", "", "whether the variant is better, at 5 % after the correction", "truth"),
        Column("worse", "", "whether it is worse", "truth"),
    ),
)

FUNCTION_RANKS = Table(
    "function_ranks",
    "Mean ranks over the functions, and Friedman's test of them",
    (
        Column("placement", "", "centred, shifted or rotated", "text"),
        Column("measure", "", "mean: at the end; mean_at_budget: at the shortest search's budget", "text"),
        Column("search", "", "name of the search", "text"),
        Column("mean_rank", "1", "mean rank of its mean value; 1 is best"),
        Column("p", "1", "chance of ranks as far apart as these if the searches did not differ"),
    ),
)

# How far below 1e-16 a search gets is rounding.
_HISTORY = ("low", "median", "high", "mean")

FUNCTION_RUN = {
    "runs": TableFile("runs.parquet", FUNCTION_RUNS, elsewhere={"value*": CHAOTIC}),
    "curves": TableFile("curves.parquet", FUNCTION_CURVES, elsewhere=dict.fromkeys(_HISTORY, CHAOTIC)),
}
"""What the step `function_runs` writes, of one function."""

FUNCTIONS = {
    **FUNCTION_RUN,
    "statistics": TableFile("statistics.parquet", FUNCTION_STATISTICS),
    "tests": TableFile("tests.parquet", FUNCTION_TESTS),
    "ranks": TableFile("ranks.parquet", FUNCTION_RANKS),
    **numbers({"*_generations*": ELSEWHERE, "*_mean": CHAOTIC, "*_deviation": CHAOTIC}),
}
"""What the step `functions` writes, of all of them."""


class FunctionsPart(Record):
    """Which searches run on which functions."""

    functions: FunctionStudy | None = Field(default=None, description="searches on test functions")


def _run_settings(config: Any, function: str) -> dict[str, Any]:
    # What a function gives does not depend on which others there are.
    own = config.functions.model_copy(update={"functions": (function,)})
    return {"functions": own, "function": function, "seed": config.seed}


def _effort(config: Any, function: str) -> Effort:
    chosen = config.functions
    groups = [one for one in (chosen.variants, chosen.baselines) if one is not None]
    listed = [
        {"replicates": group.replicates, **group.shared, **own} for group in groups for own in group.searches.values()
    ]
    size, places = chosen.dimensions, len(chosen.placements)
    memory_b = places * (sum(kept_b(one, size) for one in listed) + 64.0 * size**2)
    time_s = places * (2e-8 * size + 1e-9 * size**2) * sum(map(evaluations, listed))
    counts = ("shared", "searches", "replicates")
    paths = [f"functions.{group}.{name}" for group in ("variants", "baselines") for name in counts]
    return Effort(memory_b, time_s, ("functions.dimensions", *paths))


RUN_STEP = Step(
    "function_runs",
    rule="run_on_function",
    message="Test function, every search in every placement: {chunk}",
    settings=_run_settings,
    effort=Footprint(_effort, node_s=5.0),
    reads=("functions", "seed"),
    tables=FUNCTION_RUN,
    target="functions",
    chunk=(2, 2),
    shown=False,
)
COMPARE_STEP = Step(
    "functions",
    rule="compare_on_functions",
    message="Test functions: statistics and tests: {chunk}",
    effort=Footprint(node_s=8.0),
    settings=lambda config: {"functions": config.functions, "seed": config.seed},
    reads=("functions", "seed"),
    takes=("function_runs",),
    tables=FUNCTIONS,
    quantities=VOCABULARY,
    target="functions",
    chunk=(1, 8),
    needed_by_figures=True,
)


def nodes(study: Any) -> Iterator[Node]:
    """Yield a node for each function, with the runs of every search on it, and one that compares the searches."""
    if study.functions is None:
        return
    modules = tuple(sorted(registry.module_name(kind) for kind in study.functions.kinds()))
    names = {name: f"function_runs/{name}" for name in study.functions.functions}
    for name, node in names.items():
        yield Node(RUN_STEP, node, name, {"function": name}, modules=modules)
    edges = {node: node for node in names.values()}
    yield Node(COMPARE_STEP, "functions", "functions", inputs=edges, shown=COMPARE_STEP.places("functions"))


EXPERIMENT = Experiment(
    title="searches on test functions",
    steps=(RUN_STEP, COMPARE_STEP),
    nodes=nodes,
    part=FunctionsPart,
    parameters=("functions",),
    inputs=lambda study: () if study.functions is None else ("functions",),
    fields=lambda study: {} if study.functions is None else {"functions": fields(study.functions)},
)
