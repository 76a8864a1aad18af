"""Profiles are found by name or folder, say what planning takes from them, and a wrong one is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from pipeline.commands import profiles
from pipeline.commands.profiles import DEFAULT, Profile, names, opened
from pipeline.commands.run import swept_plan
from pipeline.errors import UserError
from pipeline.kernel.places import place


def _profile(folder: Path, config: str = "cores: 1\n", sweep: str | None = None) -> str:
    folder.mkdir()
    (folder / "config.yaml").write_text(config, encoding="utf-8")
    if sweep is not None:
        (folder / "sweep.yaml").write_text(sweep, encoding="utf-8")
    return str(folder)


def test_the_shipped_ones_are_found() -> None:
    assert names() == ["default", "slurm"]
    assert opened("default") is DEFAULT


def test_the_default_is_one_of_the_machine_others_are_of_the_workflow(tmp_path: Path) -> None:
    assert DEFAULT.words()[0] == "--profile"
    assert opened(_profile(tmp_path / "mine")).words() == ["--workflow-profile", str(tmp_path / "mine")]


def test_a_profile_says_what_planning_takes(tmp_path: Path) -> None:
    mine = opened(_profile(tmp_path / "mine", "jobs: 7\n", "job_s: 45\n"))
    assert (mine.jobs, mine.job_s) == (7, 45.0)
    assert opened(_profile(tmp_path / "bare")).job_s == 0.0


def test_slurm_asks_for_its_plugin(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(profiles, "find_spec", lambda name: None)
    with pytest.raises(UserError, match="executor slurm is not installed here; make setup-slurm"):
        opened("slurm")
    monkeypatch.setattr(profiles, "find_spec", lambda name: name == "snakemake_executor_plugin_slurm")
    found = opened("slurm")
    assert found == Profile("slurm", place("profiles/slurm"), 100, 30.0)


@pytest.mark.parametrize(
    ("config", "sweep", "told"),
    [
        ("- a\n", None, "no mapping of keys"),
        ("a: [\n", None, "cannot be read"),
        ("cores: 1\n", "jobs_s: 1\n", "jobs_s: unknown; allowed is job_s"),
        ("cores: 1\n", "job_s: -1\n", "seconds from 0 on"),
        ("cores: 1\n", "job_s: true\n", "seconds from 0 on"),
    ],
)
def test_a_wrong_one_is_refused(tmp_path: Path, config: str, sweep: str | None, told: str) -> None:
    with pytest.raises(UserError, match=told):
        opened(_profile(tmp_path / "mine", config, sweep))


def test_an_unknown_one_is_refused_with_the_closest() -> None:
    with pytest.raises(UserError, match=r"--profile slurn: no config\.yaml in .*: slurm"):
        opened("slurn")


def _jobs(plan: dict[str, Any]) -> int:
    return sum(chunk["step"] == "charge" for chunk in plan["chunks"].values())


def test_a_sweep_is_shared_out_as_its_profile_says() -> None:
    words = ["modes.run=[cc_cv]", f"modes.cc_cv.max_current_a={','.join(str(1 + n / 10) for n in range(8))}"]
    short = Profile("mine", Path("mine"), jobs=4)
    assert _jobs(swept_plan(words, "1", short)) == 8
    assert _jobs(swept_plan(words, "1", short._replace(job_s=0.05))) == 2
    assert _jobs(swept_plan([*words, "sweep.job_s=0"], "1", short._replace(job_s=0.05))) == 8
    assert _jobs(swept_plan(words, "1")) == 2
