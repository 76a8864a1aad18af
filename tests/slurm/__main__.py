"""The pipeline on a Slurm of one node: `make slurm-test`; what each fault ended in is printed, 1 where one ended wrong.

Needs root, Debian's slurm-wlm and munge, and the environment of `make setup-slurm`.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import psutil

from pipeline.commands import new
from pipeline.kernel import store
from tests.slurm.cluster import Cluster, NotHere, running, still_running
from tests.slurm.measured import TABLE, read
from tests.workflow.parts import copy_parts

ROOT = Path(__file__).resolve().parents[2]
# Of this cluster alone: it keeps no accounts, and forgets no job; one looks more often than is polite elsewhere.
PROFILE = """
slurm-no-account: true
slurm-status-command: squeue
slurm-init-seconds-before-status-checks: 2
seconds-between-status-checks: 2
default-resources:
  slurm_partition: main
"""
STUDY = ["study=solar_reflex"]
RUNS = 200
SWEEP = ["-m", "modes.run=[cc_cv]", f"modes.cc_cv.max_current_a={','.join(f'{1 + n / 100:g}' for n in range(RUNS))}"]
# A charge takes 0.015 s by its footprint.
SWEEP += ["sweep.name=many", "sweep.job_s=0.3"]
TROUBLED = """
    import os
    import time

    held = bytearray(int(os.environ.get("TEST_MEMORY_B", "0")))
    held[::4096] = bytes(1) * len(held[::4096])
    time.sleep(float(os.environ.get("TEST_SLEEP_S", "0")))
"""


class Wrong(Exception):
    """What a test found otherwise than it must be."""


def _must(true: object, otherwise: str) -> None:
    if not true:
        raise Wrong(otherwise)


class Project:
    """A copy of what a run needs, in a folder of its own."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        copy_parts(folder)
        with (folder / "profiles" / "slurm" / "config.yaml").open("a", encoding="utf-8") as file:
            file.write(PROFILE)
        self.results = folder / "results"

    def start(self, *words: str, **environment: str) -> subprocess.Popen[str]:
        """Start a command of this project; what it prints goes to `printed-N.txt`."""
        inherited = {key: value for key, value in os.environ.items() if not key.startswith(("SLURM", "SNAKEMAKE"))}
        inherited.setdefault("CHARGE_PIPELINE_CACHE", str(ROOT / ".cache"))
        settings = inherited | {"PYTHONPATH": str(self.folder / "src")} | environment
        number = len(list(self.folder.glob("printed-*.txt")))
        printed = (self.folder / f"printed-{number}.txt").open("w", encoding="utf-8")
        command = [sys.executable, "-m", *words]
        return subprocess.Popen(
            command,
            cwd=self.folder,
            env=settings,
            stdout=printed,
            stderr=subprocess.STDOUT,
            stdin=subprocess.DEVNULL,
            text=True,
        )

    def printed(self) -> str:
        """Return all that its commands printed."""
        return "\n".join(path.read_text(encoding="utf-8") for path in sorted(self.folder.glob("printed-*.txt")))

    def done(self, process: subprocess.Popen[str], code: int = 0, seconds: float = 1500.0) -> str:
        """Wait for a command; return what was printed."""
        found = process.wait(timeout=seconds)
        _must(found == code, f"exit code {found} in place of {code}:\n{self.printed()[-6000:]}")
        return self.printed()

    def artefacts(self) -> dict[str, dict[str, str]]:
        """Return step/key -> (file -> sha256) of the store, the content of every file read."""
        found = {}
        for folder in sorted((self.results / "store").glob("*/[!.]*")):
            _must(store.damage(folder) is None, f"{folder}: {store.damage(folder)}")
            found[f"{folder.parent.name}/{folder.name}"] = store.contents(folder)
        return found

    def receipted(self, step: str) -> dict[Path, tuple[int, int]]:
        """Return the artefacts that a step has receipts of, each with inode and time of what sealed it."""
        found = {}
        for path in (self.results / "receipts" / step).glob("[!.]*.json"):
            for key in json.loads(path.read_text(encoding="utf-8"))["artefacts"]:
                sealed = store.artefact(self.results, step, key) / store.CONTENTS
                found[sealed] = (sealed.stat().st_ino, sealed.stat().st_mtime_ns)
        return found


def _until(met: Callable[[], bool], what: str, seconds: float = 600.0) -> None:
    end = time.monotonic() + seconds
    while not met():
        _must(time.monotonic() < end, f"{what}: not within {seconds:.0f} s")
        time.sleep(0.2)


def _line(*words: object) -> None:
    print(*words, flush=True)


def _same_as_local(cluster: Cluster, folder: Path, local: Path | None) -> Project:
    """A study through Slurm has the artefacts of a run on this machine, byte for byte."""
    before, begun = set(cluster.jobs()), time.monotonic()
    project = Project(folder / "study")
    project.done(project.start("pipeline", "--profile", "slurm", *STUDY))
    took = time.monotonic() - begun
    jobs = len(cluster.jobs()) - len(before)
    if local is None:
        here = Project(folder / "local")
        here.done(here.start("pipeline", *STUDY))
        local = here.folder
        _must(not (local / ".snakemake" / "slurm_logs").exists(), "the local run went to Slurm")
    expected = {
        f"{path.parent.name}/{path.name}": store.contents(path)
        for path in (local / "results" / "store").glob("*/[!.]*")
    }
    made = project.artefacts()
    missing = sorted(made.keys() - expected.keys())
    _must(not missing, f"{len(missing)} artefacts have keys that the local run has not: {missing[:3]}")
    differing = sorted(name for name, files in made.items() if files != expected[name])
    _must(not differing, f"other bytes than the local run: {differing}")
    plans = sum(1 for _ in (project.results / "receipts").glob("*/*.json"))
    _line(f"study: {len(made)} artefacts, bytes as of the local run; {plans} receipts by {jobs} jobs; {took:.0f} s")
    _told_jobs(cluster, set(cluster.jobs()) - before)
    project.done(project.start("pipeline", "--profile", "slurm", *STUDY))
    _must(len(cluster.jobs()) - len(before) == jobs, "a second run submitted jobs although there was nothing to do")
    return project


def _told_jobs(cluster: Cluster, numbers: Iterable[int]) -> None:
    """Tell how many jobs ended in each state, and how long those took that were completed."""
    jobs = [job for number, job in cluster.jobs().items() if number in set(numbers)]
    states = Counter(job["JobState"] for job in jobs)
    took = sorted(_seconds(job["RunTime"]) for job in jobs if job["JobState"] == "COMPLETED")
    _line(f"  jobs: {dict(states)}; shortest {took[0]} s, median {took[len(took) // 2]} s, longest {took[-1]} s")


def _seconds(clock: str) -> int:
    hours, minutes, seconds = clock.split("-")[-1].split(":")
    return 3600 * int(hours) + 60 * int(minutes) + int(seconds)


def _swept(cluster: Cluster, folder: Path) -> Project:
    """A sweep of 200 runs, hit by scancel, a drained node, and a coordinator that is killed."""
    project = Project(folder / "sweep")
    before, begun = set(cluster.jobs()), time.monotonic()
    words = ("pipeline", "--profile", "slurm", *SWEEP)
    first = project.start(*words)

    hit = cluster.wait_for("RUNNING", "charge_battery", 600.0)
    cluster.ask("scancel", str(hit))
    _until(lambda: cluster.jobs()[hit]["JobState"] == "CANCELLED", "the job that was cancelled")
    _line("scancel of a running job: CANCELLED; its charges are made by another job")

    _until(lambda: len(project.receipted("charge")) > 0, "a first receipt of charges")
    cluster.ask("scontrol", "update", f"nodename={cluster.host}", "state=drain", "reason=test")
    begun_then = {number for number, job in cluster.jobs().items() if job["JobState"] != "PENDING"}
    time.sleep(12.0)
    jobs = cluster.jobs()
    new_ones = {number for number, job in jobs.items() if job["JobState"] != "PENDING"} - begun_then
    waiting = sum(job["JobState"] == "PENDING" for job in jobs.values())
    _must(not new_ones and waiting, f"on a drained node jobs began ({new_ones}), or none waited ({waiting})")
    cluster.ask("scontrol", "update", f"nodename={cluster.host}", "state=resume")
    _line(f"drained node: what ran went on, {waiting} jobs waited until it was resumed")

    _until(lambda: len(project.receipted("charge")) >= RUNS // 5, "receipts of a fifth of the charges")
    for process in [*psutil.Process(first.pid).children(recursive=True), psutil.Process(first.pid)]:
        process.send_signal(signal.SIGKILL)
    first.wait()
    kept = project.receipted("charge")
    _line(f"coordinator killed with {len(kept)} of {RUNS} charges in receipts; started again")

    project.done(project.start(*words))
    after = project.receipted("charge")
    again = [path for path, seen in kept.items() if after.get(path) != seen]
    _must(not again, f"{len(again)} artefacts that had a receipt were made again")
    _must(len(after) >= RUNS, f"receipts of {len(after)} charges of {RUNS}")
    project.artefacts()
    import pyarrow.parquet

    table = pyarrow.parquet.read_table(project.results / "solar_reflex" / "sweeps" / "many" / "runs.parquet")
    _must(table.num_rows == RUNS, f"the table has {table.num_rows} rows")
    chunks = sum(1 for _ in (project.results / "receipts" / "charge").glob("*.json"))
    _must(chunks >= 10, f"{chunks} jobs of charges, less than ten")
    took = time.monotonic() - begun
    _line(
        f"sweep: {RUNS} runs in {chunks} chunks of {RUNS // chunks}, {len(set(cluster.jobs()) - before)} jobs in all; "
        f"a row each; nothing lost, nothing made again that had a receipt; {took:.0f} s"
    )
    _told_jobs(cluster, set(cluster.jobs()) - before)
    return project


class Trouble:
    """A study of one step that sleeps, or holds memory, for longer than its job is given."""

    def __init__(self, folder: Path, name: str, resources: str, **environment: str) -> None:
        self.name = name
        self.project = Project(folder / name)
        list(new.write("resting", self.project.folder))
        step = self.project.folder / "src" / "pipeline" / "experiments" / "resting" / "resting.py"
        text = step.read_text(encoding="utf-8")
        mark = '    """Compute the curve and write it."""\n'
        _must(text.count(mark) == 1, "the skeleton of an experiment is another one")
        step.write_text(text.replace(mark, mark + TROUBLED), encoding="utf-8")
        words = ["snakemake", "--workflow-profile", "profiles/slurm", "resting_study"]
        words += ["--set-resources", f"compute_resting:{resources}"]
        self.begun = time.monotonic()
        self.process = self.project.start(*words, **environment)

    def ended(self, cluster: Cluster, code: int) -> tuple[str, list[str]]:
        """Return what was printed, and the states in which the jobs of its step ended."""
        printed = self.project.done(self.process, code, 900.0)
        states = [
            job["JobState"]
            for _, job in sorted(cluster.jobs().items())
            if job["WorkDir"] == str(self.project.folder) and job.get("Comment", "").startswith("rule_compute_resting")
        ]
        return printed, states


def _troubles(folder: Path) -> dict[str, Trouble]:
    return {
        "time": Trouble(folder, "time", "runtime=attempt", TEST_SLEEP_S="95"),
        "fails": Trouble(folder, "fails", "runtime=1", TEST_SLEEP_S="600"),
        "memory": Trouble(
            folder, "memory", "mem_mb=700*attempt", TEST_SLEEP_S="12", TEST_MEMORY_B=str(700 * 1024 * 1024)
        ),
    }


def _troubled(cluster: Cluster, troubles: Mapping[str, Trouble]) -> None:
    _, states = troubles["time"].ended(cluster, 0)
    _must(states == ["TIMEOUT", "COMPLETED"], f"a job past its time: {states}")
    _line(f"a job past its time: {' then '.join(states)}, with twice the time")

    printed, states = troubles["fails"].ended(cluster, 1)
    _must(states == ["TIMEOUT", "TIMEOUT"], f"a job past its time twice: {states}")
    told = [line.strip() for line in printed.splitlines() if "TIMEOUT" in line]
    _must(told, f"the reason is not said:\n{printed[-3000:]}")
    _must("slurm_logs" in printed and "results/logs/resting" in printed, "the failing rule does not name its logs")
    _line(f"past its time twice: failed, and says: {told[-1][:200]}")

    printed, states = troubles["memory"].ended(cluster, 0)
    _must(len(states) == 2 and states[-1] == "COMPLETED", f"a job past its memory: {states}")
    logs = "".join(
        path.read_text() for path in troubles["memory"].project.folder.glob(".snakemake/slurm_logs/**/*.log")
    )
    _must("Exceeded job memory limit" in logs, "the log of the job does not say why it was ended")
    _line(f"a job past its memory: {' then '.join(states)}, with twice the memory; its log: Exceeded job memory limit")
    _line("  enforced by a look each second at what its processes hold (jobacct_gather/linux, OverMemoryKill): a job")
    _line("  that takes and frees more within a second is not seen; cgroups, which no job passes, are not used here")


def _measured(projects: Iterable[Project]) -> None:
    """Compare what the jobs took with the committed table."""
    table = json.loads(TABLE.read_text(encoding="utf-8"))
    over = []
    for project in projects:
        for step, took in read(project.results).items():
            known = table.get(step)
            if known is None:
                over.append(f"{step}: not in the table")
            elif took["memory_mb"] > 1.25 * known["memory_mb"]:
                over.append(f"{step}: {took['memory_mb']:.0f} MB, {known['memory_mb']:.0f} in the table")
    _must(
        not over,
        f"take more than {TABLE.name} says (python -m tests.slurm.measured RESULTS renews it): {'; '.join(over)}",
    )
    _line(f"memory of every step is within 25 % of {TABLE.name}")


@contextmanager
def _workplace(keep: bool) -> Iterator[Path]:
    folder = Path(tempfile.mkdtemp(prefix="slurm-runs-"))
    try:
        yield folder
    finally:
        if keep:
            _line(f"kept: {folder}")
        else:
            store.remove(folder)


def main() -> int:
    """Run all, or the named parts; return 0, 1 where something is otherwise, 2 where no cluster can be had."""
    parser = argparse.ArgumentParser(prog="python -m tests.slurm", description=__doc__)
    parser.add_argument("parts", nargs="*", choices=["study", "sweep", "troubles", []], help="without: all")
    parser.add_argument("--local", type=Path, help="project folder that has the study already; without, it is run here")
    parser.add_argument("--keep", action="store_true", help="leave the folders of the runs")
    options = parser.parse_args()
    parts = options.parts or ["study", "sweep", "troubles"]
    begun = time.monotonic()
    try:
        with _workplace(options.keep) as folder, running(cores=4) as cluster:
            troubles = _troubles(folder) if "troubles" in parts else {}
            projects = []
            if "sweep" in parts:
                projects.append(_swept(cluster, folder))
            if "study" in parts:
                projects.append(_same_as_local(cluster, folder, options.local))
            if troubles:
                _troubled(cluster, troubles)
            if projects:
                _measured(projects)
    except NotHere as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except (Wrong, RuntimeError, subprocess.TimeoutExpired) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    left = still_running()
    if left:
        print(f"error: still running: {left}", file=sys.stderr)
        return 1
    _line(f"all ended as they must, nothing is left running; {time.monotonic() - begun:.0f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
