"""Speed of the edge driver: ns an edge of 90 Hz Reflex, unclipped and clipped, and a whole charge.

Run as `PYTHONPATH=src python benchmarks/edge.py`; medians of interleaved rounds, compilation outside.
"""

from __future__ import annotations

import statistics
import time
from pathlib import Path

import yaml

from pipeline.cell.records import Battery
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.charge.simulate import BENCH, simulate, warm_up

CONF = Path(__file__).parents[1] / "conf"
ROUNDS = 5
EDGE = EngineSettings(driver="edge")


def load(path: str) -> dict:
    data = yaml.safe_load((CONF / path).read_text())
    data.pop("sources", None)
    # The study's search finds the frequency; here it is the one it finds.
    return data | ({"frequency_hz": 90.0} if "frequency_hz" in data else {})


def cases() -> dict[str, tuple[Mode, float]]:
    sheet = load("modes/cv_reflex.yaml")
    reflex = {key: value for key, value in sheet.items() if key not in ("phases", "max_current_a")}
    reflex["phases"] = {"reflex": sheet["phases"]["reflex"]}
    reflex["stop"] = {"elapsed_s": 300.0}
    whole = sheet | {"stop": {"elapsed_s": 10800.0}}
    whole["phases"] = reflex["phases"]
    whole.pop("max_current_a")
    return {
        "300 s of Reflex, unclipped": (Mode(**reflex), 0.3),
        "300 s of Reflex, clipped": (Mode(**reflex), 0.95),
        "3 h of Reflex from SOC 0.2": (Mode(**whole), 0.2),
        "CC-CV to SOC 0.99": (Mode(**load("modes/cc_cv.yaml")), 0.2),
    }


def main() -> None:
    battery = Battery(**load("battery/lead_acid_12v7ah.yaml"))
    begin = time.perf_counter()
    warm_up()
    print(f"compiled or loaded in {time.perf_counter() - begin:.2f} s")
    walls: dict[str, list[float]] = {}
    counts: dict[str, dict[str, float]] = {}
    for _ in range(ROUNDS):
        for name, (mode, soc) in cases().items():
            begin = time.perf_counter()
            charge = simulate(battery, mode, BENCH, ChargeSettings(initial_soc=soc, ambient_c=25), EDGE)
            walls.setdefault(name, []).append(time.perf_counter() - begin)
            counts[name] = {row.quantity: row.value or 0.0 for row in charge.summary}
    print(f"{'case':30s} {'median s':>9s} {'edges':>9s} {'steps/edge':>10s} {'ns/edge':>9s} {'ns/step':>8s}")
    for name, times in walls.items():
        wall, edges, steps = statistics.median(times), counts[name]["edges"], counts[name]["steps"]
        each = f"{1e9 * wall / edges:9.0f} {1e9 * wall / steps:8.0f}"
        print(f"{name:30s} {wall:9.4f} {edges:9.0f} {steps / edges:10.2f} {each}")


if __name__ == "__main__":
    main()
