"""What a person sees of a run: a line a finished job, warnings, errors; Snakemake's own words on request."""

from __future__ import annotations

import io
import logging
import re
import shutil
import sys
from collections.abc import Iterator, Sequence
from typing import Any

_MOST_LINES = 40
"""Lines of progress where nobody watches them come, as in a file or a pipe."""
_STREAM = "DefaultStreamHandler"
_KEPT = ("Nothing to be done", "Elapsed time")
QUIET = ("rules", "host", "reason", "progress")
"""What Snakemake's --quiet takes for `python -m pipeline -q`: warnings and errors are left."""


def quieten(logger: logging.Logger, settings: Any) -> None:
    """Let Snakemake's stream show a line a job; its log file keeps all it says.

    Nothing changes where its words were asked for (--verbose, -p), chosen (--quiet, a logger of one's own), or are the
    answer (--dry-run); all that QUIET names leaves warnings and errors.

    Arguments
    ---------
    logger : Snakemake's.
    settings : its output settings, `workflow.output_settings`.
    """
    quiet = {str(word) for word in settings.quiet or ()}
    if set(QUIET) <= quiet:
        for handler in logger.handlers:
            if handler.name == _STREAM:
                handler.addFilter(_is_warning)
        return
    if settings.verbose or settings.printshellcmds or quiet or settings.dryrun or settings.debug_dag:
        return
    for handler in logger.handlers:
        if handler.name == _STREAM and handler.formatter is not None:
            stream = getattr(handler, "stream", None)
            watched = bool(stream is not None and stream.isatty())
            lines = ProgressLines(handler.formatter, watched)
            handler.addFilter(lines.shown)
            handler.setFormatter(lines)


def _is_warning(record: logging.LogRecord) -> bool:
    return record.levelno >= logging.WARNING or str(getattr(record, "event", None) or "") == "job_error"


class ProgressLines(logging.Formatter):
    """Makes a line of a finished job, and leaves out what tells a person nothing.

    Arguments
    ---------
    own : Snakemake's formatter, for warnings and errors.
    watched : whether a line comes for every job; else for at most 40 of them.
    """

    def __init__(self, own: logging.Formatter, watched: bool) -> None:
        super().__init__()
        self._own = own
        self._watched = watched
        self._begun: dict[int, str] = {}
        self._ended = ""

    def shown(self, record: logging.LogRecord) -> bool:
        """Tell whether a record makes a line; keep what the lines to come are made of."""
        event = str(getattr(record, "event", None) or "")
        if event == "job_info":
            self._begun[getattr(record, "jobid", -1)] = str(getattr(record, "rule_msg", "") or "")
        elif event == "job_finished":
            self._ended = self._begun.pop(getattr(record, "job_id", -1), "")
        elif event == "progress":
            return bool(self._ended) and self._is_due(record)
        elif event == "job_error" or record.levelno >= logging.WARNING:
            return True
        return not event and str(record.msg).startswith(_KEPT)

    def format(self, record: logging.LogRecord) -> str:
        """Return the line of a record."""
        if str(getattr(record, "event", None) or "") != "progress":
            return self._own.format(record)
        done, total = _counts(record)
        return f"[{done:{len(str(total))}d}/{total}] {self._ended}"

    def _is_due(self, record: logging.LogRecord) -> bool:
        done, total = _counts(record)
        return self._watched or total <= _MOST_LINES or done * _MOST_LINES // total > (done - 1) * _MOST_LINES // total


def _counts(record: logging.LogRecord) -> tuple[int, int]:
    return int(getattr(record, "done", 0)), max(1, int(getattr(record, "total", 1)))


def is_watched() -> bool:
    """Tell whether a person sees what is printed as it comes, and not a file or another program."""
    return sys.stdout.isatty()


def printed(text: str) -> str:
    """Return a sentence with its degrees as people write them; messages of errors keep the spelling of the tables."""
    return re.sub(r"(?<=\d) degC\b", " °C", text)


def say(text: str, bold: bool = False) -> None:
    """Print a sentence: folded at the width of the terminal, in one line where nobody watches."""
    text = printed(text)
    if not is_watched():
        print(text)
        return
    from rich.console import Console
    from rich.text import Text

    Console(width=shutil.get_terminal_size().columns).print(Text(text, style="bold" if bold else ""))


def table_lines(rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """Yield the lines of a table: as wide as the terminal, or where nobody watches, a line a row.

    A terminal folds words, never names and numbers; columns that it has no room for are left out, and named.

    Arguments
    ---------
    rows : the cells, the header first; a column that is empty is left out.
    """
    filled = [place for place in range(len(rows[0])) if place == 0 or any(row[place] for row in rows[1:])]
    rows = [[row[place] for place in filled] for row in rows]
    body = rows[1:]
    widths = [max(len(row[place]) for row in rows) for place in range(len(rows[0]))]
    right = [place > 0 and _is_numeric([row[place] for row in body]) for place in range(len(rows[0]))]
    if not is_watched():
        for row in rows:
            cells = zip(row, widths, right, strict=True)
            padded = [cell.rjust(width) if to_right else cell.ljust(width) for cell, width, to_right in cells]
            yield "  ".join(padded).rstrip()
        return
    room = shutil.get_terminal_size().columns
    fixed = [place == 0 or is_right for place, is_right in enumerate(right)]
    least = [width if kept else min(width, _FOLDED) for width, kept in zip(widths, fixed, strict=True)]
    count = next((count for count in range(len(least), 1, -1) if sum(least[:count]) + 2 * count <= room), 1)
    yield from _drawn([row[:count] for row in rows], right, fixed, room)
    if count < len(least):
        yield f"a wider terminal, or a pipe, shows more: {', '.join(rows[0][count:])}"


_FOLDED = 14
"""Letters that a column of words needs at least."""


def _drawn(rows: Sequence[Sequence[str]], right: Sequence[bool], fixed: Sequence[bool], room: int) -> Iterator[str]:
    from rich import box
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, 1), collapse_padding=True)
    for place, name in enumerate(rows[0]):
        table.add_column(Text(name), justify="right" if right[place] else "left", no_wrap=fixed[place])
    for row in rows[1:]:
        table.add_row(*map(Text, row))
    console = Console(width=room, record=True, file=io.StringIO())
    console.print(table)
    yield from (line.rstrip() for line in console.export_text(styles=True).rstrip().splitlines())


def _is_numeric(cells: Sequence[str]) -> bool:
    """Tell whether a column holds numbers, ranges of them and dashes alone, one number at least."""
    marks = set("0123456789.,+-\N{MINUS SIGN}\N{EN DASH} to")
    return any(cell[:1].isdigit() for cell in cells) and all(set(cell) <= marks for cell in cells)
