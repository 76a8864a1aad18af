"""The real commands, struck: killed at random, ended by signals, on full and read-only disks, two at once."""

from __future__ import annotations

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from pipeline.config.naming import run_name
from pipeline.kernel import digest, lock, receipts, store
from tests.faults.struck import Tally
from tests.workflow.conftest import Project, small_project
from tests.workflow.parts import ROOT, copy_parts

STUDY = "resting_study"
PIPELINE = ("pipeline", f"study={STUDY}", "-t", "resting")
SNAKEMAKE = ("snakemake", "--cores", "2", "resting")
NOBODY = 65534
LONGEST_S = 900.0


class Commands:
    """Strikes at commands in copies of the project.

    Arguments
    ---------
    work : an empty folder.
    seed : of the moments of random kills.
    """

    def __init__(self, work: Path, seed: int) -> None:
        self.work = work
        self.random = random.Random(seed)
        self.tally = Tally()
        # A shell's background jobs ignore it, and what they start would too.
        signal.signal(signal.SIGINT, signal.default_int_handler)
        # Readable by others: one of the strikes is another user's.
        for folder in (work, work.parent):
            folder.chmod(0o755)
        self.project = small_project(work / "project")
        self.part = self._uninterrupted(SNAKEMAKE)
        began = time.monotonic()
        self.whole = self._uninterrupted(("snakemake", "--cores", "2", "all"))
        self.took_s = time.monotonic() - began

    def strike(self, kind: str, act: Callable[[], str | None]) -> None:
        """Count a strike, in a folder without results; `act` returns what went wrong."""
        self._forget()
        try:
            fault = act()
        except (AssertionError, OSError, subprocess.SubprocessError) as error:
            fault = f"{type(error).__name__}: {str(error)[-800:]}"
        self.tally.count(kind, fault)
        print(f"  {kind}: {'right' if fault is None else fault}", flush=True)

    def chain(self, most: int) -> int:
        """Kill the command at random moments until it ends by itself, at most so often; return how often."""
        self._forget()
        command = self.random.choice((("snakemake", "--cores", "2", "all"), ("pipeline", f"study={STUDY}")))
        kills = 0
        fault = None
        while kills < most:
            process = self._start(command)
            try:
                process.wait(self.random.uniform(0.1, 1.0) * self.took_s)
                break
            except subprocess.TimeoutExpired:
                kills += 1
            # Every fourth time the jobs outlive the command.
            if kills % 4:
                os.killpg(process.pid, signal.SIGKILL)
            else:
                process.kill()
            process.wait()
            fault = fault or self._half_written()
        told = self._run(command)
        fault = fault or told or self._differs(self.whole)
        for _ in range(max(kills, 1)):
            self.tally.count("random kills of the command, in chains", fault)
        print(f"  chain of {kills} kills: {'right' if fault is None else fault}", flush=True)
        return max(kills, 1)

    def signalled(self, number: signal.Signals, command: Sequence[str]) -> str | None:
        """Send a signal to the command alone, once jobs run; it ends, says no traceback, and the next one finishes."""
        process = self._start(command)
        self._await(lambda: any((self.project.folder / "results/store").glob("*/.*")) or process.poll() is not None)
        process.send_signal(number)
        told = process.communicate(timeout=LONGEST_S)[0]
        if process.returncode == 0 or process.returncode == -signal.SIGKILL:
            return f"ended with {process.returncode}: {told[-500:]}"
        if 'File "' in told.split("Job stats")[-1] and "pipeline/" in told:
            return f"a traceback: {told[-800:]}"
        return self._half_written() or self._run(command) or self._differs(self.part)

    def two_at_once(self) -> str | None:
        """Start another run beside one; the second waits and says so, and both make what each makes alone."""
        first = self._start(PIPELINE)
        self._await((self.project.folder / "results" / lock.RUN).exists)
        second = self._start(("pipeline", f"study={STUDY}", "resting.points=11", "-t", "resting"))
        words = [process.communicate(timeout=LONGEST_S)[0] for process in (first, second)]
        if first.returncode or second.returncode or "waiting until it ends" not in words[1]:
            return f"ended with {first.returncode} and {second.returncode}: {words[1][-500:]}"
        return self._differs(self.part, only=("results/resting_study/default",))

    def full_disk(self) -> str | None:
        """Run on a file system of a few pages, then on a larger one: one message first, then the same files."""
        results = self.project.folder / "results"
        results.mkdir(exist_ok=True)
        subprocess.run(["mount", "-t", "tmpfs", "-o", "size=24k", "tmpfs", str(results)], check=True)
        try:
            told = self._fails(PIPELINE, "No space left on device")
            subprocess.run(["mount", "-o", "remount,size=64m", str(results)], check=True)
            return told or self._half_written() or self._run(PIPELINE) or self._differs(self.part)
        finally:
            subprocess.run(["umount", "-l", str(results)], check=True)

    def read_only(self, command: Sequence[str]) -> str | None:
        """Run over a read-only file system; one message, and the same files once it can be written to."""
        results = self.project.folder / "results"
        results.mkdir(exist_ok=True)
        subprocess.run(["mount", "-t", "tmpfs", "-o", "ro", "tmpfs", str(results)], check=True)
        try:
            told = self._fails(command, "Read-only file system")
        finally:
            subprocess.run(["umount", "-l", str(results)], check=True)
        return told or self._run(command) or self._differs(self.part)

    def not_mine(self, command: Sequence[str]) -> str | None:
        """Run as an ordinary user over results of another."""
        for name in ("results", ".snakemake"):
            (self.project.folder / name).mkdir(exist_ok=True)
        (self.project.folder / ".snakemake").chmod(0o777)
        home = self.work / "home"
        home.mkdir(exist_ok=True)
        home.chmod(0o777)
        as_nobody = ("setpriv", f"--reuid={NOBODY}", f"--regid={NOBODY}", "--clear-groups")
        told = self._fails(command, "Permission denied", before=as_nobody, HOME=str(home))
        shutil.rmtree(self.project.folder / ".snakemake")
        return told or self._run(command) or self._differs(self.part)

    def clock_set_back(self) -> str | None:
        """Let everything made be of tomorrow, then make more of it."""
        told = self._run(PIPELINE)
        tomorrow = time.time() + 86_400
        for path in (self.project.folder / "results").rglob("*"):
            os.utime(path, (tomorrow, tomorrow))
        return told or self._run(("snakemake", "--cores", "2", "all")) or self._differs(self.whole)

    def other_locale(self, command: Sequence[str]) -> str | None:
        """Run without UTF-8, and a run whose name is not ASCII too."""
        posix = {"LC_ALL": "POSIX", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
        told = self._run(command, **posix) or self._differs(self.part)
        named = self._run((*PIPELINE, 'battery.title="Säure"'), **posix)
        folder = self.project.folder / "results" / STUDY / run_name(['battery.title="Säure"'])
        return told or named or (None if folder.is_dir() else "another name of its folder")

    def _fails(self, command: Sequence[str], why: str, before: Sequence[str] = (), **environment: str) -> str | None:
        process = self._start(command, before, **environment)
        told = process.communicate(timeout=LONGEST_S)[0]
        errors = [line for line in told.splitlines() if line.strip().startswith("error: ")]
        if process.returncode not in (1, 2) or not errors or any(why not in line for line in errors):
            return f"ended with {process.returncode}: {told[-800:]}"
        return f"a traceback: {told[-800:]}" if "Traceback" in told else None

    def _run(self, command: Sequence[str], **environment: str) -> str | None:
        """Run a command to its end; return what it said where it failed."""
        process = self._start(command, **environment)
        told = process.communicate(timeout=LONGEST_S)[0]
        return None if process.returncode == 0 else f"ended with {process.returncode}: {told[-800:]}"

    def _start(self, command: Sequence[str], before: Sequence[str] = (), **environment: str) -> subprocess.Popen[str]:
        settings = {"CHARGE_PIPELINE_CACHE": str(ROOT / ".cache"), **os.environ}
        settings |= {"PYTHONPATH": str(self.project.folder / "src"), "PYTHONDONTWRITEBYTECODE": "1", **environment}
        return subprocess.Popen(
            [*before, sys.executable, "-m", *command],
            cwd=self.project.folder,
            env=settings,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            start_new_session=True,
        )

    def _uninterrupted(self, command: Sequence[str]) -> dict[str, str]:
        self._forget()
        told = self._run(command)
        assert told is None, told
        return _hashes(self.project.folder)

    def _differs(self, expected: dict[str, str], only: tuple[str, ...] = ("",)) -> str | None:
        found = _hashes(self.project.folder)
        names = {name for name in found.keys() | expected.keys() if name.startswith(only)}
        differing = sorted(name for name in names if found.get(name) != expected.get(name))
        return f"other files than those of an uninterrupted run: {differing[:3]}" if differing else None

    def _half_written(self) -> str | None:
        """Return what lies under a final name and is not whole."""
        results = self.project.folder / "results"
        folders = [folder for folder in results.glob("store/*/*") if not folder.name.startswith(".")]
        wrong = [fault for folder in folders if (fault := store.damage(folder))]
        for path in (*results.glob("receipts/*/*.json"), *results.glob("plan/*.json"), *results.glob("*/*/manifest*")):
            try:
                if not path.name.startswith("."):
                    json.loads(path.read_text(encoding="utf-8"))
            except ValueError:
                wrong.append(str(path))
        return f"half written under a final name: {wrong}" if wrong else None

    def _await(self, there: Callable[[], bool]) -> None:
        deadline = time.monotonic() + LONGEST_S
        while not there():
            assert time.monotonic() < deadline, "does not come"
            time.sleep(0.01)

    def _forget(self) -> None:
        for name in ("results", "reports", ".snakemake"):
            folder = self.project.folder / name
            if folder.exists():
                store.remove(folder)


def _hashes(folder: Path) -> dict[str, str]:
    """Return the digests of what a run makes and shows, without what tells of versions and times."""
    rooms = ("results/store", f"results/{STUDY}", f"reports/{STUDY}")
    return {
        path.relative_to(folder).as_posix(): digest.of_file(path)
        for room in rooms
        for path in (folder / room).rglob("*")
        if path.is_file() and not path.name.startswith((".", "manifest", "run.js"))
    }


def strike_steps(work: Path, words: Sequence[str], tally: Tally) -> None:
    """Kill one job of each kind of step in mid-computation, make it again, and compute it once more to compare.

    Arguments
    ---------
    words : targets whose plan is taken, every kind of step of it; the small study, or those of the project.
    """
    project = small_project(work / "steps") if tuple(words) == (STUDY,) else _full_project(work / "steps")
    project.run("snakemake", "-n", *words)
    (file,) = (project.folder / "results" / "plan").glob("*.json")
    plan = json.loads(file.read_text(encoding="utf-8"))
    chosen: dict[str, str] = {}
    for name, chunk in plan["chunks"].items():
        # A part of a run is published as the whole of it is.
        if chunk["step"] != "publish" or chunk["part"] == "all":
            chosen.setdefault(chunk["step"], name)
    for name in _behind(plan, chosen.values()):
        chunk = plan["chunks"][name]
        job = _Job(project, file, chunk["step"], name)
        fault = job.killed_amid(chunk) if chosen.get(chunk["step"]) == name else None
        code, told = job.run()
        if code == 0 and chosen.get(chunk["step"]) == name and fault is None:
            code, told = job.run("--again") if chunk["step"] != "publish" else job.run()
        if code:
            fault = f"ended with {code}: {told[-800:]}"
        if chosen.get(chunk["step"]) == name:
            tally.count(f"killed amid {chunk['step']}", fault)
            print(f"  {chunk['step']}: {'right' if fault is None else fault}", flush=True)
        elif fault:
            tally.count("made beside them", fault)
            print(f"  {name}, made beside them: {fault}", flush=True)


class _Job:
    """The command of one job."""

    def __init__(self, project: Project, plan: Path, step: str, chunk: str) -> None:
        self._folder = project.folder
        self._words = [sys.executable, "-m", "pipeline.kernel.run", "--plan", str(plan), "--step", step]
        self._words += ["--chunk", chunk]
        self._settings = {"CHARGE_PIPELINE_CACHE": str(ROOT / ".cache"), **os.environ, "OMP_NUM_THREADS": "1"}
        self._settings["PYTHONPATH"] = str(project.folder / "src")

    def run(self, *more: str) -> tuple[int, str]:
        """Run to the end; return exit code and words."""
        process = self._start(*more)
        told = process.communicate()[0]
        return process.returncode, told

    def killed_amid(self, chunk: dict[str, object]) -> str | None:
        """Kill it while it computes, a moment after it has begun to write; return what went wrong."""
        results = self._folder / "results"
        for pause_s in (0.3, 0.1, 0.0, 0.0, 0.0):
            process = self._start()
            begun = None
            while process.poll() is None and begun is None:
                begun = next(self._begun(results, chunk, process.pid), None)
                time.sleep(0.0005)
            time.sleep(pause_s)
            process.kill()
            process.communicate()
            sealed = receipts.path_of(results, str(chunk["step"]), self._words[-1])
            if process.returncode == -signal.SIGKILL and begun is not None and not sealed.exists():
                return None
            # It was faster, and done but for its end: once more, from the start.
            sealed.unlink(missing_ok=True)
            for key in chunk.get("nodes", ()):  # type: ignore[attr-defined]
                store.remove(store.artefact(results, str(chunk["step"]), key))
        return "was never caught in the middle"

    def _begun(self, results: Path, chunk: dict[str, object], process: int) -> Iterator[Path]:
        if chunk["step"] == "publish":
            yield from (path for path in (self._folder / "reports").glob("*/*/*"))
        else:
            yield from (results / "store" / str(chunk["step"])).glob(f".*-{process}")

    def _start(self, *more: str) -> subprocess.Popen[str]:
        return subprocess.Popen(
            [*self._words, *more],
            cwd=self._folder,
            env=self._settings,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )


def _behind(plan: dict[str, dict[str, dict[str, list[str]]]], names: Iterator[str] | Sequence[str]) -> list[str]:
    """Return chunks and all that they need, in the order of the plan."""
    wanted = set(names)
    for name in reversed(list(plan["chunks"])):
        if name in wanted:
            wanted |= set(plan["chunks"][name]["needs"])
    return [name for name in plan["chunks"] if name in wanted]


def _full_project(folder: Path) -> Project:
    """Copy the project as it is: with charges cut short, figures of some studies have nothing to show."""
    copy_parts(folder)
    return Project(folder)


def strike_commands(work: Path, short: bool, seed: int) -> Tally:
    """Strike at the real commands; the short form takes one of each kind."""
    work.mkdir(parents=True)
    commands = Commands(work, seed)
    pairs = [("python -m pipeline", PIPELINE), ("snakemake", SNAKEMAKE)]
    root = os.geteuid() == 0
    for turn, number in enumerate((signal.SIGINT, signal.SIGTERM)):
        for name, command in pairs[turn : turn + 1] if short else pairs:
            commands.strike(f"{number.name} to {name}", lambda n=number, c=command: commands.signalled(n, c))
    for name, command in pairs[:1] if short else pairs:
        if root:
            commands.strike(f"read-only results, {name}", lambda c=command: commands.read_only(c))
            commands.strike(f"results of another user, {name}", lambda c=command: commands.not_mine(c))
        commands.strike(f"LC_ALL=POSIX, PYTHONUTF8=0, {name}", lambda c=command: commands.other_locale(c))
    if root:
        commands.strike("a file system of 24 KiB", commands.full_disk)
    commands.strike("two different runs at once", commands.two_at_once)
    commands.strike("the clock set back by a day", commands.clock_set_back)
    kills = 0
    while kills < (3 if short else 100):
        kills += commands.chain(min(9, (3 if short else 100) - kills))
    strike_steps(work, (STUDY,) if short else ("all", "validation"), commands.tally)
    return commands.tally
