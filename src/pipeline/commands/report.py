"""`python -m pipeline report [RUN]`: the verdicts of a published run in the terminal, and where its page is."""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from pipeline import schemas, tables
from pipeline.errors import UserError, best_matches
from pipeline.store import RESULTS


def main(arguments: Sequence[str]) -> int:
    """Print a run's verdicts; return 0."""
    parser = argparse.ArgumentParser(prog="python -m pipeline report", description=__doc__)
    parser.add_argument("run", nargs="?", default="solar_reflex/default", help="study/run (%(default)s)")
    run = parser.parse_args(arguments).run
    path = RESULTS / run / "published" / "verdicts.parquet"
    if not path.is_file():
        known = [str(p.parent.relative_to(RESULTS)) for p in RESULTS.glob("*/*/manifest.json")]
        raise UserError(f"run {run!r}: not published here; {best_matches(run, known)}")
    _print(tables.read(schemas.VERDICTS, path))
    print(f"\nthe page: {Path('reports') / run / 'index.html'}")
    return 0


def _print(verdicts: Mapping[str, Any]) -> None:
    table = Table("statement", "verdict", "where", "why", show_lines=False)
    columns = [list(verdicts[name]) for name in ("statement", "verdict", "where", "explanation")]
    for row in zip(*columns, strict=True):
        table.add_row(*row)
    console = Console()
    console.print(table)
    counts = Counter(columns[1])
    console.print(", ".join(f"{count} {verdict}" for verdict, count in sorted(counts.items())))
