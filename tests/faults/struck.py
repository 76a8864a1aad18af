"""Struck at every boundary: a run of instant steps, begun in folders of every kind, in processes forked for it."""

from __future__ import annotations

import json
import os
import shutil
import signal
import sys
import traceback
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from importlib import import_module, metadata
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from pipeline.commands import store as store_command
from pipeline.kernel import digest, lock, planfile, publish, receipts, store
from pipeline.kernel import run as runner
from tests.faults import instant
from tests.faults.boundaries import FULL, HOWS, Boundaries

RESULTS = store.RESULTS


@dataclass
class Tally:
    """What was struck, by kind, and what did not end right."""

    struck: Counter[str] = field(default_factory=Counter)
    right: Counter[str] = field(default_factory=Counter)
    wrong: list[str] = field(default_factory=list)

    def count(self, kind: str, fault: str | None) -> None:
        """Count one case."""
        self.struck[kind] += 1
        if fault is None:
            self.right[kind] += 1
        else:
            self.wrong.append(f"{kind}: {fault}")

    def add(self, other: Tally) -> None:
        """Count what another has counted."""
        self.struck += other.struck
        self.right += other.right
        self.wrong += other.wrong


def command(numbers: int = 50) -> int:
    """Do what a run does, in the order in which Snakemake would; return its exit code."""
    plan = instant.plan(numbers)
    file = planfile.save(plan, RESULTS)
    publish.own(plan, RESULTS)
    with lock.held(RESULTS, print):
        receipts.drop_broken(RESULTS, plan["chunks"], say=print)
        for name, chunk in plan["chunks"].items():
            if not receipts.path_of(RESULTS, chunk["step"], name).exists():
                code = runner.main(["--plan", str(file), "--step", chunk["step"], "--chunk", name])
                if code:
                    return code
    return 0


def _clean() -> int:
    return store_command.main(["clean"])


def _whole() -> None:
    assert command() == 0


def _another() -> None:
    assert command(7) == 0


def _spoil(pattern: str) -> Callable[[], None]:
    def spoil() -> None:
        _whole()
        (path,) = (path for path in Path().glob(pattern) if path.is_file())
        path.chmod(0o644)
        path.write_bytes(b"junk")

    return spoil


def _abandoned() -> None:
    """Leave a whole run, one that is no longer shown, and what a killed job leaves."""
    _another()
    _whole()
    for place in (f"store/first/.{'a' * 64}.abcdefgh.4000000/half", "receipts/first/.x.json.abcdefgh.4000000"):
        path = RESULTS / place
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("half")


# Name -> what is in the folder before, and the command that is struck.
BEFORE: dict[str, tuple[Callable[[], None], Callable[[], int]]] = {
    "nothing": (lambda: None, command),
    "another run": (_another, command),
    "a damaged table": (_spoil("results/store/first/*/numbers.parquet"), command),
    "a damaged list": (_spoil("results/store/second/*/contents.json"), command),
    "a damaged view": (_spoil("reports/instant/default/first/part/text.txt"), command),
    "a damaged manifest": (_spoil("results/instant/default/manifest.json"), command),
    "a damaged receipt": (_spoil("results/receipts/second/*.json"), command),
    "a damaged plan": (_spoil("results/plan/*.json"), command),
    "rubbish to be cleaned": (_abandoned, _clean),
}


def strike_everywhere(work: Path, times: int, cores: int = 2) -> Tally:
    """Kill at every boundary, before, amid and behind it, so many times; then let the disk be full from each on."""
    # What every case would import or ask for anew, forked off with it.
    import_module("pandas")
    import_module("pipeline.__main__")
    versions = {name: metadata.version(name) for name in publish.VERSIONS_OF}
    metadata.version = versions.__getitem__
    publish._commit = lambda: None
    work.mkdir(parents=True)
    expected = _expected(work)
    parts = [(work, name, times, expected) for name in BEFORE]
    # Another process a folder: what it forks is its own.
    with get_context("fork").Pool(cores, maxtasksperchild=1) as pool:
        found = Tally()
        for tally in pool.imap_unordered(_strike, parts, chunksize=1):
            found.add(tally)
    shutil.rmtree(work)
    return found


def _strike(part: tuple[Path, str, int, dict[str, str]]) -> Tally:
    above, name, times, expected = part
    prepare, struck = BEFORE[name]
    work = above / name.replace(" ", "_")
    template = work / "template"
    tally = Tally()
    _fresh(template, None)
    code, told = _child(template, lambda: prepare() or 0, None)
    assert code == 0, told
    kinds = _boundaries(work, template, struck)
    for number, kind in enumerate(kinds, start=1):
        for how in (*HOWS * times, FULL):
            folder = work / "case"
            _fresh(folder, template)
            code, told = _child(folder, struck, Boundaries(folder, number, how))
            label = f"disk full at {kind}" if how == FULL else f"killed at {kind}"
            fault = _fault(folder, template, expected, code, told, how)
            where = f"over {name}, {how} boundary {number} of {len(kinds)}: "
            tally.count(label, fault and where + fault)
    return tally


def _fault(folder: Path, template: Path, expected: dict[str, str], code: int, told: str, how: str) -> str | None:
    """Return what is wrong after a strike and after the same command again, or None."""
    if how == FULL:
        # A link that cannot be made is a copy, what cannot be cleaned stays: then nothing went wrong.
        if code and ("No space left on device" not in told or "Traceback" in told):
            return f"ended with {code} and said {told!r}"
    elif code != -signal.SIGKILL:
        return f"was not killed: {code}, {told}"
    half = list(_half_written(folder, template))
    if half:
        return f"half written under a final name: {half}"
    code, told = _child(folder, lambda: command() or _clean(), None)
    if code:
        return f"the same command ended with {code}: {told}"
    if _hashes(folder) != expected:
        return "other files than those of an uninterrupted run"
    left = [path.name for path in folder.rglob(".*") if path.name not in (lock.RUN, lock.JOBS)]
    return f"left behind: {left}" if left else None


def _half_written(folder: Path, template: Path) -> Iterator[str]:
    """Yield what lies under a final name and is not whole, and was not so before."""
    for path in (folder / "results").rglob("*"):
        relative = path.relative_to(folder)
        if any(part.startswith(".") for part in relative.parts) or "quarantine" in relative.parts:
            continue
        if len(relative.parts) == 4 and relative.parts[1] == "store":
            before = template / relative
            if store.damage(path) is not None and not (before.exists() and store.damage(before) is not None):
                # What is being removed by `clean` goes file by file; its list goes, or nothing names it.
                yield from () if not before.exists() else _being_removed(path, before)
                if not before.exists():
                    yield str(relative)
        elif path.suffix == ".json" and "store" not in relative.parts and path.is_file():
            there = template / relative
            if there.exists() and path.read_bytes() == there.read_bytes():
                continue
            try:
                json.loads(path.read_text())
            except ValueError:
                yield str(relative)


def _being_removed(path: Path, before: Path) -> Iterator[str]:
    """Yield files of an artefact that are neither gone nor as they were."""
    for file in path.rglob("*"):
        if file.is_file() and file.read_bytes() != (before / file.relative_to(path)).read_bytes():
            yield str(file)


def _hashes(folder: Path) -> dict[str, str]:
    """Return the digests of what a run makes and shows."""
    rooms = ("results/store", "results/plan", "results/instant", "reports")
    return {
        path.relative_to(folder).as_posix(): digest.of_file(path)
        for room in rooms
        for path in (folder / room).rglob("*")
        if path.is_file() and not ("plan" in path.parts and path.name not in _plans())
    }


def _plans() -> set[str]:
    plan = instant.plan()
    return {f"{digest.of_value(plan)[:16]}.json"}


def _expected(work: Path) -> dict[str, str]:
    folder = work / "uninterrupted"
    _fresh(folder, None)
    code, told = _child(folder, command, None)
    assert code == 0, told
    return _hashes(folder)


def _boundaries(work: Path, template: Path, struck: Callable[[], int]) -> list[str]:
    """Return the kinds of the boundaries that a command reaches when nothing strikes it."""
    folder, report = work / "counted", work / "boundaries.json"
    _fresh(folder, template)
    code, told = _child(folder, struck, Boundaries(folder), report)
    assert code == 0, told
    found: list[str] = json.loads(report.read_text())
    return found


def _fresh(folder: Path, template: Path | None) -> None:
    if folder.exists():
        shutil.rmtree(folder)
    if template is None:
        folder.mkdir(parents=True)
    else:
        shutil.copytree(template, folder, symlinks=True)


def _child(
    folder: Path, act: Callable[[], Any], boundaries: Boundaries | None, report: Path | None = None
) -> tuple[int, str]:
    """Do something in a process of its own, in a folder; return its exit code, negative for a signal, and its words."""
    said = folder.with_name(f"{folder.name}.said")
    sys.stdout.flush()
    process = os.fork()
    if process == 0:
        code = 99
        try:
            os.chdir(folder)
            descriptor = os.open(said, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
            os.dup2(descriptor, 1)
            os.dup2(descriptor, 2)
            # Whoever has put something else in their place, a test say, is not asked.
            sys.stdout, sys.stderr = (os.fdopen(one, "w", encoding="utf-8", closefd=False) for one in (1, 2))
            if boundaries is not None:
                boundaries.install()
            code = _as_a_command(act)
            if boundaries is not None and report is not None:
                report.write_text(json.dumps(boundaries.reached))
        except BaseException:
            traceback.print_exc()
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(code)
    _, status = os.waitpid(process, 0)
    return os.waitstatus_to_exitcode(status), said.read_text()


def _as_a_command(act: Callable[[], Any]) -> int:
    """Return the exit code that `python -m pipeline` makes of what an act returns or raises."""
    import pipeline.__main__ as program

    program._command = lambda name: lambda words: act()  # type: ignore[assignment]
    return int(program.main([]))
