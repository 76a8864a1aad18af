"""Speed of the averaged driver against the edge driver: an hour of pulses, unclipped and clipped, over frequency.

Run as `PYTHONPATH=src python benchmarks/averaged.py`; the two in turn in every round, compilation outside. A ratio is
that of whole charges, records in and columns out; each round takes the shortest of several.
"""

from __future__ import annotations

import statistics
import time
from pathlib import Path

import yaml

from pipeline.cell.records import Battery
from pipeline.charge.many import Task, simulate_many
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.charge.simulate import BENCH, Charge, simulate, warm_up

CONF = Path(__file__).parents[1] / "conf"
ROUNDS, REPEATS, SECONDS = 5, 7, 3600.0
QUANTITIES = ("charge_in_ah", "energy_in_wh", "end_temperature_c", "energy_balance_residual")


def battery() -> Battery:
    data = yaml.safe_load((CONF / "battery/lead_acid_12v7ah.yaml").read_text())
    data.pop("sources", None)
    return Battery(**data)


def reflex(frequency_hz: float) -> Mode:
    data = yaml.safe_load((CONF / "modes/cv_reflex.yaml").read_text())
    data.pop("sources", None)
    data.pop("max_current_a", None)
    data |= {"frequency_hz": frequency_hz, "stop": {"elapsed_s": SECONDS}, "phases": {"on": data["phases"]["reflex"]}}
    return Mode(**data)


def timed(cell: Battery, mode: Mode, soc: float, driver: str) -> tuple[float, Charge]:
    settings, engine = ChargeSettings(initial_soc=soc, ambient_c=25), EngineSettings(driver=driver)
    begin = time.perf_counter()
    charge = simulate(cell, mode, BENCH, settings, engine)
    return time.perf_counter() - begin, charge


def numbers(charge: Charge) -> dict[str, float]:
    return {row.quantity: row.value or 0.0 for row in charge.summary if row.quantity in QUANTITIES}


def compare(cell: Battery, frequency_hz: float, soc: float) -> float:
    mode, ratios, walls = reflex(frequency_hz), [], []
    for _ in range(ROUNDS):
        edge_s, edge = timed(cell, mode, soc, "edge")
        several = [timed(cell, mode, soc, "averaged") for _ in range(REPEATS)]
        averaged_s, averaged = min(several, key=lambda one: one[0])
        walls.append(averaged_s)
        ratios.append(edge_s / averaged_s)
    expected, found = numbers(edge), numbers(averaged)
    errors = [abs(found[name] - expected[name]) / abs(expected[name]) for name in QUANTITIES[:3]]
    wall_s = statistics.median(walls)
    print(
        f"{frequency_hz:5g} Hz from SOC {soc:g}: {1e3 * wall_s:7.2f} ms, x {statistics.median(ratios):4.0f}"
        f" ({min(ratios):.0f} to {max(ratios):.0f}); Ah {errors[0]:.0e}, Wh {errors[1]:.0e}, T {errors[2]:.0e}, "
        f"first law {abs(found[QUANTITIES[3]]):.0e}"
    )
    return wall_s


def population(cell: Battery) -> None:
    engine, size = EngineSettings(), 64
    settings = [ChargeSettings(initial_soc=0.5 + 0.45 * n / size, ambient_c=25) for n in range(size)]
    tasks = [Task(cell, reflex(90.0), BENCH, one, engine) for one in settings]
    ratios = []
    for _ in range(ROUNDS):
        begin = time.perf_counter()
        for task in tasks:
            simulate(*task)
        middle = time.perf_counter()
        simulate_many(tasks)
        ratios.append((middle - begin) / (time.perf_counter() - middle))
    print(f"{size} charges at once: x {statistics.median(ratios):.2f} ({min(ratios):.2f} to {max(ratios):.2f})")


def main() -> None:
    warm_up()
    cell = battery()
    for soc, name in ((0.3, "unclipped"), (0.9, "clipped")):
        walls = {frequency: compare(cell, frequency, soc) for frequency in (20.0, 90.0, 500.0)}
        print(f"{name}: 500 Hz takes {walls[500.0] / walls[20.0]:.2f} times as long as 20 Hz")
    population(cell)


if __name__ == "__main__":
    main()
