"""Machine instructions of an edge, by stepping a child process through its driver one instruction at a time (Linux).

`python -m benchmarks instructions` counts for two charges and takes minutes, nearly all of them for the two million
instructions of Python's around the driver; `python -m benchmarks.instructions CASE` is the child.
"""

from __future__ import annotations

import ctypes
import gc
import os
import signal
import sys
from collections.abc import Callable
from typing import Any

from benchmarks import chemistry, results
from benchmarks.peers import engine

_TRACE_ME, _CONTINUE, _STEP = 0, 7, 9
# Charges of 30 and 130 periods of 90 Hz: what the first periods make anew is in both.
BRIEF_S, LONGER_S = 30 / 90.0, 130 / 90.0
WARMING = 40
CASES = (chemistry.COMMON, "lead-acid")
MOST = 5_000_000


def child(case_name: str) -> None:
    """Run charges of two lengths, the driver of each between two stops of this process."""
    case = chemistry.every_case()[case_name]
    runs: list[Callable[[], int]] = []
    for seconds in (BRIEF_S, LONGER_S):
        mode = case.mode.model_copy(update={"stop": case.mode.stop.model_copy(update={"elapsed_s": seconds})})
        runs.append(engine.solver(case.battery, mode, case.soc, "edge", 2.0 * LONGER_S))
    # Python's own work must be the same in both: its bytecode settled, nothing collected.
    gc.disable()
    edges = [[run() for run in runs] for _ in range(WARMING)][-1]
    os.write(3, f"{edges[1] - edges[0]}".encode())
    launch = engine.launch

    def between_stops(*arguments: Any) -> int:
        os.kill(os.getpid(), signal.SIGSTOP)
        status = launch(*arguments)
        os.kill(os.getpid(), signal.SIGSTOP)
        return status

    engine.launch = between_stops
    ctypes.CDLL(None).ptrace(_TRACE_ME, 0, None, None)
    for run in runs:
        run()
    os._exit(0)


def instructions(case_name: str) -> float | None:
    """Return the instructions of an edge, or None where they cannot be counted."""
    if not sys.platform.startswith("linux"):
        return None
    libc = ctypes.CDLL(None, use_errno=True)
    libc.ptrace.argtypes = [ctypes.c_long, ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p]
    read, write = os.pipe()
    process = os.posix_spawn(
        sys.executable,
        [sys.executable, "-m", "benchmarks.instructions", case_name],
        os.environ | {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)},
        file_actions=[(os.POSIX_SPAWN_DUP2, write, 3)],
    )
    os.close(write)
    try:
        counts: list[int] = []
        for _ in range(2):
            if not _stopped(process):
                return None
            counts.append(_steps(libc, process))
            libc.ptrace(_CONTINUE, process, None, None)
        edges = int(os.read(read, 100))
        return (counts[1] - counts[0]) / edges
    finally:
        os.close(read)
        os.kill(process, signal.SIGKILL)
        os.waitpid(process, 0)


def _stopped(process: int) -> bool:
    _, status = os.waitpid(process, 0)
    return os.WIFSTOPPED(status) and os.WSTOPSIG(status) == signal.SIGSTOP


def _steps(libc: ctypes.CDLL, process: int) -> int:
    for count in range(MOST):
        if libc.ptrace(_STEP, process, None, None) != 0:
            return count
        _, status = os.waitpid(process, 0)
        if not os.WIFSTOPPED(status) or os.WSTOPSIG(status) == signal.SIGSTOP:
            return count
    raise RuntimeError(f"more than {MOST} instructions")


def main() -> None:
    """Count, print and write what an edge of the two charges takes."""
    found = []
    for case in CASES:
        count = instructions(case)
        print(f"an edge of {case}: " + ("cannot be counted here" if count is None else f"{count:.0f} instructions"))
        found.append({"case": case, "instructions": count and round(count)} | results.facts(("numba",)))
    results.write("instructions", found)


if __name__ == "__main__":
    child(sys.argv[1])
