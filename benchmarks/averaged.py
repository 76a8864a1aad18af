"""The averaged driver against the edge driver over an hour of pulses: unclipped and clipped, over frequency.

On the common model, where the figures are asked, and on the shipped lead-acid battery. Times are those of the compiled
drivers; beside them that of a whole `simulate`, records in and columns out. Errors are those of the averaged driver
against the edge driver: charge and energy put in, and the rise in temperature.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from benchmarks import common_model, sheets
from benchmarks.peers import engine
from benchmarks.protocol import Figure, Row, compared, interleaved, once
from pipeline.cell.records import Battery
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.charge.simulate import BENCH, Charge, Task, simulate, simulate_many, warm_up

PACKAGES = ("numba",)
SECONDS, SIZES = 3600.0, (256, 1024)
DRIVERS = ("averaged", "edge")
FREQUENCIES = (20.0, 90.0, 500.0)
ERROR_ASKED = 1e-6
MEANS = "Ah, Wh put in and rise in temperature against the edge driver, relative"
FLAT = Figure(1.5, "at most")


class Case(NamedTuple):
    """A battery, where it starts and what limits it; the figure is that of 90 Hz."""

    name: str
    battery: Battery
    soc: float
    limit_v: float | None
    figure: Figure | None
    flat: Figure | None


def cases() -> list[Case]:
    """Return the cases; 12.35 V holds the common model at its limit for most of every charging pulse."""
    common, lead = common_model.battery(), sheets.battery("lead_acid_12v7ah")
    return [
        Case("common model, unclipped", common, 0.3, None, Figure(150.0), FLAT),
        Case("common model, clipped", common, 0.3, 12.35, Figure(40.0), FLAT),
        Case("lead-acid, unclipped", lead, 0.3, None, None, None),
        Case("lead-acid, clipped", lead, 0.9, None, None, None),
    ]


def rows() -> list[Row]:
    """Return the rows of every case and frequency, of 500 Hz against 20 Hz, and of a population."""
    compile_s, _ = once(warm_up)
    made = []
    for case in cases():
        for frequency in FREQUENCIES:
            made += _against_edge(case, frequency, compile_s)
        slow, fast = (_solver(case, frequency, "averaged") for frequency in (FREQUENCIES[0], FREQUENCIES[-1]))
        walls = interleaved({"fast": fast, "slow": slow}, rounds=7)
        name = f"averaged, {case.name}: {FREQUENCIES[-1]:g} Hz"
        peer = f"the same at {FREQUENCIES[0]:g} Hz"
        made.append(compared(name, peer, walls["fast"], walls["slow"], case.flat, "at most"))
    return [*made, *(row for size in SIZES for row in _populations(size))]


def _solver(case: Case, frequency_hz: float, driver: str) -> Callable[[], object]:
    return engine.solver(case.battery, sheets.reflex(SECONDS, frequency_hz, case.limit_v), case.soc, driver)


def _whole(case: Case, frequency_hz: float, driver: str) -> Callable[[], Charge]:
    return engine.whole(case.battery, sheets.reflex(SECONDS, frequency_hz, case.limit_v), case.soc, driver)


def _against_edge(case: Case, frequency_hz: float, compile_s: float) -> list[Row]:
    runs: dict[str, Callable[[], object]] = {driver: _solver(case, frequency_hz, driver) for driver in DRIVERS}
    wholes = {driver: _whole(case, frequency_hz, driver) for driver in DRIVERS}
    names = ("charge_in_ah", "energy_in_wh", "end_temperature_c", "energy_balance_residual", "time_at_voltage_limit_s")
    found, expected = (engine.numbers(wholes[driver](), names) for driver in DRIVERS)
    of_charge, of_energy = (abs(found[n] / expected[n] - 1.0) for n in range(2))
    of_rise = abs(found[2] - expected[2]) / (expected[2] - 25.0)
    at_90 = frequency_hz == sheets.FREQUENCY_HZ
    walls = interleaved(runs | ({"whole": wholes["averaged"], "whole edge": wholes["edge"]} if at_90 else {}))
    name = f"averaged, {case.name}: 1 h at {frequency_hz:g} Hz"
    row = compared(
        name, "edge driver", walls["averaged"], walls["edge"], case.figure if at_90 else None,
        ours_error=max(of_charge, of_energy, of_rise), peer_error=0.0, error_means=MEANS,
        error_asked=ERROR_ASKED if case.figure else None,
        note=f"Ah {of_charge:.0e}, Wh {of_energy:.0e}, T {of_rise:.0e}, first law {abs(found[3]):.0e}, "
        f"at the limit {found[4] / SECONDS:.0%} of the time",
        before_s={engine.TITLE: compile_s},
    )  # fmt: skip
    if not at_90:
        return [row]
    return [row, compared(f"{name}, whole simulate", "edge, whole simulate", walls["whole"], walls["whole edge"])]


def _populations(size: int) -> Iterator[Row]:
    """Yield a charge of a population, its summary read, against the same by itself; two threads against one.

    The batteries are the common model with its resistances, time constants and heat capacity scattered by a fifth. Two
    threads share what runs until all charges are there; summaries and tables are made afterwards, where they are read.
    """
    random = np.random.default_rng(1)
    batteries = [_scattered(common_model.battery(), random.uniform(0.8, 1.2, 4)) for _ in range(size)]
    for name, limit_v, figure in (("unclipped", None, Figure(2.5)), ("clipped", 12.35, None)):
        mode = sheets.reflex(SECONDS, limit_v=limit_v)
        tasks = [_task(battery, mode) for battery in batteries]
        runs: dict[str, Callable[[], object]] = {
            "together": partial(_read, tasks),
            "one by one": partial(_one_by_one, tasks),
            "two threads": partial(simulate_many, tasks, 2),
            "one thread": partial(simulate_many, tasks, 1),
        }
        runs["together"]()
        one = {run: times.scaled(1.0 / size) for run, times in interleaved(runs).items()}
        title = f"a charge among {size} of an hour, {name}"
        yield compared(title, "by itself", one["together"], one["one by one"], figure)
        yield compared(f"{title}, two threads", "one thread", one["two threads"], one["one thread"], Figure(1.7))


def _read(tasks: Sequence[Task]) -> list[object]:
    return [charge.summary for charge in simulate_many(tasks)]


def _one_by_one(tasks: Sequence[Task]) -> list[object]:
    return [simulate(*task).summary for task in tasks]


def _scattered(battery: Battery, factors: Sequence[float]) -> Battery:
    sheet = battery.model_dump(mode="json", exclude_none=True)
    sheet["series_resistance_ohm"] *= factors[0]
    for pair in sheet["pairs"].values():
        pair["resistance_ohm"] *= factors[1]
        pair["time_constant_s"] *= factors[2]
    sheet["thermal"]["heat_capacity_j_k"] *= factors[3]
    return Battery.model_validate(sheet)


def _task(battery: Battery, mode: Mode) -> Task:
    return Task(battery, mode, BENCH, ChargeSettings(initial_soc=0.3, ambient_c=25.0), EngineSettings())
