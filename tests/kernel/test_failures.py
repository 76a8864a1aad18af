"""What a job says and returns where a charge cannot be computed."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from pipeline.errors import EngineError, UserError
from pipeline.kernel import planfile, receipts
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


def _chunk(monkeypatch: pytest.MonkeyPatch, impossible: str) -> tuple[dict[str, Any], list[list[str]]]:
    """Return a plan of one job with five nodes, made three at a time, and the nodes that are made together."""
    together: list[list[str]] = []

    def run_many(tasks: list[runner.Task]) -> None:
        together.append([task.settings["name"] for task in tasks])
        for settings, _, output in tasks:
            if settings["name"] == impossible:
                raise EngineError(f"{impossible} has no solution")
            (output.folder / "made.txt").write_text(settings["name"])

    monkeypatch.setattr(runner.importlib, "import_module", lambda name: SimpleNamespace(run_many=run_many, BATCH=3))
    keys = [f"{place}" * 64 for place in range(5)]
    nodes = {key: {"step": "step", "parts": {"name": f"n{key[0]}"}, "inputs": {}} for key in keys}
    plan = {
        "nodes": nodes,
        "parts": {f"n{place}": f"node {place}" for place in range(5)},
        "chunks": {"one": {"step": "step", "nodes": keys}},
        "steps": {"step": {"module": "m", "tables": {}}},
    }
    return plan, together


def test_a_job_makes_its_nodes_together_and_a_receipt(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    plan, together = _chunk(monkeypatch, "")
    runner.run_chunk(plan, "one", tmp_path, again=False)
    assert together == [["node 0", "node 1", "node 2"], ["node 3", "node 4"]]
    assert receipts.path_of(tmp_path, "step", "one").is_file()
    runner.run_chunk(plan, "one", tmp_path, again=False)
    assert len(together) == 2


def test_of_a_job_with_one_impossible_node_the_others_are_kept(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plan, _ = _chunk(monkeypatch, "node 1")
    with pytest.raises(EngineError, match="node 1 has no solution"):
        runner.run_chunk(plan, "one", tmp_path, again=False)
    made = sorted(path.name[0] for path in (tmp_path / "store" / "step").iterdir())
    assert made == ["0", "2", "3", "4"]
    assert not receipts.path_of(tmp_path, "step", "one").exists()
    assert f"step {'1' * 64}: node 1 has no solution" in capsys.readouterr().out
