"""The engine against ngspice, where it is installed: a deck generated from the same parameters.

In the deck, SOC and temperature are voltages of their own nodes.
"""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.experiments.validation.common import Case, Circuit, Trace, compare
from pipeline.experiments.validation.records import Found, PeerSettings

BOUNDS = {"voltage": 1e-5, "SOC": 1e-8, "temperature": 1e-6}
_STEPS = 40_000
_STEPS_A_PERIOD = 200
_RISE_S = 1e-9
# Where the first step begins; what ngspice is told for its output decides that too.
_FIRST_S = 1e-6
COLUMNS = ("time", "v(term)", "v(soc)", "v(heat)")
"""What a run writes: time [s], voltage of a cell [V], SOC less that at the start, rise of the temperature [K]."""


def check(settings: Mapping[str, Any]) -> Found:
    """Return how far CC, CC-CV and pulses are apart; the deck has heat as it is here, v^2 / R of a pair."""
    return compare(PeerSettings.model_validate(settings), BOUNDS, charged)


def charged(circuit: Circuit, case: Case, time_s: NDArray[np.float64]) -> Trace:
    """Return a charge at given moments, linear between its steps.

    Raises
    ------
    RuntimeError : ngspice did not run to the end; the message has its last lines.
    """
    longest_s = case.seconds / _STEPS
    if case.frequency_hz > 0.0:
        longest_s = 1.0 / case.frequency_hz / _STEPS_A_PERIOD
    with tempfile.TemporaryDirectory() as folder:
        output, file = Path(folder) / "out.txt", Path(folder) / "deck.cir"
        file.write_text(deck(circuit, case, longest_s, output), encoding="ascii")
        done = subprocess.run(["ngspice", "-b", str(file)], capture_output=True, text=True, check=False, cwd=folder)
        if not output.is_file():
            raise RuntimeError("ngspice: " + " / ".join((done.stdout + done.stderr).splitlines()[-5:]))
        columns = np.loadtxt(output).reshape(-1, len(COLUMNS)).T
    if columns[0, -1] < 0.999999 * case.seconds:
        raise RuntimeError(f"ngspice: ended at {columns[0, -1]:g} s of {case.seconds:g} s")
    voltage, soc, rise = (np.interp(time_s, columns[0], column) for column in columns[1:])
    return Trace(time_s, circuit.cells * voltage, case.initial_soc + soc, case.ambient_c + rise)


def deck(circuit: Circuit, case: Case, longest_s: float, output: Path) -> str:
    """Return a deck that runs a charge and writes its columns.

    Arguments
    ---------
    longest_s : longest step [s].
    output : file for the columns of `COLUMNS`.
    """
    depth = f"({1.0 - case.initial_soc!r}-v(soc))"
    open_v = f"({circuit.open_v[0]!r}+({circuit.open_v[1]!r})*{depth})"
    series_ohm = f"({circuit.series_ohm[0]!r}+({circuit.series_ohm[1]!r})*{depth})"
    nodes = [f"p{n}" for n in range(1, len(circuit.pair_ohm) + 1)]
    over = "+".join(f"v({node})" for node in nodes) or "0"
    # The current is the voltage of a node, so that every source may read it.
    lines = ["* the common model, one cell", *_current(case, circuit.cells, open_v, series_ohm, over)]
    # SOC as a deviation on one farad, not on 3600 Q: the simulator's tolerances are absolute.
    lines += [f"Bsoc 0 soc I=v(cur)/{3600.0 * circuit.capacity_ah!r}", "Csoc soc 0 1 ic=0", "Rsoc soc 0 1e15"]
    for node, ohm, tau_s in zip(nodes, circuit.pair_ohm, circuit.pair_tau_s, strict=True):
        lines += [f"B{node} 0 {node} I=v(cur)", f"R{node} {node} 0 {ohm!r}", f"C{node} {node} 0 {tau_s / ohm!r} ic=0"]
    squares = "".join(f"+v({n})*v({n})/{ohm!r}" for n, ohm in zip(nodes, circuit.pair_ohm, strict=True))
    lines += [
        f"Bheat 0 heat I={series_ohm}*v(cur)*v(cur){squares}",
        f"Cheat heat 0 {circuit.heat_capacity_j_k!r} ic=0",
        f"Rheat heat 0 {circuit.thermal_resistance_k_w!r}",
        f"Bterm term 0 V={open_v}+{over}+{series_ohm}*v(cur)",
        ".options reltol=1e-7 abstol=1e-9 vntol=1e-9 chgtol=1e-9 trtol=1 method=trap",
        ".control",
        "set wr_singlescale",
        "set numdgt=14",
        f"tran {_FIRST_S} {case.seconds!r} 0 {longest_s!r} uic",
        f"wrdata {output} {' '.join(COLUMNS[1:])}",
        "quit",
        ".endc",
        ".end",
    ]
    return "\n".join(lines) + "\n"


def _current(case: Case, cells: int, open_v: str, series_ohm: str, over: str) -> list[str]:
    if case.frequency_hz > 0.0:
        period_s = 1.0 / case.frequency_hz
        width_s = case.share * period_s - _RISE_S
        return [f"Vcur cur 0 PULSE({case.current_a!r} 0 {width_s!r} {_RISE_S} {_RISE_S} "
                f"{period_s * (1.0 - case.share) - _RISE_S!r} {period_s!r})"]  # fmt: skip
    if case.limit_v is None:
        return [f"Vcur cur 0 {case.current_a!r}"]
    held = f"({case.limit_v / cells!r}-{open_v}-({over}))/{series_ohm}"
    return [f"Bcur cur 0 V=min({case.current_a!r},{held})"]
