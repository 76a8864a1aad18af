"""What the terminal says at the end: which charges ended before they were where they were to go, where results are."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from pipeline import schemas, store, tables
from pipeline.publish import view_folder

MOST_RUNS = 8


def tell(plan: Mapping[str, Any], targets: Iterable[str], results: Path) -> Iterator[str]:
    """Yield what there is to say of the runs that some targets of a plan made, whole or in part."""
    made = _made(plan, targets)
    for run, steps in made:
        if "charge" in steps:
            yield from unreached(run, results)
    for run, steps in made[:MOST_RUNS]:
        yield f"results: {view_folder(results, run, 'results')}"
        if "page" in steps:
            yield f"the page: {view_folder(results, run, 'reports') / 'index.html'}"
    if len(made) > MOST_RUNS:
        yield f"and {len(made) - MOST_RUNS} more runs beside them"


def unreached(run: Mapping[str, Any], results: Path) -> Iterator[str]:
    """Yield a line for each charge of a run that is in the store and reached none of its goals."""
    for name, node in run["nodes"].items():
        summary = store.artefact(results, node["step"], node["key"]) / "summary.parquet"
        if node["step"] != "charge" or not summary.is_file():
            continue
        columns = tables.read(schemas.CHARGE_SUMMARY, summary)
        for quantity, text in zip(columns["quantity"], columns["text"], strict=True):
            if quantity == "missed":
                yield f"{run['study']}/{run['name']} {name}: {text}"


def _made(plan: Mapping[str, Any], targets: Iterable[str]) -> list[tuple[Mapping[str, Any], set[str]]]:
    """Return each run that some targets make, with the steps of it that they publish."""
    steps: dict[int, set[str]] = {}
    for name in targets:
        for chunk in (plan["chunks"][chunk] for chunk in plan["targets"][name]):
            for number in chunk["runs"]:
                steps.setdefault(number, set()).update(chunk["steps"])
    return [(plan["runs"][number], steps[number]) for number in sorted(steps)]
