"""An unexpected exception ends in one line and a log file, never in a traceback."""

from __future__ import annotations

from pathlib import Path

import pytest

import pipeline.__main__ as program


def _fail(words: object) -> int:
    raise RuntimeError("two\nlines")


@pytest.fixture(autouse=True)
def _inside(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(program, "_command", lambda name: _fail)


def test_one_line_and_a_log_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert program.main(["steps"]) == 1
    told = capsys.readouterr().err
    (log,) = (tmp_path / "results" / "logs").iterdir()
    assert told.count("\n") == 1
    assert told.startswith("error: RuntimeError: two lines (unexpected; details in results/logs/error-")
    assert log.name in told
    assert "Traceback" in log.read_text()


def test_without_a_folder_for_the_log_it_is_still_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "results").write_text("")
    assert program.main(["steps"]) == 1
    assert capsys.readouterr().err.count("\n") == 1
