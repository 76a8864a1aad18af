"""A plan is remembered as long as nothing that planning reads has changed."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from pipeline.kernel import digest, places, planfile
from tests.fuzz import files

Asked = list[int]


@pytest.fixture
def conf(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of configuration and a cache of their own."""
    folder = tmp_path / "conf"
    (folder / "battery").mkdir(parents=True)
    (folder / "battery" / "own.yaml").write_text("capacity_ah: 7\n")
    monkeypatch.setattr(places, "confs", lambda: (folder,))
    monkeypatch.setenv("CHARGE_PIPELINE_CACHE", str(tmp_path / "cache"))
    return folder


def _plan(made: Asked, question: str = "all", file: Path | None = None) -> dict[str, Any]:
    def make() -> dict[str, Any]:
        made.append(1)
        return {"nodes": len(made), "file": None if file is None else digest.of_file(file)}

    return planfile.remembered([question], make)


def test_it_is_made_once(conf: Path) -> None:
    made: Asked = []
    assert _plan(made) == _plan(made)
    assert len(made) == 1
    _plan(made, "another question")
    assert len(made) == 2


@pytest.mark.parametrize("change", ["value", "new file", "renamed", "gone", "same size and time"])
def test_a_change_of_configuration_makes_it_again(conf: Path, change: str) -> None:
    made: Asked = []
    file = conf / "battery" / "own.yaml"
    _plan(made)
    status = file.stat()
    if change == "new file":
        (conf / "battery" / "other.yaml").write_text("capacity_ah: 7\n")
    elif change == "renamed":
        file.rename(conf / "battery" / "mine.yaml")
    elif change == "gone":
        file.unlink()
    else:
        file.write_text("capacity_ah: 8\n")
    if change == "same size and time":
        os.utime(file, ns=(status.st_atime_ns, status.st_mtime_ns))
    _plan(made)
    assert len(made) == 2


@pytest.mark.parametrize("change", ["another content", "gone"])
def test_a_change_of_a_persons_file_makes_it_again(conf: Path, tmp_path: Path, change: str) -> None:
    made: Asked = []
    file = tmp_path / "weather.csv"
    file.write_text("1")
    _plan(made, file=file)
    _plan(made, file=file)
    assert len(made) == 1
    if change == "gone":
        file.unlink()
        with pytest.raises(FileNotFoundError):
            _plan(made, file=file)
    else:
        file.write_text("2")
        _plan(made, file=file)
    assert len(made) == 2


def test_what_is_damaged_is_made_again(conf: Path) -> None:
    made: Asked = []
    _plan(made)
    (kept,) = (places.cache_root() / "plans").iterdir()
    kept.write_text(kept.read_text().replace('"nodes": 1', '"nodes": 9'))
    assert _plan(made)["nodes"] == 2


OPENED = """
import sys
from pathlib import Path
from pipeline.config.planning import make_plan
from pipeline.kernel import digest, places
opened = set()
def listen(event, given):
    if event == "open" and isinstance(given[0], str) and isinstance(given[1], str) and "r" in given[1]:
        opened.add(str(Path(given[0]).absolute()))
sys.addaudithook(listen)
with digest.recorded() as files:
    make_plan([sys.argv[1:]])
known = [places.PACKAGE, *places.confs(), places.cache_root(), places.LOCK_FILE, sys.prefix, sys.base_prefix]
known += ["/proc", "/usr", "/etc", "/dev"]
print(*(path for path in sorted(opened - set(files)) if not any(Path(path).is_relative_to(one) for one in known)))
"""


@pytest.mark.slow
@pytest.mark.parametrize("door", files.TABLES)
def test_every_file_that_planning_opens_is_known(door: str, tmp_path: Path) -> None:
    """What planning opens lies in the package or in conf/, or its digest is taken: else a change would go unseen."""
    file = tmp_path / "own.csv"
    file.write_text(files.TABLES[door])
    words = [*files.PLACES[door], f"{door}={file}"]
    done = subprocess.run([sys.executable, "-c", OPENED, *words], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, "\n"), done.stderr[-600:]
