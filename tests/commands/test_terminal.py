"""A line a job, whatever Snakemake says beside it."""

from __future__ import annotations

import io
import logging
from collections.abc import Mapping
from types import SimpleNamespace

import pytest

from pipeline.commands.terminal import QUIET, quieten

NOTHING = {"verbose": False, "printshellcmds": False, "quiet": set(), "dryrun": False, "debug_dag": False}


def said(jobs: int, watched: bool = False, asked: Mapping[str, object] | None = None) -> list[str]:
    """Return the lines that a run of some jobs leaves in a stream."""
    stream = io.StringIO()
    stream.isatty = lambda: watched  # type: ignore[method-assign]
    handler = logging.StreamHandler(stream)
    handler.name = "DefaultStreamHandler"
    handler.setFormatter(logging.Formatter("%(message)s"))
    logger = logging.Logger("snakemake", logging.INFO)
    logger.addHandler(handler)
    quieten(logger, SimpleNamespace(**NOTHING | dict(asked or {})))
    logger.info("Building DAG of jobs...")
    logger.info("Job stats: ...", extra={"event": "run_info"})
    for job in range(jobs):
        logger.info("rule", extra={"event": "job_info", "jobid": job, "rule_msg": f"Charge: {job}"})
        logger.info(f"Finished jobid: {job}", extra={"event": "job_finished", "job_id": job})
        logger.info(None, extra={"event": "progress", "done": job + 1, "total": jobs})
    logger.warning("a warning")
    logger.error("Error in rule", extra={"event": "job_error"})
    return stream.getvalue().splitlines()


def test_a_line_a_job_then_what_went_wrong() -> None:
    assert said(2) == ["[1/2] Charge: 0", "[2/2] Charge: 1", "a warning", "Error in rule"]


def test_at_most_forty_lines_where_nobody_watches_and_the_last_job_among_them() -> None:
    lines = said(1000)
    assert len(lines) == 42
    assert lines[39] == "[1000/1000] Charge: 999"
    assert len(said(1000, watched=True)) == 1002


@pytest.mark.parametrize("asked", [{"verbose": True}, {"printshellcmds": True}, {"dryrun": True}, {"quiet": {"host"}}])
def test_its_own_words_where_they_are_asked_for(asked: dict[str, object]) -> None:
    assert said(1, asked=asked)[:2] == ["Building DAG of jobs...", "Job stats: ..."]


def test_quiet_leaves_warnings_and_errors_alone() -> None:
    assert said(3, asked={"quiet": set(QUIET)}) == ["a warning", "Error in rule"]
