"""The switched buck converter, 50 ms at 50 kHz and a fixed duty with 20 samples a period, against peers.

The peers are Runge and Kutta's method compiled, solve_ivp (a fiftieth of the time, scaled), and ngspice. Errors are of
the inductor's current at every sample, against Runge and Kutta's method with sixteen times as many steps.
"""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path

import numba
import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.peers import ngspice
from benchmarks.protocol import Figure, Row, compared, interleaved, missing, once
from benchmarks.sheets import load
from pipeline.converter.records import SwitchedStage
from pipeline.converter.steady import from_start, sample_maps, trace_samples
from pipeline.converter.switched import follow, gains, start
from pipeline.converter.topologies import INDUCTOR, LOW, ON, BatteryLoad, buck, maps

PACKAGES = ("numba", "scipy", "ngspice")
PERIODS, SAMPLES, DUTY, BUS_V = 2500, 20, 0.57, 24.0
BATTERY = BatteryLoad(13.2, 0.0287, 0.015, 0.006)
STATE = np.array([1.5, 13.25, 0.02, 1.0])
OURS, SPICE = "this project", "ngspice, steps of 1 us at most"
FINE_SPICE, SCALED = "ngspice, steps of 0.2 us at most", 50
FIGURES = {SPICE: Figure(2000.0)}
ERROR_ASKED, FINE = 1e-4, 16
NAME = "switched buck, 2500 periods, 20 samples each"

Run = Callable[[], np.ndarray]


@numba.njit(error_model="numpy")
def slopes(m, z0, z1, z2, z3):
    return (
        m[0] * z0 + m[1] * z1 + m[2] * z2 + m[3] * z3,
        m[4] * z0 + m[5] * z1 + m[6] * z2 + m[7] * z3,
        m[8] * z0 + m[9] * z1 + m[10] * z2 + m[11] * z3,
        m[12] * z0 + m[13] * z1 + m[14] * z2 + m[15] * z3,
    )


@numba.njit(error_model="numpy")
def runge_kutta(on, off, duty, period_s, samples, inner, state, points):
    z0, z1, z2, z3 = state
    switch = duty * period_s
    for number in range(len(points) - 1):
        points[number, 0], points[number, 1], points[number, 2], points[number, 3] = z0, z1, z2, z3
        begin = (number % samples) * period_s / samples
        end = begin + period_s / samples
        for part in range(2):
            low, high = (begin, min(end, switch)) if part == 0 else (max(begin, switch), end)
            m = on if part == 0 else off
            if high <= low:
                continue
            h = (high - low) / inner
            half, sixth = 0.5 * h, h / 6.0
            for _ in range(inner):
                a0, a1, a2, a3 = slopes(m, z0, z1, z2, z3)
                b0, b1, b2, b3 = slopes(m, z0 + half * a0, z1 + half * a1, z2 + half * a2, z3 + half * a3)
                c0, c1, c2, c3 = slopes(m, z0 + half * b0, z1 + half * b1, z2 + half * b2, z3 + half * b3)
                d0, d1, d2, d3 = slopes(m, z0 + h * c0, z1 + h * c1, z2 + h * c2, z3 + h * c3)
                z0 += sixth * (a0 + 2.0 * (b0 + c0) + d0)
                z1 += sixth * (a1 + 2.0 * (b1 + c1) + d1)
                z2 += sixth * (a2 + 2.0 * (b2 + c2) + d2)
                z3 += sixth * (a3 + 2.0 * (b3 + c3) + d3)
    points[-1, 0], points[-1, 1], points[-1, 2], points[-1, 3] = z0, z1, z2, z3


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


def _error(found: np.ndarray, expected: np.ndarray) -> float:
    count = min(len(found), len(expected))
    return float(np.max(np.abs(found[:count] - expected[:count])))


def rows() -> list[Row]:
    """Return a row a peer, and one of ours under its control, which costs more than a fixed duty."""
    settings = load("converter_parts/usual.yaml")["switched"]
    stage = SwitchedStage(**settings)
    # One resistance for both switches, so that a deck needs a source alone.
    same = {"rectifier": "synchronous", "rectifier_resistance_ohm": stage.buck.on_resistance_ohm}
    buck_stage = stage.buck.model_copy(update=same)
    made, period_s = buck(buck_stage, BUS_V, BATTERY, np.inf), buck_stage.switching_period_s
    kernel = maps(made, period_s, SAMPLES)
    control = gains(buck_stage, BUS_V)
    set_up_s, found = once(lambda: from_start(sample_maps(made, True, DUTY, period_s, SAMPLES)[0]))

    on, off = (tuple(made.generators[place].ravel()) for place in (ON, LOW))

    points = np.empty((PERIODS * SAMPLES + 1, 4))

    def ours() -> np.ndarray:
        trace_samples(found, STATE, points)
        return points[:, INDUCTOR]

    def controlled() -> np.ndarray:
        begun = start(buck_stage, BUS_V, BATTERY, 2.1, 0.02)
        return follow(kernel, control, True, np.full(PERIODS, 2.1), *begun).samples[0]

    def compiled(inner: int) -> Run:
        points = np.empty((PERIODS * SAMPLES + 1, 4))

        def run() -> np.ndarray:
            runge_kutta(on, off, DUTY, period_s, SAMPLES, inner, tuple(STATE), points)
            return points[:, INDUCTOR]

        return run

    spice = ngspice.installed()
    peers: dict[str, tuple[Run, bool]] = {
        SPICE: (lambda: by_ngspice(buck_stage, period_s, 1e-6), spice),
        FINE_SPICE: (lambda: by_ngspice(buck_stage, period_s, 2e-7), spice),
        "Runge-Kutta, numba": (compiled(1), True),
        "solve_ivp RK45, rtol 1e-6": (lambda: by_solve_ivp(made.generators, period_s, PERIODS // SCALED), True),
    }
    first = {OURS: once(ours)[0] + set_up_s}
    ends = {OURS: ours()}
    for peer, (run, there) in peers.items():
        if there:
            first[peer], ends[peer] = once(run)
    controlled()
    expected = compiled(FINE)()
    runs = {OURS: ours, "controlled": controlled} | {peer: run for peer, (run, there) in peers.items() if there}
    walls = interleaved(runs)
    walls["solve_ivp RK45, rtol 1e-6"] = walls["solve_ivp RK45, rtol 1e-6"].scaled(SCALED)
    own, listed = _error(ends[OURS], expected), []
    for peer in peers:
        figure = FIGURES.get(peer)
        if peer not in ends:
            listed.append(missing(NAME, peer, figure))
            continue
        row = compared(
            NAME, peer, walls[OURS], walls[peer], figure, ours_error=own, peer_error=_error(ends[peer], expected),
            error_means="inductor current at every sample [A]", error_asked=ERROR_ASKED,
            before_s={OURS: first[OURS], peer: first[peer]},
            note=f"timed over 1/{SCALED} of the periods" if peer.startswith("solve_ivp") else "",
        )  # fmt: skip
        listed.append(row)
    free = "the same at a fixed duty"
    return [*listed, compared(f"{NAME}, under its control", free, walls["controlled"], walls[OURS], bound="at most")]
