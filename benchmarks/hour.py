"""The averaged driver against PyBaMM over the full hour of Reflex at 90 Hz, really run, once; takes some minutes.

Each side has a process of its own, which tells how long its solver took; the parent takes the time of whole
processes, imports and loading of compiled code included. `python -m benchmarks hour`.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

from benchmarks.protocol import Figure, Row, compared, missing, once

SECONDS, INITIAL_SOC, RTOL = 3600.0, 0.3, 1e-6
ERROR_ASKED = 1e-6
PACKAGES = ("numba", "pybamm")
NAME = "averaged, the full hour at 90 Hz"
FIGURE = Figure(100_000.0)
TIMES = 200


def rows() -> list[Row]:
    """Return the row of the solvers and that of the whole processes."""
    from benchmarks import common_model
    from benchmarks.peers import pybamm_thevenin
    from benchmarks.sheets import reflex

    peer = pybamm_thevenin.TITLE
    if not pybamm_thevenin.installed():
        return [missing(NAME, peer, FIGURE)]
    _process("ours")
    walls: list[float] = []
    ours = []
    for _ in range(5):
        whole_s, said = _process("ours")
        walls.append(whole_s)
        ours.append(said)
    theirs_s, theirs = _process("pybamm")
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
    count = len(walls)
    solver = compared(
        NAME, peer, [said["solve_s"] for said in ours], [theirs["solve_s"]] * count, FIGURE,
        note=note, before_s=before, **errors,
    )  # fmt: skip
    whole = compared(f"{NAME}, whole process", peer, walls, [theirs_s] * count, note=note, **errors)
    return [solver, whole]


def _process(side: str) -> tuple[float, dict]:
    command = [sys.executable, "-m", "benchmarks.hour", side]
    root = Path(__file__).parents[1]
    seconds, done = once(lambda: subprocess.run(command, cwd=root, check=True, capture_output=True, text=True))
    return seconds, json.loads(done.stdout.splitlines()[-1])


def _ours() -> dict:
    before_s, (battery, mode, run) = once(_prepared)
    first_s, _ = once(run)
    # The shortest stretch that a clock can tell: many solves, one after the other.
    seconds, _ = once(lambda: [run() for _ in range(TIMES)])
    from benchmarks.peers import engine

    end = engine.end_of(battery, mode, INITIAL_SOC, "averaged", SECONDS)
    return {"solve_s": seconds / TIMES, "before_s": before_s + first_s, "end": end}


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
    seconds, end = once(run)
    return {"solve_s": seconds, "before_s": before_s, "end": end}


if __name__ == "__main__":
    print(json.dumps({"ours": _ours, "pybamm": _pybamm}[sys.argv[1]]()))
