"""An unexpected exception ends in one line and a log file, never in a traceback."""

from __future__ import annotations

import os
import subprocess
import sys
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


def test_a_word_that_is_not_utf_8_is_a_mistake(capsys: pytest.CaptureFixture[str]) -> None:
    assert program.main(["battery.title=\udcff"]) == 2
    assert capsys.readouterr().err.startswith("error: b'battery.title=\\xff': not UTF-8")


def test_names_are_the_same_in_a_locale_without_utf_8(tmp_path: Path) -> None:
    code = (
        "import sys; from pipeline.kernel.last_resort import in_utf8; "
        "in_utf8(); open(sys.argv[1], 'w').close(); print(sys.argv[1])"
    )
    settings = os.environ | {"PYTHONPATH": str(Path(program.__file__).parents[1])}
    settings |= {"LC_ALL": "POSIX", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    words = [sys.executable, "-c", code, "Säure"]
    done = subprocess.run(words, cwd=tmp_path, env=settings, capture_output=True, check=True)
    assert done.stdout == "Säure\n".encode()
    assert [os.fsencode(path.name) for path in tmp_path.iterdir()] == ["Säure".encode()]
