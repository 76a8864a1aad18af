"""What the terminal says at the end of a sweep: its runs, with the numbers that are looked at first."""

from __future__ import annotations

import io
import sys
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from pipeline.experiments.sweeps.reading import TABLE, Outcome, outcomes, text
from pipeline.kernel import store

MOST_ROWS = 12


def lines(run: Mapping[str, Any], steps: Collection[str], results: Path) -> Iterator[str]:
    """Yield the lines of a table of a sweep's runs; none for what is no sweep, or was not asked for.

    Where nobody watches, a line is a row, without boxes and with all its values.

    Arguments
    ---------
    run : as the plan holds it.
    steps : those that were asked for.
    """
    item = next((one for one in run["view"] if one["step"] == "sweep" and one["file"] == TABLE), None)
    if item is None or "sweep" not in steps:
        return
    import pyarrow.parquet as pq
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    found = pq.read_table(store.artefact(results, item["step"], item["key"]) / TABLE)
    columns = {name: found.column(name).to_pylist() for name in found.column_names}
    swept = found.column_names[1 : 1 + len(next(iter(run["sweep"].values()))["values"])]
    headlines = outcomes(columns)
    # A comparison is enough here; the others are in the table.
    first = headlines[0].charge.rpartition(".")[0]
    headlines = [one for one in headlines if one.charge.rpartition(".")[0] == first]
    watched = sys.stdout.isatty()
    look: dict[str, Any] = {} if watched else {"box": None, "pad_edge": False, "padding": (0, 2, 0, 0)}
    yield _title(run, found.num_rows, first)
    table = Table(**look)
    for name in swept:
        unit = (found.schema.field(name).metadata or {}).get(b"unit", b"").decode()
        table.add_column(escape(name + _unit(unit)), justify="left" if unit == "" else "right", no_wrap=True)
    table.add_column("mode", no_wrap=True)
    titles = list(dict.fromkeys((one.title, one.unit) for one in headlines))
    for title, unit in titles:
        table.add_column(escape(f"{title}{_unit(unit)}"), justify="right")
    by_mode = {mode: {one.title: one for one in headlines if one.charge == mode} for mode in _modes(headlines)}
    shown = range(found.num_rows) if found.num_rows <= MOST_ROWS else range(MOST_ROWS - 2)
    for row in shown:
        values = [escape(text(columns[name][row]) or "-") for name in swept]
        for mode, told in by_mode.items():
            cells = [told.get(title) for title, _ in titles]
            numbers = [(one and text(columns[one.column][row], one.factor)) or "-" for one in cells]
            table.add_row(*values, escape(mode.removeprefix(f"{first}.")), *numbers)
            values = [""] * len(values) if watched else values
        table.add_section()
    console = Console(width=None if watched else 1000, record=True, file=io.StringIO())
    console.print(table)
    yield from (line.rstrip() for line in console.export_text(styles=watched).rstrip().splitlines())
    if found.num_rows > len(shown):
        yield f"and {found.num_rows - len(shown)} more runs in the table"
    missed = [name for name in found.column_names if name.endswith(".missed")]
    for name in missed:
        some = [row for row, told in enumerate(columns[name]) if told]
        if some:
            first = columns[name][some[0]]
            yield f"{name.removesuffix('.missed')}: {len(some)} of {found.num_rows} runs missed something, as {first}"


def _modes(headlines: Sequence[Outcome]) -> list[str]:
    return list(dict.fromkeys(one.charge for one in headlines))


def _title(run: Mapping[str, Any], count: int, comparison: str) -> str:
    of = f", comparison {comparison}" if comparison else ""
    return f"{run['study']}/{run['name']}: {count} runs{of}"


def _unit(unit: str) -> str:
    return f" [{unit}]" if unit not in ("", "1") else ""
