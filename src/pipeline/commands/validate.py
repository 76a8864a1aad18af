"""`python -m pipeline validate`: holds the engine against what is known; non-zero where a bound is broken."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from pipeline.commands import Parser, as_typed, typed
from pipeline.commands.run import cores, planned, snakemake
from pipeline.commands.workflow import say
from pipeline.experiments.validation.records import BROKEN, NOT_INSTALLED
from pipeline.experiments.validation.registry import CHECKS, VALIDATION
from pipeline.kernel import lock, planfile, store, tables

STUDY = "validation"


def main(arguments: Sequence[str]) -> int:
    """Run the checks that are not there yet, print what they come to; return 0, or 1 where a bound is broken."""
    parser = Parser(prog=typed("validate"), description=as_typed(__doc__ or ""))
    parser.add_argument("-c", "--cores", type=cores, default="2", help="cores Snakemake may use (%(default)s)")
    parser.add_argument("-a", "--all-rows", action="store_true", help="print every row, not only those that fail")
    options = parser.parse_args(arguments)
    failed = _made(options.cores)
    if failed:
        return failed
    view = store.RESULTS / STUDY / "default"
    found = dict(findings(view))
    _print(found, options.all_rows)
    print(f"the page: {Path('reports') / STUDY / 'default' / 'index.html'}")
    return exit_code(found)


def findings(view: Path) -> Iterator[tuple[str, list[dict[str, Any]]]]:
    """Yield the name of every check with its rows, from the readable view of a run."""
    declared = VALIDATION["rows"]
    for name in CHECKS:
        columns = tables.read(declared.table, view / f"{name}.{declared.file}")
        yield name, [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def exit_code(found: Mapping[str, Sequence[Mapping[str, Any]]]) -> int:
    """Return 1 where a row of any check is broken, or a check has no rows; a peer not installed breaks nothing."""
    return int(any(not rows or any(row["finding"] == BROKEN for row in rows) for rows in found.values()))


def _made(cores: str) -> int:
    plan = planfile.save(planned([f"study={STUDY}"]), store.RESULTS, say)
    with lock.held(store.RESULTS, say) as descriptor:
        return snakemake([STUDY, "--cores", cores, "--config", f"plan={plan}"], descriptor)


def _print(found: Mapping[str, Sequence[Mapping[str, Any]]], all_rows: bool) -> None:
    table = Table("check", "quantity", "value", "bound", "finding")
    for name, rows in found.items():
        for row in rows:
            if all_rows or row["finding"] in (BROKEN, NOT_INSTALLED):
                value = f"{row['value']:.3g} {row['unit']}".removesuffix(" 1") if row["value"] == row["value"] else ""
                bound = "" if row["relation"] is None else f"{row['relation']} {row['bound']:g}"
                table.add_row(CHECKS[name].title, row["quantity"], value, bound, row["finding"])
    console = Console()
    if table.row_count:
        console.print(table)
    for name, rows in found.items():
        counts = Counter(row["finding"] for row in rows)
        said = ", ".join(f"{count} {finding}" for finding, count in counts.items())
        console.print(f"{CHECKS[name].title}: {said}")
