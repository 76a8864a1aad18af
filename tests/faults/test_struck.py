"""The driver of `make faults` strikes where it says, and sees what does not end right."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest

from pipeline.kernel import store
from tests.faults import struck
from tests.faults.boundaries import FULL, HOWS, Boundaries


@pytest.mark.parametrize("how", [*HOWS, FULL])
def test_a_write_is_struck_where_it_is_said(how: str, tmp_path: Path) -> None:
    folder = tmp_path / "case"
    folder.mkdir()
    report = tmp_path / "report.json"

    def write() -> int:
        (folder / "x").write_text("12345678")
        return 0

    assert struck._child(folder, write, Boundaries(folder), report)[0] == 0
    assert report.read_text() == '["open", "write"]'
    (folder / "x").unlink()
    code, told = struck._child(folder, write, Boundaries(folder, 2, how))
    content = (folder / "x").read_text()
    assert content == {"before": "", "half": "1234", "after": "12345678", FULL: "1234"}[how]
    if how == FULL:
        assert code == 1
        assert "No space left on device; make room and run again" in told
    else:
        assert code == -signal.SIGKILL


def test_what_is_half_written_is_seen(tmp_path: Path) -> None:
    template, folder = tmp_path / "template", tmp_path / "case"
    template.mkdir()
    artefact = folder / "results" / "store" / "first" / "key"
    artefact.mkdir(parents=True)
    (artefact / "x").write_text("half")
    store.write_text(folder / "results" / "receipts" / "first" / "x.json", "{")
    assert sorted(struck._half_written(folder, template)) == [
        "results/receipts/first/x.json",
        "results/store/first/key",
    ]


@pytest.mark.struck
def test_a_run_over_a_damaged_plan_ends_right_wherever_it_is_struck(tmp_path: Path) -> None:
    here = Path.cwd()
    try:
        tally = struck._strike((tmp_path, "a damaged plan", 1, struck._expected(tmp_path)))
    finally:
        os.chdir(here)
    assert tally.wrong == []
    assert tally.struck.total() > 100
