"""What is damaged at rest heals in the same command, which says so, or ends in one message with the remedy."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from pipeline.experiments.reporting import announce
from pipeline.kernel import digest
from tests.workflow.conftest import Project

pytestmark = [pytest.mark.workflow, pytest.mark.slow]

RUN = "resting_study/default"
COMMANDS = {
    "snakemake": ("snakemake", "--cores", "2", "all"),
    "pipeline": ("pipeline", "study=resting_study"),
}


def _one(project: Project, pattern: str) -> Path:
    found = sorted((project.folder / "results").glob(pattern))
    assert found, pattern
    return found[0]


def _write(path: Path, text: str) -> None:
    path.chmod(0o644)
    path.write_text(text)


def _flip(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.chmod(0o644)
    path.write_bytes(content)


def _empty(path: Path) -> None:
    _write(path, "")


def _garble(path: Path) -> None:
    _write(path, "%")


def _cut(path: Path) -> None:
    _write(path, path.read_text()[:99])


def _junk_in_view(project: Project) -> str:
    path = project.folder / "results" / RUN / "resting" / "curve.parquet"
    path.unlink()
    path.write_text("junk")
    return "resting_study/default/resting/curve.parquet changed since it was sealed"


def _future(project: Project) -> str:
    for path in (project.folder / "results" / "receipts").glob("*/*.json"):
        os.utime(path, (2_208_988_800, 2_208_988_800))
    # Something to do, so that Snakemake compares dates.
    _one(project, "receipts/publish/*.json").unlink()
    return "is dated 2040-01-01 00:00 UTC, ahead of the clock: dated anew"


def _folder_in_view(project: Project) -> str:
    path = project.folder / "reports" / RUN / "index.html"
    path.unlink()
    path.mkdir()
    return "index.html changed since it was sealed"


def _of(pattern: str, damage: Callable[[Path], object], told: str) -> Callable[[Project], str]:
    def apply(project: Project) -> str:
        damage(_one(project, pattern))
        return told

    return apply


# Damage -> applies it, and returns what the next command says.
DAMAGE: dict[str, Callable[[Project], str]] = {
    "a byte of a stored table": _of(
        "store/resting/*/curve.parquet", _flip, "curve.parquet changed since it was sealed"
    ),
    "an empty table": _of("store/resting/*/curve.parquet", _empty, "curve.parquet changed"),
    "no trace": _of("store/charge/*/trace*", Path.unlink, "is missing: made again"),
    "no artefact": _of("store/verdicts/*", shutil.rmtree, "is missing: made again"),
    "a garbled list of contents": _of(
        "store/page/*/contents.json", lambda path: _write(path, "%"), "contents.json changed"
    ),
    "an empty list of contents": _of("store/charge/*/contents.json", _empty, "contents.json changed"),
    "junk in a view": _junk_in_view,
    "a folder in a view": _folder_in_view,
    "an empty receipt": _of("receipts/charge/*", _empty, "cannot be read: written anew"),
    "a receipt [1]": _of("receipts/page/*", lambda path: _write(path, "[1]"), "cannot be read: written anew"),
    "a manifest {": _of(f"{RUN}/manifest.json", lambda path: _write(path, "{"), "manifest.json cannot be read"),
    "an edited manifest": _of(
        f"{RUN}/manifest.json",
        lambda path: _write(path, path.read_text().replace('"seed": 2015', '"seed": 7')),
        "manifest.json changed since it was written",
    ),
    "a truncated plan": _of(
        "plan/*", lambda path: _write(path, path.read_text()[:99]), "changed since it was made; made anew"
    ),
    "an edited plan": _of(
        "plan/*",
        lambda path: _write(path, path.read_text().replace('"points": 21', '"points": 11')),
        "changed since it was made; made anew",
    ),
    "receipts of 2040": _future,
}


def _hashes(project: Project) -> dict[str, str]:
    """Return the digests of all that a run makes and shows, but for what says when a page was published."""
    rooms = (project.folder / "results" / "store", project.folder / "results" / RUN, project.folder / "reports" / RUN)
    return {
        path.relative_to(project.folder).as_posix(): digest.of_file(path)
        for room in rooms
        for path in room.rglob("*")
        if path.is_file() and path.name != announce.RUN
    }


@pytest.fixture
def whole(small: Project) -> Iterator[tuple[Project, dict[str, str]]]:
    """The small project, whole before and, whatever happens, after a test; with its digests."""
    keep = small.folder.parent / "keep"
    if not keep.exists():
        # Links stay links.
        subprocess.run(["cp", "-a", small.folder, keep], check=True)
    before = _hashes(small)
    yield small, before
    for room in ("results", "reports"):
        subprocess.run(["rm", "-rf", small.folder / room], check=True)
    subprocess.run(["cp", "-a", keep / "results", keep / "reports", small.folder], check=True)


@pytest.mark.struck
@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("damage", DAMAGE)
def test_damage_heals_in_the_same_command_and_is_said(
    damage: str, command: str, whole: tuple[Project, dict[str, str]]
) -> None:
    project, before = whole
    told = DAMAGE[damage](project)
    printed = project.run(*COMMANDS[command])
    assert told in printed, printed
    assert "Traceback" not in printed
    assert _hashes(project) == before
    # The plan is what its name says, again.
    plan = _one(project, "plan/*.json")
    assert json.loads(plan.read_text())["digest"].startswith(plan.stem)


# Those that strike different files: a lost artefact is not garbled as well.
APART = ("a byte of a stored table", "no trace", "a garbled list of contents", "a folder in a view", "an edited plan")


@pytest.mark.struck
def test_several_damages_at_once_heal_at_once_and_then_nothing_is_to_be_done(
    whole: tuple[Project, dict[str, str]],
) -> None:
    project, before = whole
    told = [DAMAGE[name](project) for name in (*APART, "an empty receipt", "a manifest {")]
    printed = project.snakemake()
    assert [line for line in told if line not in printed] == []
    assert "Traceback" not in printed
    assert _hashes(project) == before
    printed = project.snakemake("-n")
    assert "Nothing to be done" in printed
    assert "made again" not in printed


def test_a_byte_behind_the_same_date_is_found_when_asked_to_verify(
    whole: tuple[Project, dict[str, str]],
) -> None:
    project, before = whole
    victim = _one(project, "store/resting/*/curve.parquet")
    times = victim.stat()
    _flip(victim)
    os.utime(victim, ns=(times.st_atime_ns, times.st_mtime_ns))
    assert "changed since it was sealed" in project.run("pipeline", "study=resting_study", "--verify")
    assert _hashes(project) == before


@pytest.mark.parametrize("content", ["", "{", '"points": 11'])
def test_a_damaged_plan_that_is_named_ends_in_one_message(content: str, whole: tuple[Project, dict[str, str]]) -> None:
    project, before = whole
    plan = _one(project, "plan/*.json")
    text = plan.read_text()
    _write(plan, text.replace('"points": 21', content) if "points" in content else content)
    name = plan.relative_to(project.folder).as_posix()
    printed = project.run("snakemake", "--cores", "2", "all", "--config", f"plan={name}", code=2)
    errors = [line for line in printed.splitlines() if line.startswith("error: ")]
    assert len(errors) == 1
    assert errors[0].startswith(f"error: plan {name}: ")
    assert errors[0].endswith("remove it and make it anew with --config overrides=...")
    assert "Traceback" not in printed
    assert _hashes(project) == before


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize(
    "place", ["results/resting_study", f"reports/{RUN}", "results/store/charge", "results/receipts"]
)
def test_a_link_out_of_results_ends_in_one_message(
    place: str, command: str, whole: tuple[Project, dict[str, str]], tmp_path: Path
) -> None:
    project, _ = whole
    folder = project.folder / place
    subprocess.run(["rm", "-rf", folder], check=True)
    folder.symlink_to(tmp_path)
    printed = project.run(*COMMANDS[command], code=2)
    assert f"error: {place}: a symbolic link (to {tmp_path})" in printed
    assert "remove the link and run again" in printed
    assert "Traceback" not in printed
    assert list(tmp_path.iterdir()) == []
    folder.unlink()


def test_an_unexpected_exception_is_one_line_with_a_log_file_for_snakemake_too(
    whole: tuple[Project, dict[str, str]],
) -> None:
    project, _ = whole
    config = ("all", "--config", "plan=[1,2]")
    printed = project.run("snakemake", "--cores", "2", *config, code=2)
    assert "Traceback" not in printed
    module = project.folder / "src" / "pipeline" / "kernel" / "publish.py"
    text = module.read_text()
    module.write_text(
        text.replace("def own(", "def own(*_):\n    raise RuntimeError('nobody foresaw')\n\n\ndef owned(", 1)
    )
    try:
        for words in COMMANDS.values():
            printed = project.run(*words, code=1)
            assert "Traceback" not in printed
            (line,) = [line for line in printed.splitlines() if line.startswith("error: ")]
            assert line.startswith("error: RuntimeError: nobody foresaw (unexpected; details in results/logs/error-")
            log = project.folder / line.split("details in ")[1].rstrip(")")
            assert "Traceback" in log.read_text()
    finally:
        module.write_text(text)
