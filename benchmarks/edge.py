"""The edge driver on the common model, 60 s of Reflex at 90 Hz, against every peer that can compute it.

Like against like: the compiled driver on what is prepared before, against the solve of a peer that is built and
compiled before. ngspice cannot be prepared, its time is that of its process, whose start takes a few hundredths of a
second. Rows of a whole `simulate`, records in and columns out, stand beside the first two.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from benchmarks import common_model
from benchmarks.common_model import End, Model, Pulses
from benchmarks.peers import diffrax_model, engine, ngspice, pybamm_thevenin, runge_kutta, scipy_model
from benchmarks.protocol import Figure, Row, compared, interleaved, missing, once
from benchmarks.sheets import reflex
from pipeline.charge.simulate import warm_up

SECONDS, INITIAL_SOC = 60.0, 0.3
RTOL, ERROR_ASKED = 1e-6, 1e-6
MEANS = "SOC and voltages of both pairs at the end, relative to the exact solution"
PACKAGES = ("numba", "scipy", "pybamm", "diffrax", "jax", "ngspice")
OURS, WHOLE = "this project", "whole simulate"
NAME = "edge, 60 s of Reflex"
LONGEST_S = 1e-3
FIGURES = {pybamm_thevenin.TITLE: Figure(2000.0), "ngspice": Figure(1500.0)}
PLAIN = Figure(6.0)

Build = Callable[[Model, Pulses], Callable[[], End]]
Runs = dict[str, Callable[[], object]]


def peers() -> dict[str, tuple[Build, bool]]:
    """Return what builds each peer, and whether it is installed."""
    spice = ngspice.installed()
    return {
        pybamm_thevenin.TITLE: (lambda m, p: pybamm_thevenin.build(m, p, RTOL), pybamm_thevenin.installed()),
        "ngspice": (lambda m, p: ngspice.build(m, p, SECONDS), spice),
        "ngspice, steps of 1 ms at most": (lambda m, p: ngspice.build(m, p, LONGEST_S), spice),
        "solve_ivp RK45, each edge": (lambda m, p: scipy_model.build(m, p, "RK45", RTOL), True),
        "solve_ivp LSODA, each edge": (lambda m, p: scipy_model.build(m, p, "LSODA", RTOL), True),
        "diffrax Tsit5, jump_ts": (lambda m, p: diffrax_model.build(m, p, RTOL), diffrax_model.installed()),
    }


def rows() -> list[Row]:
    """Return a row a peer, then the ladder of plain Runge-Kutta loops."""
    battery, mode = common_model.battery(), reflex(SECONDS)
    m, p = common_model.model(battery), common_model.pulses(mode, SECONDS, INITIAL_SOC)
    compile_s, _ = once(warm_up)
    whole = engine.whole(battery, mode, INITIAL_SOC, "edge", SECONDS)
    solver = engine.solver(battery, mode, INITIAL_SOC, "edge", SECONDS)
    whole()
    solver()
    found = engine.end_of(battery, mode, INITIAL_SOC, "edge", SECONDS)
    before = {OURS: compile_s}
    return [
        *_against_peers(m, p, {OURS: solver, WHOLE: whole}, found, before),
        *_against_loops(m, p, solver, found, before),
    ]


def _against_peers(m: Model, p: Pulses, ours: Runs, found: End, before: dict[str, float]) -> list[Row]:
    runs = dict(ours)
    ends, set_up = {}, {}
    every = peers()
    for peer, (build, there) in every.items():
        if there:
            built_s, run = once(lambda build=build: build(m, p))
            first_s, ends[peer] = once(run)
            runs[peer], set_up[peer] = run, built_s + first_s
    walls = interleaved(runs, rounds=3)
    made = []
    for peer in every:
        figure = FIGURES.get(peer)
        if peer not in runs:
            made.append(missing(NAME, peer, figure))
            continue
        stored_is_heat = peer == pybamm_thevenin.TITLE
        expected = common_model.exact(m, p, stored_is_heat)
        theirs = common_model.error(ends[peer], expected)
        warmth = common_model.temperature_error(ends[peer], expected, m.ambient_k)
        heat = "i v of its pairs as heat" if stored_is_heat else "the same heat"
        row = compared(
            NAME, peer, walls[OURS], walls[peer], figure,
            ours_error=common_model.error(found, expected), peer_error=theirs, error_means=MEANS,
            error_asked=theirs if peer.startswith("ngspice") else ERROR_ASKED,
            note=f"peer's rise in temperature, {heat}: {warmth:.0e}", before_s=before | {peer: set_up[peer]},
        )  # fmt: skip
        made.append(row)
        if figure:
            made.append(compared(f"{NAME}, whole simulate", peer, walls[WHOLE], walls[peer]))
    return made


def _against_loops(m: Model, p: Pulses, ours: Callable[[], object], found: End, before: dict[str, float]) -> list[Row]:
    """The loop that counts is the one nearest to our error and not below it; the cheapest within 1e-6 is marked."""
    loops = {steps: runge_kutta.build(m, p, steps) for steps in runge_kutta.LADDER}
    first_s, _ = once(loops[runge_kutta.LADDER[0]])
    walls = interleaved({OURS: ours} | {str(steps): loop for steps, loop in loops.items()}, rounds=7)
    expected = common_model.exact(m, p)
    own = common_model.error(found, expected)
    errors = {steps: common_model.error(loop(), expected) for steps, loop in loops.items()}
    matched = min((steps for steps in loops if errors[steps] >= own), key=lambda steps: errors[steps])
    cheapest = min(steps for steps in loops if errors[steps] <= ERROR_ASKED)
    made = []
    for steps in loops:
        row = compared(
            NAME, f"{runge_kutta.TITLE}, {steps} steps a charging pulse", walls[OURS], walls[str(steps)],
            ours_error=own, peer_error=errors[steps], error_means=MEANS,
            before_s=before | {runge_kutta.TITLE: first_s},
        )  # fmt: skip
        if steps == matched:
            row = replace(row, figure=PLAIN, error_asked=ERROR_ASKED, note="nearest to our error, and not below it")
        elif steps == cheapest:
            row = replace(row, note="cheapest within 1e-6")
        made.append(row)
    return made
