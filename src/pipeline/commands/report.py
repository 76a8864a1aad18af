"""`python -m pipeline report [RUN]`: the verdicts of a published run in the terminal, and where its page is."""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from pipeline.errors import UserError, best_matches
from pipeline.kernel import publish, tables
from pipeline.kernel.store import RESULTS
from pipeline.published.answer import ANSWER
from pipeline.published.evaluate import VERDICTS
from pipeline.published.words import counted


def main(arguments: Sequence[str]) -> int:
    """Print a run's verdicts; return 0."""
    parser = argparse.ArgumentParser(prog="python -m pipeline report", description=__doc__)
    parser.add_argument("run", nargs="?", default="solar_reflex/default", help="study/run (%(default)s)")
    run = parser.parse_args(arguments).run.removeprefix(f"{RESULTS}/").strip("/")
    run = run if "/" in run else f"{run}/default"
    path = RESULTS / run / "published" / "verdicts.parquet"
    if not path.is_file():
        raise UserError(_unpublished(run))
    answer = path.with_name("answer.parquet")
    if answer.is_file():
        _tell(tables.read(ANSWER, answer))
    _print(tables.read(VERDICTS, path))
    print(f"\nthe page: {Path('reports') / run / 'index.html'}")
    return 0


def _unpublished(run: str) -> str:
    """Say why a run has no verdicts: only parts of it were made, or nothing."""
    parts = sorted((RESULTS / run).glob("manifest*.json"))
    if not parts:
        known = {path.parent.relative_to(RESULTS).as_posix() for path in RESULTS.glob("*/*/manifest.json")}
        return f"run {run!r}: not published here; {best_matches(run, known)}"
    manifest = json.loads(parts[0].read_text())
    if (RESULTS / run / publish.MANIFEST).is_file():
        return f"run {run!r}: its study has no verdicts; the page is {Path('reports') / run / 'index.html'}"
    made = ", ".join(path.name.split(".")[1] for path in parts)
    return f"run {run!r}: only parts of it are here ({made}), and no verdicts; all of it: {manifest['command']}"


def _tell(answer: Mapping[str, Any]) -> None:
    """Print what the study recommends."""
    console = Console()
    for place, sentence in enumerate(answer["sentence"]):
        console.print(f"[bold]{escape(sentence)}[/bold]" if place == 0 else f"  {escape(sentence)}", highlight=False)
    console.print()


def _print(verdicts: Mapping[str, Any]) -> None:
    table = Table("statement", "verdict", "where", "why", show_lines=False)
    columns = [list(verdicts[name]) for name in ("statement", "verdict", "where", "explanation")]
    for row in zip(*columns, strict=True):
        table.add_row(*row)
    console = Console()
    console.print(table)
    found = counted(verdicts)
    console.print(_told(found["statements"]))
    if found["arithmetic"]:
        console.print(f"arithmetic of the paper alone, counted apart: {_told(found['arithmetic'])}")


def _told(counts: Sequence[tuple[str, int]]) -> str:
    return ", ".join(f"{count} {word}" for word, count in counts)
