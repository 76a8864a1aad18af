"""The search for a frequency on the page: the tuning, the searches and what lies behind them."""

from __future__ import annotations

import csv
from collections.abc import Mapping

import numpy as np

from pipeline.experiments.frequency.tuning_tables import KNOBS
from pipeline.published.reference import REFERENCE
from pipeline.report.tables import Cell, ReportData, ReportTable, plain

LABELS = ("searched",)
PRINTED = REFERENCE / "solar_table3.csv"
_OF_A_SEARCH = (
    ("frequency_hz", "found / Hz"),
    ("frequency_mean_hz", "mean / Hz"),
    ("frequency_deviation_hz", "deviation / Hz"),
    ("ise_mw2_s", "ISE / mW² s"),
    ("iterations_to_within_1_hz", "iterations to within 1 Hz"),
    ("arrived_share", "share that got there"),
    ("final_distance_hz", "final distance / Hz"),
    ("evaluations", "evaluations"),
    ("replicates", "replicates"),
)
_SEARCHES = {
    "swarm": "swarm, tuned C1, C2, W", "swarm_published": "swarm, published C1, C2, W",
    "uniform": "swarm, uniform numbers", "arcsine": "swarm, arcsine numbers",
    "published_protocol": "five runs, as published", "sweep": "brute force",
}  # fmt: skip
_NUMBERS = {
    "chaos": ("The logistic map in numbers", "Entropies count visits to equal bins over [0, 1]."),
    "objective": (
        "The loss against frequency in numbers",
        "At the objective's state of charge, for the whole battery.",
    ),
    "tuning": (
        "The tuning in numbers",
        "published: the paper's Table 2 as printed; rerun: its array on our objective.",
    ),
}


def tables(data: ReportData) -> list[ReportTable]:
    """Return the tables of those steps of the search that a run holds."""
    shown: list[ReportTable] = []
    if "tuning" in data.inputs:
        shown += [table_2(data), table_3(data), variance(data), agreement(data)]
    if "search" in data.inputs:
        shown += [searches(data), comparison(data)]
    return shown + [numbers(data, source) for source in _NUMBERS if source in data.inputs]


def notes(data: ReportData) -> list[str]:
    """Say in a sentence that the least loss lies where the search does not look; nothing where it does."""
    searched = data.settings.get("searched")
    if not searched or not {"objective", "search"} <= set(data.inputs):
        return []
    best, low, high = data.numbers("objective").get("optimal_frequency_hz"), searched["low"], searched["high"]
    if best is not None and low <= best <= high:
        return []
    where = "has no least value" if best is None else f"is least at {best:.3g} Hz"
    return [
        f"With this battery the loss against frequency {where}, outside the {low:g} Hz to {high:g} Hz that are "
        "searched: what the search finds is an end of its range."
    ]


def table_2(data: ReportData) -> ReportTable:
    """Return the runs of the parameter design: what the paper prints, and the mean of our searches."""
    runs = data.table("tuning", "rerun_runs")
    printed = _printed_runs(data)
    rows: list[tuple[Cell, ...]] = []
    for run in np.unique(runs["run"]):
        chosen = runs["run"] == run
        knobs = tuple(float(runs[name][chosen][0]) for name in KNOBS)
        results = runs["result"][chosen]
        spread = float(np.std(results, ddof=1)) if len(results) > 1 else None
        rows.append((int(run), *map(plain, knobs), printed.get(knobs), float(np.mean(results)), spread))
    return ReportTable(
        "table_2",
        "Parameter design: integral square error of each run",
        "Printed: the paper's. Computed: the mean over our searches, and their standard deviation. The two objectives "
        "differ in scale, so the columns are to be compared in their order alone.",
        ("run", "C1", "C2", "W", "printed", "computed / mW² s", "deviation / mW² s"),
        tuple(rows),
        paper="Table 2",
    )


def table_3(data: ReportData) -> ReportTable:
    """Return the sums by level: as printed, from the printed Table 2, and from our searches."""
    with PRINTED.open(encoding="utf-8", newline="") as file:
        paper = {int(row["level"]): row for row in csv.DictReader(file)}
    recomputed = _sums(data, "published_sums") if data.holds("tuning", "published_sums") else {}
    ours = _sums(data, "rerun_sums")
    rows: list[tuple[Cell, ...]] = []
    for name in KNOBS:
        for level, sums in ours.items():
            if sums[name] is None:
                continue
            theirs = plain(float(paper[level][name])) if level in paper else None
            rows.append((name.upper(), level, theirs, recomputed.get(level, {}).get(name), sums[name]))
    return ReportTable(
        "table_3",
        "Parameter design: sums by level",
        "The least sum of a factor is the level chosen.",
        ("factor", "level", "printed", "from Table 2", "computed / mW² s"),
        tuple(rows),
        paper="Table 3",
        grouped=True,
    )


def variance(data: ReportData) -> ReportTable:
    """Return the analyses of variance, of the printed results and of ours."""
    rows: list[tuple[Cell, ...]] = []
    for name, title in (("published", "as printed"), ("rerun", "run anew")):
        if not data.holds("tuning", f"{name}_anova"):
            continue
        found = data.table("tuning", f"{name}_anova")
        columns = (found[key] for key in ("source", "sum_of_squares", "degrees_of_freedom", "mean_square", "f", "p"))
        rows += [(title, *map(plain, row)) for row in zip(*columns, strict=True)]
    return ReportTable(
        "variance",
        "Do the factors matter?",
        "Analysis of variance of the parameter design; p is the chance of an F this large if the factor did nothing.",
        ("results", "source", "sum of squares", "degrees of freedom", "mean square", "F", "p"),
        tuple(rows),
        grouped=True,
    )


def agreement(data: ReportData) -> ReportTable:
    """Return how often the array chooses what all combinations would."""
    header = {
        "searches_per_run": "searches per run", "experiments": "experiments", "found_share": "best found by the array",
        "factorial_found_share": "by all combinations", "c1_share": "best C1", "c2_share": "best C2",
        "w_share": "best W", "mean_rank": "mean rank of its choice", "mean_rank_of_best_run": "of its best run",
    }  # fmt: skip
    return ReportTable(
        "agreement",
        "How often does the array find the best combination?",
        "Shares of the experiments; each is judged by the searches of all others.",
        tuple(header.values()),
        _rows(data.table("tuning", "agreement"), tuple(header)),
    )


def searches(data: ReportData) -> ReportTable:
    """Return a row per search: what it found, how soon, how near."""
    found = data.numbers("search")
    names = [str(name) for name in dict.fromkeys(data.table("search", "statistics")["search"])]
    rows = [(_called(name), *(found.get(f"{name}_{key}") for key, _ in _OF_A_SEARCH)) for name in names]
    return ReportTable(
        "searches",
        "The searches",
        "Distances are from the frequency that the sweep finds; means are over the replicates.",
        ("search", *(title for _, title in _OF_A_SEARCH)),
        tuple(rows),
    )


def comparison(data: ReportData) -> ReportTable:
    """Return the effect sizes between searches."""
    names = ("measure", "first", "second", "larger", "larger_low", "larger_high")
    found = _rows(data.table("search", "comparison"), names)
    return ReportTable(
        "comparison",
        "The searches compared",
        "A: the chance that the first needs more iterations or ends farther off than the second (Vargha and Delaney); "
        "0.5 is no difference. The ends are those of a 95 % interval.",
        ("measure", "first", "second", "A", "low", "high"),
        tuple((measure, *map(_called, row[:2]), *row[2:]) for measure, *row in found),
        grouped=True,
    )


def _called(search: Cell) -> str:
    """Return what a search is called; its name in words where the configuration names another."""
    return _SEARCHES.get(str(search), str(search).replace("_", " "))


def numbers(data: ReportData, source: str) -> ReportTable:
    """Return the named numbers that a step found."""
    title, caption = _NUMBERS[source]
    rows = _rows(data.table(source, "quantities"), ("quantity", "value", "unit", "description"))
    return ReportTable(f"numbers_{source}", title, caption, ("quantity", "value", "unit", "meaning"), rows)


def _rows(columns: Mapping[str, np.ndarray], names: tuple[str, ...]) -> tuple[tuple[Cell, ...], ...]:
    return tuple(tuple(map(plain, row)) for row in zip(*(columns[name] for name in names), strict=True))


def _printed_runs(data: ReportData) -> dict[tuple[float, ...], float]:
    """Return C1, C2, W -> the paper's result."""
    if not data.holds("tuning", "published_runs"):
        return {}
    runs = data.table("tuning", "published_runs")
    knobs = zip(*(runs[name].tolist() for name in KNOBS), strict=True)
    return dict(zip(knobs, runs["result"].tolist(), strict=True))


def _sums(data: ReportData, name: str) -> dict[int, dict[str, float | None]]:
    """Return level -> factor -> sum; none where the design does not vary the factor."""
    table = data.table("tuning", name)
    return {
        int(level): {factor: float(table[factor][row]) if np.isfinite(table[factor][row]) else None for factor in KNOBS}
        for row, level in enumerate(table["level"])
    }
