"""The common model run by ngspice, where the program is installed."""

from __future__ import annotations

import subprocess
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pipeline.validation.common import Case, Circuit, Trace
from pipeline.validation.ngspice_deck import COLUMNS, deck

_STEPS = 40_000
_STEPS_A_PERIOD = 200


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
