"""A Slurm of one node on this machine's loopback, set up as root and taken down with nothing left running."""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import signal
import socket
import subprocess
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

CONFIGURATION = Path("/etc/slurm/slurm.conf")
"""Where it must lie: steps of a job look nowhere else."""
_OURS = "# Written by tests/slurm/cluster.py for the time of a test; remove it where no test is running.\n"
_NEEDED = ("slurmctld", "slurmd", "munged", "sbatch", "srun", "squeue", "scontrol", "scancel")
_CONFIGURATION = """\
ClusterName=loopback
SlurmctldHost={host}(127.0.0.1)
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
SlurmctldPort={controller}
SlurmdPort={daemon}
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
MpiDefault=none
SwitchType=switch/none
ProctrackType=proctrack/linuxproc
TaskPlugin={task}
JobAcctGatherType=jobacct_gather/linux
JobAcctGatherFrequency=task=1
JobAcctGatherParams=OverMemoryKill
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
SchedulerParameters=sched_interval=2,bf_interval=5
SlurmdParameters=config_overrides
MinJobAge=86400
KillWait=5
ReturnToService=2
NodeName={host} NodeAddr=127.0.0.1 CPUs={cores} RealMemory={memory_mb} State=UNKNOWN
PartitionName=main Nodes={host} Default=YES MaxTime=INFINITE State=UP
"""


class NotHere(Exception):
    """Why no cluster can be set up on this machine; the message says what to do."""


@dataclass
class Cluster:
    """A running cluster; `folder` has its logs and its state."""

    folder: Path
    host: str
    daemons: list[subprocess.Popen[bytes]] = field(default_factory=list)

    def ask(self, *words: str) -> str:
        """Run one of Slurm's commands; return what it printed."""
        done = subprocess.run(words, capture_output=True, text=True, check=False, timeout=60)
        if done.returncode:
            raise RuntimeError(f"{' '.join(words)}: {done.stderr.strip() or done.stdout.strip()}")
        return done.stdout

    def jobs(self) -> dict[int, dict[str, str]]:
        """Return every job since the start: its state, comment (rule and wildcards), node time [s]."""
        found = {}
        for block in self.ask("scontrol", "show", "job", "--oneliner").splitlines():
            words = dict(re.findall(r"(\w+)=(\S*)", block))
            if words.get("JobId", "").isdigit():
                found[int(words["JobId"])] = words
        return found

    def wait_for(self, state: str, rule: str = "", seconds: float = 120.0) -> int:
        """Return the first job of a rule that comes to a state."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            for number, job in self.jobs().items():
                if job["JobState"] == state and job.get("Comment", "").startswith(f"rule_{rule}"):
                    return number
            time.sleep(0.2)
        raise RuntimeError(f"no job of {rule or 'any rule'} came to {state} within {seconds:.0f} s: {self.jobs()}")


def why_not() -> str | None:
    """Return why no cluster can be set up here, with what to do; None where it can."""
    missing = [name for name in _NEEDED if shutil.which(name) is None]
    if missing:
        return f"{', '.join(missing)}: not installed; on Debian: apt-get install slurm-wlm munge"
    if os.geteuid() != 0:
        return "a cluster is set up by root alone: its jobs run as whoever submits them"
    if CONFIGURATION.exists() and not CONFIGURATION.read_text(encoding="utf-8").startswith(_OURS):
        return f"{CONFIGURATION}: of another cluster; this test writes its own there, and touches none of others"
    return None


@contextlib.contextmanager
def running(cores: int = 2, memory_mb: int = 6000, task: str = "task/affinity") -> Iterator[Cluster]:
    """Set up a cluster and take it down, whatever happens.

    Raises
    ------
    NotHere : it cannot be set up here.
    """
    reason = why_not()
    if reason is not None:
        raise NotHere(reason)
    folder = Path(tempfile.mkdtemp(prefix="slurm-test-"))
    cluster = Cluster(folder, socket.gethostname().split(".")[0])
    try:
        _configure(cluster, cores, memory_mb, task)
        _start(cluster)
        yield cluster
    finally:
        _stop(cluster)
        CONFIGURATION.unlink(missing_ok=True)
        shutil.rmtree(folder, ignore_errors=True)


def _configure(cluster: Cluster, cores: int, memory_mb: int, task: str) -> None:
    for name in ("state", "spool"):
        (cluster.folder / name).mkdir()
    key = cluster.folder / "munge.key"
    key.write_bytes(os.urandom(1024))
    key.chmod(0o600)
    # The socket of munged must be reachable, its folder not writable by others.
    cluster.folder.chmod(0o755)
    ports = _free_ports(2)
    text = _CONFIGURATION.format(
        folder=cluster.folder,
        host=cluster.host,
        controller=ports[0],
        daemon=ports[1],
        cores=cores,
        memory_mb=memory_mb,
        task=task,
    )
    CONFIGURATION.parent.mkdir(parents=True, exist_ok=True)
    CONFIGURATION.write_text(_OURS + text, encoding="utf-8")


def _free_ports(count: int) -> list[int]:
    sockets = [socket.socket() for _ in range(count)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    ports = [int(one.getsockname()[1]) for one in sockets]
    for one in sockets:
        one.close()
    return ports


def _start(cluster: Cluster) -> None:
    folder = cluster.folder
    munged = ["munged", "--foreground", "--force", f"--socket={folder}/munge.socket", f"--key-file={folder}/munge.key"]
    munged += [
        f"--pid-file={folder}/munged.pid",
        f"--seed-file={folder}/munged.seed",
        f"--log-file={folder}/munged.log",
    ]
    for words in (munged, ["slurmctld", "-D"], ["slurmd", "-D", "-N", cluster.host]):
        log = (folder / f"{words[0]}.out").open("wb")
        daemon = subprocess.Popen(words, stdout=log, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL)
        cluster.daemons.append(daemon)
        time.sleep(0.5)
    end = time.monotonic() + 60.0
    while time.monotonic() < end:
        with contextlib.suppress(RuntimeError):
            if cluster.ask("sinfo", "-h", "-o", "%T").strip() == "idle":
                return
        time.sleep(0.3)
    logs = "\n".join(_tail(path) for path in sorted(folder.glob("*.out")) + sorted(folder.glob("*.log")))
    raise RuntimeError(f"no node came up within 60 s:\n{logs}")


def _tail(path: Path, lines: int = 8) -> str:
    return f"{path.name}: " + " | ".join(path.read_text(encoding="utf-8", errors="replace").splitlines()[-lines:])


def _stop(cluster: Cluster) -> None:
    with contextlib.suppress(RuntimeError, subprocess.TimeoutExpired):
        numbers = [str(number) for number in cluster.jobs()]
        subprocess.run(["scancel", "--full", *numbers], capture_output=True, timeout=30, check=False)
        _until(lambda: not cluster.ask("squeue", "-h", "-t", "RUNNING,COMPLETING,PENDING").strip(), 20.0)
    for daemon in reversed(cluster.daemons):
        daemon.send_signal(signal.SIGTERM)
        try:
            daemon.wait(timeout=15)
        except subprocess.TimeoutExpired:
            daemon.kill()
            daemon.wait()


def _until(met: object, seconds: float) -> None:
    end = time.monotonic() + seconds
    while time.monotonic() < end and not met():  # type: ignore[operator]
        time.sleep(0.3)


def still_running() -> Sequence[str]:
    """Return the processes of Slurm and munge that there are on this machine."""
    found = subprocess.run(["ps", "-eo", "pid=,args="], capture_output=True, text=True, check=True).stdout
    names = ("slurmctld", "slurmd", "slurmstepd", "munged")
    return [line.strip() for line in found.splitlines() if Path(line.split()[1]).name.rstrip(":") in names]
