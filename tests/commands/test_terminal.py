"""A line a job, whatever Snakemake says beside it."""

from __future__ import annotations

import io
import logging
import re
from collections.abc import Mapping
from types import SimpleNamespace

import pytest

from pipeline.commands import report, terminal
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


VERDICTS = {
    "statement": ["a_statement_with_a_long_name", "other"],
    "verdict": ["holds", "not reproduced"],
    "where": ["section 4, Figures 13 and 15", "Table 1"],
    "explanation": ["Time to SOC 0.95: 10165 s,\nprinted: " + "10160 s; " * 30, "Printed: 1; ours: 2."],
    "basis": ["model", "model"],
}
ANSWER = {"sentence": ["Best: CC-CV, " + "by far " * 40, "Charging time: CC-CV 1 s [bold]"]}


def _reported(capsys: pytest.CaptureFixture[str]) -> list[str]:
    report._tell(ANSWER)
    report._print(VERDICTS)
    return capsys.readouterr().out.splitlines()


def test_a_report_in_a_pipe_is_a_line_a_statement_without_boxes_and_colours(capsys: pytest.CaptureFixture[str]) -> None:
    lines = _reported(capsys)
    assert lines[0] == ANSWER["sentence"][0]
    assert lines[1] == f"  {ANSWER['sentence'][1]}"
    head, first, second = lines[3:6]
    assert re.split(r"\s{2,}", head) == ["statement", "verdict", "where", "why"]
    assert re.split(r"\s{2,}", second) == ["other", "not reproduced", "Table 1", "Printed: 1; ours: 2."]
    assert first.endswith(" ".join(VERDICTS["explanation"][0].split()))
    assert not re.search(r"[\x1b\u2500-\u257f]", "".join(lines))


@pytest.mark.parametrize("width", [50, 80, 100, 160])
def test_a_report_fits_the_terminal(
    width: int, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(terminal, "is_watched", lambda: True)
    monkeypatch.setenv("COLUMNS", str(width))
    lines = [re.sub(r"\x1b\[[0-9;]*m", "", line) for line in _reported(capsys)]
    assert max(len(line) for line in lines if not line.startswith("a wider terminal")) <= width
    assert any(line.startswith("a_statement_with_a_long_name") and "holds" in line for line in lines)
    shown = " ".join(" ".join(lines).split())
    assert " ".join(ANSWER["sentence"][0].split()) in shown


def test_sentences_say_degrees_as_people_write_them() -> None:
    assert terminal.printed("surroundings: 25 degC, 0.5 K above") == "surroundings: 25 °C, 0.5 K above"
    assert terminal.printed("column 'Surface Temperature / degC'") == "column 'Surface Temperature / degC'"
