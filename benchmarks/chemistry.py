"""What an edge costs the edge driver on shipped batteries, against the common model's: 300 s of Reflex at 90 Hz."""

from __future__ import annotations

from typing import NamedTuple

from benchmarks import common_model, sheets
from benchmarks.peers import engine
from benchmarks.protocol import Figure, Row, compared, interleaved, once
from pipeline.cell.records import Battery, resting_voltage_v
from pipeline.charge.records import Mode
from pipeline.charge.simulate import warm_up

PACKAGES = ("numba",)
SECONDS, WHOLE_S = 300.0, 10800.0
BEYOND = 1.9
"""Voltage limit that no charge meets, over the voltage of the full battery at rest."""
COMMON = "the common model's edge"


class Case(NamedTuple):
    """A charge; times are counted in its edges, or in its steps where it has no edges to speak of."""

    battery: Battery
    mode: Mode
    soc: float
    figure: Figure | None = None
    unit: str = "edges"


def cases() -> dict[str, Case]:
    """Return the charges by name; currents go with capacity."""
    lead, nickel, lithium = (sheets.battery(name) for name in ("lead_acid_12v7ah", "nicd_2s_600mah", "lfp_8ah"))
    pulses = sheets.reflex(SECONDS)

    def scaled(battery: Battery) -> Mode:
        scale = battery.capacity_in_use_ah / lead.capacity_in_use_ah
        return sheets.reflex(SECONDS, limit_v=BEYOND * resting_voltage_v(battery, 0.99, 25.0), scale=scale)

    return {
        "lead-acid": Case(lead, pulses, 0.3, Figure(3.5, "at most")),
        "Ni-Cd": Case(nickel, scaled(nickel), 0.3, Figure(15.0, "at most")),
        "LiFePO4": Case(lithium, scaled(lithium), 0.3),
        "lead-acid, clipped": Case(lead, pulses, 0.95),
        "lead-acid, 3 h from SOC 0.2": Case(lead, sheets.reflex(WHOLE_S), 0.2),
        "lead-acid, CC-CV to SOC 0.99 (a step)": Case(lead, Mode(**sheets.load("modes/cc_cv.yaml")), 0.2, unit="steps"),
    }


def every_case() -> dict[str, Case]:
    """Return the common model's charge and the others."""
    return {COMMON: Case(common_model.battery(), sheets.reflex(SECONDS), 0.3)} | cases()


def rows() -> list[Row]:
    """Return the rows: seconds an edge."""
    compile_s, _ = once(warm_up)
    every = every_case()
    runs = {name: engine.solver(case.battery, case.mode, case.soc, "edge") for name, case in every.items()}
    counts = {name: _counts(case) for name, case in every.items()}
    walls = interleaved(runs, rounds=7)
    each = {
        name: times.scaled(1.0 / counts[name][0 if every[name].unit == "edges" else 1]) for name, times in walls.items()
    }
    made = []
    for name, case in cases().items():
        edges, steps = counts[name]
        note = f"{steps / edges:.2f} steps an edge" if case.unit == "edges" else "time of a step"
        row = compared(
            f"an edge of {name}", COMMON, each[name], each[COMMON], case.figure, "at most",
            note=note, before_s={engine.TITLE: compile_s},
        )  # fmt: skip
        made.append(row)
    return made


def _counts(case: Case) -> list[float]:
    return engine.numbers(engine.whole(case.battery, case.mode, case.soc, "edge")(), ("edges", "steps"))
