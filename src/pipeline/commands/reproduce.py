"""`python -m pipeline reproduce`: makes everything anew in a fresh folder and holds it against what is expected."""

from __future__ import annotations

import argparse
import json
import os
import platform
import shlex
import shutil
import stat
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from pipeline.commands import Parser, typed
from pipeline.commands import expected as expectation
from pipeline.commands.expected import Comparison, Recorded
from pipeline.commands.run import cores
from pipeline.config.naming import run_name
from pipeline.errors import UserError
from pipeline.kernel import places
from pipeline.kernel.store import write_text

FOLDER = Path("reproducibility")
MOST = 40
"""Faults that are told one by one."""
MADE = ("results", "reports", FOLDER.name)
OTHERWISE = {"PYTHONHASHSEED": "7", "TZ": "Asia/Tokyo", "LC_ALL": "C"}
"""Conditions of a run that must not show in an artefact, other than where it was recorded."""


def main(arguments: Sequence[str]) -> int:
    """Make everything anew and compare; return 0 where all is as expected, else 1."""
    choices = _parser().parse_args(arguments)
    file: Path = choices.expected or FOLDER / f"{_name(choices.overrides)}.json"
    if choices.renew:
        asked = {"overrides": choices.overrides, "cores": choices.cores or "2"}
        found, took = _made(choices, asked, {})
        told = {"version": expectation.VERSION, "machine": machine(choices.generic), **asked, "runs": found.runs}
        write_text(file, expectation.text_of(told))
        print(f"{file}: recorded {_counted(found)}{took}")
        return 0
    expected = expectation.load(file)
    if choices.overrides and list(choices.overrides) != expected["overrides"]:
        raise UserError(f"{file}: was recorded for {' '.join(expected['overrides']) or 'all'}; give these, or --renew")
    asked = {"overrides": expected["overrides"], "cores": choices.cores or other_cores(str(expected["cores"]))}
    found, took = _made(choices, asked, OTHERWISE)
    print(f"compared {_counted(found)} with {file}{took}")
    return _tell(expected, found, machine(choices.generic))


def _parser() -> Parser:
    parser = Parser(
        prog=typed("reproduce"),
        description="Runs the studies cold in a fresh folder, with another number of cores, hash seed, time zone, "
        "locale and umask, and compares with what is expected: bytes where the machine is the recorded one, else "
        "numbers within what their tables declare, and found values and verdicts.",
    )
    parser.add_argument("overrides", nargs="*", metavar="key=value", help="another run than all studies, study=NAME")
    parser.add_argument("--renew", action="store_true", help="record what is expected instead of comparing")
    parser.add_argument("--expected", type=Path, help="file of what is expected (reproducibility/expected.json)")
    parser.add_argument("--generic", action="store_true", help="play another CPU: one without special instructions")
    parser.add_argument("-c", "--cores", type=cores, help="cores of the run (2 to record, one more to compare)")
    parser.add_argument("--folder", type=Path, help="make it there, and keep it; must not be there yet")
    parser.add_argument("--results", type=Path, help="take this results folder as it is, run nothing")
    return parser


def _name(overrides: Sequence[str]) -> str:
    return run_name([word.removeprefix("study=") for word in overrides]) if overrides else "expected"


def other_cores(recorded: str) -> str:
    """Return another number of cores than a run was recorded with."""
    return str(int(recorded) + 1) if recorded.isdecimal() else "1"


def _made(choices: argparse.Namespace, asked: Mapping[str, Any], conditions: Mapping[str, str]) -> tuple[Recorded, str]:
    """Make what is asked for and read what came of it; the time it took besides, in words."""
    if choices.results is not None:
        return Recorded.of(choices.results), ""
    begin = time.monotonic()
    with _fresh(choices.folder) as folder:
        copied(places.PROJECT, folder)
        run_cold(folder, asked, {**conditions, **(generic() if choices.generic else {})}, bool(conditions))
        took = time.monotonic() - begin
        return Recorded.of(folder / "results"), f", made in {took:.0f} s"


@contextmanager
def _fresh(kept: Path | None) -> Iterator[Path]:
    """Yield a folder that is not there yet; it goes again unless it is to be kept."""
    if kept is not None:
        if kept.exists():
            raise UserError(f"--folder {kept}: is there already; give a name that is not")
        yield kept.absolute()
        return
    base = Path(tempfile.mkdtemp(prefix="charge pipeline "))
    try:
        yield base / "project"
    finally:
        for path in [base, *base.rglob("*")]:
            if path.is_dir() and not path.is_symlink():
                path.chmod(stat.S_IRWXU)
        shutil.rmtree(base)


def copied(project: Path, folder: Path) -> None:
    """Copy a project as it is, without what its runs made and what is hidden."""
    if not (project / "Snakefile").is_file():
        raise UserError(f"{project}: no Snakefile there, so no project; `charge-pipeline init FOLDER` makes one")

    def left_out(place: str, names: list[str]) -> set[str]:
        own = {name for name in names if name in MADE or name.startswith(".")} if Path(place) == project else set()
        return own | ({"__pycache__"} & set(names))

    shutil.copytree(project, folder, ignore=left_out)


def run_cold(folder: Path, asked: Mapping[str, Any], conditions: Mapping[str, str], otherwise: bool) -> None:
    """Run Snakemake in a folder, with kernels compiled there and settings of its own.

    Arguments
    ---------
    asked : `overrides` and `cores`.
    conditions : of the environment.
    otherwise : whether files are made for one's own eyes only.

    Raises
    ------
    UserError : it did not end well; its own words stand above.
    """
    own = {"PYTHONPATH": str(folder / "src"), "CHARGE_PIPELINE_CACHE": str(folder / ".cache")}
    command = [sys.executable, "-m", "snakemake", "--cores", str(asked["cores"]), "all"]
    if asked["overrides"]:
        command += ["--config", f"overrides={shlex.join(asked['overrides'])}"]
    told = " ".join(f"{name}={value}" for name, value in conditions.items())
    print(f"a cold run in {folder}: {told} {shlex.join(command)}", flush=True)
    before = os.umask(0o077) if otherwise else None
    try:
        done = subprocess.run(command, cwd=folder, env={**os.environ, **own, **conditions}, check=False)
    finally:
        if before is not None:
            os.umask(before)
    if done.returncode != 0:
        raise UserError(f"the cold run in {folder} ended with code {done.returncode}; keep it with --folder")


def generic() -> dict[str, str]:
    """Return the environment in which this machine computes as one without special instructions would."""
    played = {
        "NUMBA_CPU_NAME": "generic",
        "NPY_DISABLE_CPU_FEATURES": " ".join(expectation.numpy_features(dispatched=True)),
    }
    if platform.machine() in ("x86_64", "AMD64"):
        played |= {"OPENBLAS_CORETYPE": "Prescott", "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA"}
    return played


def machine(played: bool) -> dict[str, str]:
    """Return the fingerprint of this machine, or of the other one that it plays."""
    if not played:
        return expectation.fingerprint()
    code = "import json; from pipeline.commands.expected import fingerprint; print(json.dumps(fingerprint()))"
    environment = {**os.environ, **generic(), "PYTHONPATH": str(places.PACKAGE.parent)}
    told = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    return dict(json.loads(told.stdout))


def _tell(expected: Mapping[str, Any], found: Recorded, here: Mapping[str, str]) -> int:
    """Print in which way was compared, how far, and what differs; return the exit code."""
    recorded = expected["machine"]
    other = [name for name in sorted(recorded.keys() | here.keys()) if recorded.get(name) != here.get(name)]
    comparison = expectation.compared(expected["runs"], found, bytes_too=not other)
    if other:
        print("by value, since this is another machine than the recorded one:")
        for name in other:
            print(f"  {name}: {here.get(name, 'none')}; recorded: {recorded.get(name, 'none')}")
    else:
        print("byte by byte: this machine is the recorded one")
    for fault in comparison.faults[:MOST]:
        print(f"differs   {fault}")
    if len(comparison.faults) > MOST:
        print(f"and {len(comparison.faults) - MOST} more")
    print(_summed(comparison))
    return 1 if comparison.faults else 0


def _summed(comparison: Comparison) -> str:
    counts = ", ".join(f"{count} {kind}" for kind, count in comparison.counts.items())
    share, place = comparison.largest
    largest = f"largest difference let pass: {share:.2g} of {place}" if share else "no number differs"
    return f"{counts} compared, {len(comparison.faults)} differ; {largest}"


def _counted(found: Recorded) -> str:
    count = sum(len(run["sha256"]) for run in found.runs.values())
    return f"{count} artefacts of {len(found.runs)} runs"
