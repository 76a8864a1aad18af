"""The searches on test functions on the page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from pipeline.experiments.functions.figures._parts import NAMES, PLACES
from pipeline.report.tables import Cell, ReportData, ReportTable, plain

LABELS = ()
_SEARCHES = {
    "cuckoo": "plain", "integral_inertia": "integral and inertia", "cuckoo_as_programmed": "plain, as programmed",
}  # fmt: skip
_SUMMARY = {
    "zeros": "mean exactly 0",
    "perfect": "mean below 10⁻¹⁶",
    "always_reached": "always succeeds",
    "mean_success_share": "share that succeeds",
    "mean_rank": "mean rank of the variants",
    "speedup": "speed-up",
    "value_better": "lower",
    "value_worse": "higher",
    "generations_fewer": "sooner",
    "generations_more": "later",
    "rank_at_budget": "mean rank at the smallest budget",
}


def tables(data: ReportData) -> list[ReportTable]:
    """Return the tables of the function study; none where a run has none."""
    if "functions" not in data.inputs:
        return []
    return [precision(data), speed(data), summary(data), tests(data)]


def precision(data: ReportData) -> ReportTable:
    """Return mean and deviation of the best values, as the paper's Table 1 has them."""
    rows = tuple(
        (
            _function(row), _place(row["placement"]), _words(row["search"]), plain(row["mean"]),
            plain(row["deviation"]), plain(row["best"]), plain(row["replicates"]), plain(row["spent"]),
            plain(row["mean_at_budget"]),
        )
        for row in _rows(data, "statistics")
    )  # fmt: skip
    budget = data.numbers("functions")["budget"]
    return ReportTable(
        "table_1_functions",
        "Precision: best value at the end",
        "Mean (the paper's AVG) and standard deviation (STD) over the runs; the minimum of every function is 0. "
        f"The last column holds every search to {budget:.0f} evaluations.",
        ("function", "minimum", "search", "mean", "deviation", "best", "runs", "evaluations", "mean at equal budget"),
        rows,
        paper="Table 1",
        grouped=True,
    )


def speed(data: ReportData) -> ReportTable:
    """Return generations to the threshold and success rate, as the paper's Table 2 has them."""
    rows = tuple(
        (
            _function(row), _place(row["placement"]), _words(row["search"]), plain(row["generations"]),
            plain(row["generations_deviation"]), plain(row["evaluations"]), plain(100.0 * row["success_share"]),
        )
        for row in _rows(data, "statistics")
    )  # fmt: skip
    return ReportTable(
        "table_2_functions",
        "Speed: generations until the goal is reached",
        "Mean (AVG) and standard deviation (SD) over the successful runs, and their share (SR). A generation of a "
        "cuckoo search is two evaluations of each nest, of the others one of each member.",
        ("function", "minimum", "search", "generations", "deviation", "evaluations", "success / %"),
        rows,
        paper="Table 2",
        grouped=True,
    )


def summary(data: ReportData) -> ReportTable:
    """Return what each search comes to over all functions, by placement."""
    found = data.numbers("functions")
    pairs = dict.fromkeys((str(row["placement"]), str(row["search"])) for row in _rows(data, "statistics"))
    placements = list(dict.fromkeys(placement for placement, _ in pairs))
    rows: list[tuple[Cell, ...]] = [
        (_place(placement), _words(search), *(found.get(f"{search}_{placement}_{name}") for name in _SUMMARY))
        for placement, search in sorted(pairs, key=lambda pair: placements.index(pair[0]))
    ]
    chances = "; ".join(
        f"{_place(placement)}: {found[f'{placement}_friedman_p']:.2g}"
        for placement in placements
        if f"{placement}_friedman_p" in found
    )
    return ReportTable(
        "functions_summary",
        "What becomes of a perfect score when the minimum leaves the origin",
        f"Numbers of functions, of {found['functions']:.0f}. Exactly 0 is a matter of double precision: near the "
        "origin, where numbers lie closer together, a search has farther to go to it than elsewhere. Lower, higher, "
        "sooner, later: significantly so against plain search (Wilcoxon's signed ranks, 5 % after Holm's correction). "
        "Speed-up: plain search's generations over its own, on functions that both always solve. Friedman's test, "
        "chance that the variants do not differ: "
        f"{chances}.",
        ("minimum", "search", *_SUMMARY.values()),
        tuple(rows),
        grouped=True,
    )


def tests(data: ReportData) -> ReportTable:
    """Return the tests of each variant against plain search."""
    rows = tuple(
        (
            _place(row["placement"]), _words(row["search"]), row["measure"], _function(row), plain(row["p"]),
            plain(row["p_holm"]), plain(row["larger"]),
            "better" if row["better"] else "worse" if row["worse"] else "no difference",
        )
        for row in _rows(data, "tests")
    )  # fmt: skip
    return ReportTable(
        "functions_tests",
        "Variants against plain cuckoo search",
        "Wilcoxon's signed-rank test on pairs of runs from the same start, with Holm's correction over the functions; "
        "A: the chance that the variant's value is the larger, that is worse.",
        ("minimum", "search", "measure", "function", "p", "p corrected", "A", "finding"),
        rows,
        grouped=True,
    )


def _rows(data: ReportData, name: str) -> Iterator[dict[str, Any]]:
    columns = data.table("functions", name)
    for row in zip(*columns.values(), strict=True):
        yield dict(zip(columns, row, strict=True))


def _function(row: Mapping[str, Any]) -> str:
    return NAMES.get(str(row["function"]), str(row["function"]).replace("_", " "))


def _place(placement: str) -> str:
    return PLACES.get(placement, placement)


def _words(name: str) -> str:
    """Return what a search is called, as in the figures."""
    return _SEARCHES.get(name, name.replace("_", " "))
