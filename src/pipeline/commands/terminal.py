"""What a person sees of a run: a line a finished job, warnings, errors; Snakemake's own words on request."""

from __future__ import annotations

import logging
from typing import Any

_MOST_LINES = 40
"""Lines of progress where nobody watches them come, as in a file or a pipe."""
_STREAM = "DefaultStreamHandler"
_KEPT = ("Nothing to be done", "Elapsed time")


def quieten(logger: logging.Logger, settings: Any) -> None:
    """Let Snakemake's stream show a line a job; its log file keeps all it says.

    Nothing changes where its words were asked for (--verbose, -p), chosen (--quiet, a logger of one's own), or are the
    answer (--dry-run).

    Arguments
    ---------
    logger : Snakemake's.
    settings : its output settings, `workflow.output_settings`.
    """
    if settings.verbose or settings.printshellcmds or settings.quiet or settings.dryrun or settings.debug_dag:
        return
    for handler in logger.handlers:
        if handler.name == _STREAM and handler.formatter is not None:
            stream = getattr(handler, "stream", None)
            watched = bool(stream is not None and stream.isatty())
            lines = ProgressLines(handler.formatter, watched)
            handler.addFilter(lines.shown)
            handler.setFormatter(lines)


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
