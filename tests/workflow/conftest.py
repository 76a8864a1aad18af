"""A copy of the project with charges of minutes, in which Snakemake really runs."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
import yaml

from pipeline.commands import new
from tests.workflow.parts import ROOT, copy_parts

FIGURES = ("panel_curves", "figure_16_battery_temperature", "energy_by_loss_path")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Leave to `make test-slow` what runs a whole study; the rest runs seven jobs of a second each."""
    for item in items:
        if "project" in getattr(item, "fixturenames", ()):
            item.add_marker(pytest.mark.slow)


@dataclass(frozen=True)
class Project:
    """A project folder and the commands a person types in it."""

    folder: Path

    def run(self, *words: str, code: int = 0, **environment: str) -> str:
        """Run a command with the project's own sources; return what it printed."""
        inherited = {key: value for key, value in os.environ.items() if not key.startswith(("PYTEST", "SNAKEMAKE"))}
        # Compiled kernels lie by the digest of their sources: what is the same here need not be compiled again.
        inherited.setdefault("CHARGE_PIPELINE_CACHE", str(ROOT / ".cache"))
        settings = inherited | {"PYTHONPATH": str(self.folder / "src")} | environment
        done = subprocess.run(
            [sys.executable, "-m", *words],
            cwd=self.folder,
            env=settings,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            stdin=subprocess.DEVNULL,
        )
        assert done.returncode == code, done.stdout
        return done.stdout

    def snakemake(self, *words: str, overrides: str = "", code: int = 0) -> str:
        """Run Snakemake as the README says."""
        config = ["--config", f"overrides={overrides}"] if overrides else []
        return self.run("snakemake", "--cores", "2", *(words or ("all",)), *config, code=code)

    def planned(self, overrides: str = "") -> Counter[str]:
        """Return how many jobs of each rule a dry run announces."""
        return rules(self.snakemake("-n", "all", overrides=overrides))

    def edit(self, file: str, old: str, new: str) -> None:
        """Replace a text that stands once in a file."""
        path = self.folder / file
        text = path.read_text()
        assert text.count(old) == 1, f"{old!r} stands {text.count(old)} times in {file}"
        path.write_text(text.replace(old, new))


def rules(printed: str) -> Counter[str]:
    """Return rule -> number of jobs from Snakemake's table of jobs."""
    if "Nothing to be done" in printed:
        return Counter()
    table = printed.split("Job stats:")[1].split("total")[0]
    found = {name: int(count) for name, count in re.findall(r"^(\w+)\s+(\d+)$", table, re.MULTILINE)}
    return Counter({name: count for name, count in found.items() if name not in ("all", "job")})


def copy_project(folder: Path) -> Project:
    """Copy what a run needs; one study, two modes, three figures, and every charge stopped after a few minutes."""
    copy_parts(folder)
    for mode in (folder / "conf" / "modes").glob("*.yaml"):
        mode.write_text(re.sub(r"elapsed_s: [\d.]+", "elapsed_s: 100", mode.read_text()))
    for other in (folder / "conf" / "study").glob("*.yaml"):
        if other.stem != "solar_reflex":
            other.unlink()
    study = folder / "conf" / "study" / "solar_reflex.yaml"
    study.write_text(re.sub(r"samples: \d+", "samples: 1", study.read_text()).replace("cv_pulse, ", ""))
    figures = folder / "conf" / "report" / "solar_reflex.yaml"
    cards = yaml.safe_load(figures.read_text())
    figures.write_text(yaml.safe_dump({name: cards[name] for name in FIGURES}, sort_keys=False))
    return Project(folder)


def small_project(folder: Path) -> Project:
    """Copy what a run needs, and one study of seven jobs of a second each, `resting_study`."""
    copy_parts(folder)
    for other in (folder / "conf" / "study").glob("*.yaml"):
        other.unlink()
    list(new.write("resting", folder))
    study = folder / "conf" / "study" / "resting_study.yaml"
    study.write_text(study.read_text().replace("  apart: true\n", ""))
    mode = folder / "conf" / "modes" / "cc_cv.yaml"
    mode.write_text(re.sub(r"elapsed_s: [\d.]+", "elapsed_s: 100", mode.read_text()))
    return Project(folder)


@pytest.fixture(scope="session")
def small(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Project]:
    """A small copy of the project in which everything has been made once."""
    made = small_project(tmp_path_factory.mktemp("small") / "project")
    made.snakemake()
    yield made
    subprocess.run(["chmod", "-R", "u+w", str(made.folder)], check=True)


@pytest.fixture(scope="session")
def project(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Project]:
    """A copy of the project in which everything has been made once."""
    made = copy_project(tmp_path_factory.mktemp("copy") / "project")
    made.snakemake()
    yield made
    subprocess.run(["chmod", "-R", "u+w", str(made.folder)], check=True)


@pytest.fixture
def restored(project: Project) -> Iterator[Project]:
    """The same copy; its sources and configuration are put back afterwards."""
    keep = {
        path: path.read_bytes()
        for part in ("src", "conf")
        for path in (project.folder / part).rglob("*.*")
        if path.is_file() and path.suffix in (".py", ".yaml")
    }
    yield project
    for path, content in keep.items():
        if path.read_bytes() != content:
            path.write_bytes(content)
