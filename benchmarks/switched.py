"""The switched buck converter, 50 ms at 50 kHz and a fixed duty with 20 samples a period, against peers.

Run as `PYTHONPATH=src python -m benchmarks.switched`; medians of interleaved rounds, compilation outside. The peers are
Runge and Kutta's method compiled, solve_ivp (a tenth of the time, scaled), and ngspice where it is installed.
"""

from __future__ import annotations

import shutil
import statistics
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numba
import numpy as np
from benchmarks.edge import load
from scipy.integrate import solve_ivp

from pipeline.converter.maps import maps
from pipeline.converter.steady import sample_maps
from pipeline.converter.steady_kernel import trace_samples
from pipeline.converter.switched import follow, gains, start
from pipeline.converter.switched_records import SwitchedStage
from pipeline.converter.topologies import INDUCTOR, LOW, ON, BatteryLoad, buck

ROUNDS = 5
PERIODS, SAMPLES, DUTY, BUS_V = 2500, 20, 0.57, 24.0
BATTERY = BatteryLoad(13.2, 0.0287, 0.015, 0.006)
STATE = np.array([1.5, 13.25, 0.02, 1.0])
FLOORS = {"ngspice, steps of 1 us at most": 2000.0, "Runge-Kutta, compiled": 8.0}

Run = Callable[[], np.ndarray]


@numba.njit
def runge_kutta(on, off, duty, period_s, samples, inner, state, points):
    z, switch = state.copy(), duty * period_s
    for number in range(len(points) - 1):
        points[number, :] = z
        begin = (number % samples) * period_s / samples
        end = begin + period_s / samples
        for part in range(2):
            low, high = (begin, min(end, switch)) if part == 0 else (max(begin, switch), end)
            matrix = on if part == 0 else off
            if high <= low:
                continue
            h = (high - low) / inner
            for _ in range(inner):
                a = matrix @ z
                b = matrix @ (z + 0.5 * h * a)
                c = matrix @ (z + 0.5 * h * b)
                d = matrix @ (z + h * c)
                z += h / 6.0 * (a + 2.0 * b + 2.0 * c + d)
    points[-1, :] = z


def by_solve_ivp(generators: np.ndarray, period_s: float, periods: int) -> np.ndarray:
    z, found = STATE.copy(), [STATE[INDUCTOR]]
    for _ in range(periods):
        for place, begin, end in ((ON, 0.0, DUTY * period_s), (LOW, DUTY * period_s, period_s)):
            grid = period_s / SAMPLES * np.arange(1, SAMPLES + 1)
            grid = np.append(grid[(grid > begin + 1e-12) & (grid < end - 1e-12)], end)
            matrix = generators[place]
            run = solve_ivp(lambda _, z, m=matrix: m @ z, (begin, end), z, rtol=1e-6, atol=1e-9, t_eval=grid)
            found += (run.y[INDUCTOR] if place == LOW else run.y[INDUCTOR, :-1]).tolist()
            z = run.y[:, -1]
    return np.array(found)


def by_ngspice(stage, period_s: float, longest_s: float) -> np.ndarray:
    """Run a deck of the same circuit; sources for the switches, whose resistances are equal in this benchmark."""
    pair_f = BATTERY.pair_time_constant_s / BATTERY.pair_resistance_ohm
    resistance = stage.on_resistance_ohm + stage.inductor_resistance_ohm
    deck = f"""buck
Vs s 0 PULSE(0 {BUS_V} 0 1n 1n {DUTY * period_s - 1e-9:.12g} {period_s:.12g})
Rl s a {resistance}
L1 a n {stage.inductance_h} ic={STATE[0]}
Rc n c {stage.capacitor_resistance_ohm}
C1 c 0 {stage.capacitance_f} ic={STATE[1]}
R0 n b {BATTERY.series_resistance_ohm}
R1 b e {BATTERY.pair_resistance_ohm}
C2 b e {pair_f} ic={STATE[2]}
Ve e 0 {BATTERY.voltage_v}
.control
set filetype=ascii
set wr_singlescale
set numdgt=12
tran {period_s / SAMPLES:.12g} {PERIODS * period_s:.12g} 0 {longest_s:.12g} uic
linearize i(L1)
wrdata out.txt i(L1)
quit
.endc
.end
"""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "deck.cir").write_text(deck)
        subprocess.run(["ngspice", "-b", "deck.cir"], cwd=folder, check=True, capture_output=True)
        return np.loadtxt(Path(folder) / "out.txt")[: PERIODS * SAMPLES + 1, 1]


def measured(run: Run) -> tuple[float, np.ndarray]:
    """Return seconds for one run, over so many that they take 20 ms, and what it found."""
    begin, times = time.perf_counter(), 0
    while time.perf_counter() - begin < 0.02:
        found = run()
        times += 1
    return (time.perf_counter() - begin) / times, found


def main() -> int:
    settings = load("converter_parts/usual.yaml")
    settings.pop("sources")
    stage = SwitchedStage(**settings)
    # One resistance for both switches, so that a deck needs a source alone.
    same = {"rectifier": "synchronous", "rectifier_resistance_ohm": stage.buck.on_resistance_ohm}
    buck_stage = stage.buck.model_copy(update=same)
    made, period_s = buck(buck_stage, BUS_V, BATTERY, np.inf), buck_stage.switching_period_s
    kernel = maps(made, period_s, SAMPLES)
    control = gains(buck_stage, BUS_V)

    begin = time.perf_counter()
    transposed = np.ascontiguousarray(sample_maps(made, True, DUTY, period_s, SAMPLES)[0].transpose(0, 2, 1))
    print(f"maps of a period, once: {1e3 * (time.perf_counter() - begin):.2f} ms")

    def ours() -> np.ndarray:
        points = np.empty((PERIODS * SAMPLES + 1, 4))
        trace_samples(transposed, STATE, points)
        return points[:, INDUCTOR]

    def controlled() -> np.ndarray:
        begun = start(buck_stage, BUS_V, BATTERY, 2.1, 0.02)
        return follow(kernel, control, True, np.full(PERIODS, 2.1), *begun).samples[0]

    def compiled(inner: int) -> Run:
        def run() -> np.ndarray:
            points = np.empty((PERIODS * SAMPLES + 1, 4))
            runge_kutta(made.generators[ON], made.generators[LOW], DUTY, period_s, SAMPLES, inner, STATE, points)
            return points[:, INDUCTOR]

        return run

    peers: dict[str, tuple[Run, float]] = {
        "ours, under its control": (controlled, 1.0),
        "Runge-Kutta, compiled": (compiled(1), 1.0),
        "solve_ivp RK45, rtol 1e-6": (lambda: by_solve_ivp(made.generators, period_s, PERIODS // 50), 50.0),
    }
    if shutil.which("ngspice"):
        for longest in (1e-6, 2e-7):
            name = f"ngspice, steps of {1e6 * longest:g} us at most"
            peers[name] = (lambda longest=longest: by_ngspice(buck_stage, period_s, longest), 1.0)
    ours()
    for run, _ in list(peers.values())[:2]:
        run()
    times: dict[str, list[float]] = {}
    found: dict[str, np.ndarray] = {}
    for _ in range(ROUNDS):
        own, found["ours"] = measured(ours)
        times.setdefault("ours", []).append(own)
        for name, (run, factor) in peers.items():
            took, found[name] = measured(run)
            times.setdefault(name, []).append(took * factor)
    print(f"{'':32s} {'ms':>10s} {'ratio':>9s} {'range':>17s} {'error A':>9s}")
    failed = False
    for name, walls in times.items():
        ratios = [wall / own for wall, own in zip(walls, times["ours"], strict=True)]
        count = min(len(found[name]), len(found["ours"]))
        error = float(np.max(np.abs(found[name][:count] - found["ours"][:count])))
        shown = "" if name.startswith("ours") else f"{error:9.1e}"
        ratio, spread = statistics.median(ratios), f"{min(ratios):.3g} - {max(ratios):.3g}"
        print(f"{name:32s} {1e3 * statistics.median(walls):10.3f} {ratio:9.1f} {spread:>17s} {shown:>9s}")
        failed |= ratio < FLOORS.get(name, 0.0) / 2.0
    if not shutil.which("ngspice"):
        print(f"{'ngspice':32s} {'not installed':>10s}")
    return int(failed)


if __name__ == "__main__":
    raise SystemExit(main())
