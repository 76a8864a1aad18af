"""What a job says and returns where a charge cannot be computed."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.errors import EngineError, UserError
from pipeline.kernel import planfile
from pipeline.kernel import run as runner
from pipeline.kernel.store import StoreError


@pytest.mark.parametrize(("kind", "code"), [(EngineError, 1), (StoreError, 1), (UserError, 2)])
def test_one_line_and_a_code(kind, code, monkeypatch, capsys, tmp_path: Path) -> None:
    def fails(*_: object) -> None:
        raise kind("the steps are used up at 3 s")

    monkeypatch.setattr(planfile, "load", lambda path: {"chunks": {"one": {"step": "charge"}}})
    monkeypatch.setattr(runner, "run_chunk", fails)
    arguments = ["--plan", str(tmp_path / "plan.json"), "--step", "charge", "--chunk", "one"]
    assert runner.main(arguments) == code
    assert capsys.readouterr().err == "error: the steps are used up at 3 s\n"
