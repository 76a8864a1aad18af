"""The averaged driver against PyBaMM over the full hour of Reflex at 90 Hz, really run, once; takes some minutes.

Each side has a process of its own, which tells how long its solver took; the parent takes the time of whole
processes, imports and loading of compiled code included. `python -m benchmarks hour`.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path

from benchmarks.protocol import Figure, Row, Times, compared, missing, once, processor_time

SECONDS, INITIAL_SOC, RTOL = 3600.0, 0.3, 1e-6
ERROR_ASKED = 1e-6
PACKAGES = ("numba", "pybamm")
NAME = "averaged, the full hour at 90 Hz"
FIGURE = Figure(100_000.0)
TIMES, AROUND = 200, 3


def rows() -> list[Row]:
    """Return the row of the solvers and that of the whole processes."""
    from benchmarks import common_model
    from benchmarks.peers import pybamm_thevenin
    from benchmarks.sheets import reflex

    peer = pybamm_thevenin.TITLE
    if not pybamm_thevenin.installed():
        return [missing(NAME, peer, FIGURE)]
    # The first process finds nothing of ours in the system's memory; the others stand around the peer's.
    _process("ours")
    ours = [_process("ours") for _ in range(AROUND)]
    theirs = _process("pybamm")
    ours += [_process("ours") for _ in range(AROUND)]
    battery, mode = common_model.battery(), reflex(SECONDS)
    m, p = common_model.model(battery), common_model.pulses(mode, SECONDS, INITIAL_SOC)
    expected, of_peer = common_model.exact(m, p), common_model.exact(m, p, stored_is_heat=True)
    own, other = common_model.End(*ours[0]["end"]), common_model.End(*theirs["end"])
    errors = {
        "ours_error": common_model.error(own, expected),
        "peer_error": common_model.error(other, of_peer),
        "error_means": "SOC and voltages of both pairs at the end, relative to the exact solution",
        "error_asked": ERROR_ASKED,
    }
    warmth = common_model.temperature_error(own, expected, m.ambient_k)
    peers_warmth = common_model.temperature_error(other, of_peer, m.ambient_k)
    note = f"rise in temperature: ours {warmth:.0e}, peer's by its own heat {peers_warmth:.0e}; peer run once"
    before = {"this project": ours[0]["before_s"], peer: theirs["before_s"]}
    count, of_all = len(ours), ("whole_s", "whole_processor_s")
    solver = compared(
        NAME, peer, _times(ours, "solve_s", "processor_s"), _times([theirs] * count, "solve_s", "processor_s"), FIGURE,
        note=note, before_s=before, **errors,
    )  # fmt: skip
    whole = compared(f"{NAME}, whole process", peer, _times(ours, *of_all), _times([theirs] * count, *of_all), **errors)
    return [solver, whole]


def _times(said: list[dict], wall: str, processor: str) -> Times:
    return Times([one[wall] for one in said], [one[processor] for one in said])


def _process(side: str) -> dict:
    command, before_s = [sys.executable, "-m", "benchmarks.hour", side], processor_time()
    root = Path(__file__).parents[1]
    seconds, done = once(lambda: subprocess.run(command, cwd=root, check=True, capture_output=True, text=True))
    of_process = {"whole_s": seconds, "whole_processor_s": processor_time() - before_s}
    return json.loads(done.stdout.splitlines()[-1]) | of_process


def _ours() -> dict:
    before_s, (battery, mode, run) = once(_prepared)
    first_s, _ = once(run)
    # The shortest stretch that a clock can tell: many solves, one after the other.
    begin = time.process_time()
    seconds, _ = once(lambda: [run() for _ in range(TIMES)])
    processor_s = (time.process_time() - begin) / TIMES
    from benchmarks.peers import engine

    end = engine.end_of(battery, mode, INITIAL_SOC, "averaged", SECONDS)
    return {"solve_s": seconds / TIMES, "processor_s": processor_s, "before_s": before_s + first_s, "end": end}


def _prepared():
    from benchmarks import common_model
    from benchmarks.peers import engine
    from benchmarks.sheets import reflex

    battery, mode = common_model.battery(), reflex(SECONDS)
    return battery, mode, engine.solver(battery, mode, INITIAL_SOC, "averaged", SECONDS)


def _pybamm() -> dict:
    def prepared():
        from benchmarks import common_model
        from benchmarks.peers import pybamm_thevenin
        from benchmarks.sheets import reflex

        pybamm_thevenin.installed()
        battery, mode = common_model.battery(), reflex(SECONDS)
        p = common_model.pulses(mode, SECONDS, INITIAL_SOC)
        return pybamm_thevenin.build(common_model.model(battery), p, RTOL)

    before_s, run = once(prepared)
    begin = time.process_time()
    seconds, end = once(run)
    processor_s = time.process_time() - begin
    return {"solve_s": seconds, "processor_s": processor_s, "before_s": before_s, "end": end}


if __name__ == "__main__":
    print(json.dumps({"ours": _ours, "pybamm": _pybamm}[sys.argv[1]]()))
