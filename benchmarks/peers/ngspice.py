"""ngspice on the common model: a deck generated from the same numbers, run as a process of its own.

SOC and temperature are deviations on capacitors of 1 F, and the tolerances of charge and current are widened: with
the program's own it gives up (`Timestep too small`). The edges of the pulses take 1 us, their charge is kept.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path

from benchmarks.common_model import End, Model, Pulses

PROGRAM = "ngspice"
EDGE_S = 1e-6


def installed() -> bool:
    """Tell whether the program is on the path."""
    return shutil.which(PROGRAM) is not None


def version() -> str:
    """Return the program's version."""
    said = subprocess.run([PROGRAM, "--version"], capture_output=True, text=True, check=True).stdout
    found = re.search(r"ngspice-(\S+)", said)
    return found.group(1) if found else "unknown"


def pulse(current_a: float, start_s: float, length_s: float, period_s: float) -> str:
    """Return a pulse whose edges straddle its ends."""
    start, flat = start_s - 0.5 * EDGE_S, length_s - EDGE_S
    return f"PULSE(0 {current_a:.15g} {start:.15g} {EDGE_S:g} {EDGE_S:g} {flat:.15g} {period_s:.15g})"


def deck(m: Model, p: Pulses, longest_s: float) -> str:
    """Return the deck of a charge; it prints SOC gained, voltages of the pairs and the rise in temperature."""
    r1, r2 = m.fast.resistance_ohm, m.slow.resistance_ohm
    start_v = m.full_v + m.slope_v * (1.0 - p.initial_soc)
    heat = f"i(Vs)*i(Vs)*{m.series_ohm:.15g}+v(a,b)*v(a,b)*{1 / r1:.15g}+v(b,e)*v(b,e)*{1 / r2:.15g}"
    return f"""pulses
Ic 0 n {pulse(p.charge_a, 0.0, p.charge_s, p.period_s)}
Id n 0 {pulse(p.discharge_a, p.charge_s, p.discharge_s, p.period_s)}
R0 n a {m.series_ohm:.15g}
R1 a b {r1:.15g}
C1 a b {m.fast.time_constant_s / r1:.15g}
R2 b e {r2:.15g}
C2 b e {m.slow.time_constant_s / r2:.15g}
Vs e d 0
Bu d 0 V={start_v:.15g}-({m.slope_v:.15g})*v(q)
Bq 0 q I=i(Vs)*{1 / m.capacity_as:.15g}
Cq q 0 1
Bt 0 t I=({heat})*{1 / m.heat_capacity_j_k:.15g}
Ct t 0 1
Rt t 0 {m.heat_capacity_j_k * m.thermal_k_w:.15g}
.options chgtol=1e-6 abstol=1e-6
.control
set numdgt=15
tran {longest_s:.15g} {p.seconds:.15g} 0 {longest_s:.15g} uic
let last = length(time)-1
print v(q)[last] v(a,b)[last] v(b,e)[last] v(t)[last]
quit
.endc
.end
"""


def build(m: Model, p: Pulses, longest_s: float) -> Callable[[], End]:
    """Return the run with steps of at most `longest_s`: starting, reading the deck, solving."""
    text = deck(m, p, longest_s)

    def run() -> End:
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "deck.cir").write_text(text)
            done = subprocess.run([PROGRAM, "-b", "deck.cir"], cwd=folder, check=True, capture_output=True, text=True)
        gained, fast, slow, warm = (float(value) for value in re.findall(r"^v\(.*= (\S+)$", done.stdout, re.M))
        return End(p.initial_soc + gained, fast, slow, m.ambient_k + warm)

    return run
