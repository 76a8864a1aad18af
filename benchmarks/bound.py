"""What bounds the edge driver: what an edge costs, beside what its arithmetic alone would, on this machine.

For each charge: operations an edge and the longest chain of those that wait for one another (`counting`), turned into
times by the latencies and throughputs measured here; then the time it takes. Times are the shortest of many, for a
bound is that of a quiet machine. `python -m benchmarks bound`; the table goes into benchmarks/README.md.
"""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba

from benchmarks import chemistry, results
from benchmarks.common_model import Model, Pulses, model, pulses
from benchmarks.peers import engine
from benchmarks.protocol import once
from pipeline.charge.simulate import warm_up

BEGIN, END = "<!-- bound: begin -->", "<!-- bound: end -->"
CASES = (chemistry.COMMON, "lead-acid", "lead-acid, clipped", "Ni-Cd", "LiFePO4")
LENGTH, TIMES, SHORT_TIMES = 100_000, 100, 400
PERIODS = 2_000
# Short charges: the shortest of many is one that nothing interrupted, and their difference is edges alone.
BRIEF_S, LONGER_S = 5.0, 20.0
# Additions and multiplications a core begins in a cycle, each; a latency of an addition is so many cycles or more.
WIDTH, LEAST_LATENCY = 2, 3


@numba.njit(error_model="numpy")
def adds(count, x, c):
    for _ in range(count):
        x = x + c
    return x


@numba.njit(error_model="numpy")
def multiplies(count, x, c):
    for _ in range(count):
        x = x * c
    return x


@numba.njit(error_model="numpy")
def divides(count, x, c):
    for _ in range(count):
        x = c / x
    return x


@numba.njit(error_model="numpy")
def exponentials(count, x, c):
    for _ in range(count):
        x = math.exp(-x) * c
    return x


@numba.njit(error_model="numpy")
def independent_divides(count, x, c):
    a, b, d, e, f, g, h, i = x, x + 1.0, x + 2.0, x + 3.0, x + 4.0, x + 5.0, x + 6.0, x + 7.0
    for _ in range(count // 8):
        a, b, d, e, f, g, h, i = c / a, c / b, c / d, c / e, c / f, c / g, c / h, c / i
    return a + b + d + e + f + g + h + i


@numba.njit(error_model="numpy")
def bare(periods, x, currents, lengths, decay, pairs, full, slope, r0, per_charge, per_heat, loss):
    """The common model's edges with the least arithmetic: weights and reciprocals made before, all in registers."""
    v1 = v2 = warm = energy_in = energy_out = series = diffusion = lost = 0.0
    highest = 0.0
    for _ in range(periods):
        for n in range(3):
            i, h = currents[n], lengths[n]
            moved = -i * h * per_charge
            e1, e2 = decay[n]
            (r1, tau1, half_c1), (r2, tau2, half_c2) = pairs
            to1, to2 = r1 * i, r2 * i
            after1, after2 = to1 + (v1 - to1) * e1, to2 + (v2 - to2) * e2
            passed1, passed2 = to1 * h + (v1 - after1) * tau1, to2 * h + (v2 - after2) * tau2
            heat = i * (passed1 + passed2) - half_c1 * (after1 * after1 - v1 * v1)
            heat -= half_c2 * (after2 * after2 - v2 * v2)
            own = i * i * r0 * h
            open_v = full + slope * (x + 0.5 * moved) + i * r0
            energy = i * (open_v * h + passed1 + passed2)
            middle = warm + 0.5 * (own + heat - warm * loss * h) * per_heat
            away = middle * loss * h
            warm += (own + heat - away) * per_heat
            highest = max(highest, open_v + max(v1 + v2, after1 + after2))
            if i >= 0.0:
                energy_in += energy
            else:
                energy_out -= energy
            series, diffusion, lost = series + own, diffusion + heat, lost + away
            x, v1, v2 = x + moved, after1, after2
    return x, v1, v2, warm, energy_in - energy_out, series, diffusion, lost, highest


def shortest(run: Callable[[], Any], times: int = TIMES) -> float:
    """Return the shortest time of several runs."""
    run()
    return min(once(run)[0] for _ in range(times))


def latencies() -> dict[str, float]:
    """Return seconds of an operation that waits for the one before, by kind, and of a division that does not."""
    made = {
        "add": shortest(lambda: adds(LENGTH, 1.0, 1e-9)),
        "multiply": shortest(lambda: multiplies(LENGTH, 1.0, 1.0 + 1e-12)),
        "divide": shortest(lambda: divides(LENGTH, 1.1, 1.3)),
        "function": shortest(lambda: exponentials(LENGTH, 1.0, 1.0)),
        "free_divide": shortest(lambda: independent_divides(LENGTH, 1.1, 1.3)),
    }
    return {kind: seconds / LENGTH for kind, seconds in made.items()} | {"compare": 0.0}


def counts(case: str, takes: dict[str, float]) -> dict[str, float]:
    """Return what an edge of a case costs, counted in a process where nothing is compiled."""
    command = [sys.executable, "-m", "benchmarks.counting", case, json.dumps(takes)]
    done = subprocess.run(
        command, cwd=Path(__file__).parents[1], env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
        check=True, capture_output=True, text=True,
    )  # fmt: skip
    found: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    return found


def edge_s(case: chemistry.Case) -> float:
    """Return the seconds of an edge of the driver, from charges of two lengths."""
    ends = []
    for seconds in (BRIEF_S, LONGER_S):
        mode = case.mode.model_copy(update={"stop": case.mode.stop.model_copy(update={"elapsed_s": seconds})})
        solve = engine.solver(case.battery, mode, case.soc, "edge", 2.0 * LONGER_S)
        ends.append((shortest(solve, SHORT_TIMES), solve()))
    (before_s, few), (after_s, many) = ends
    return (after_s - before_s) / (many - few)


def bare_edge_s() -> float:
    """Return the seconds of an edge of the loop with the least arithmetic."""
    case = chemistry.every_case()[chemistry.COMMON]
    m, p = model(case.battery), pulses(case.mode, chemistry.SECONDS, case.soc)
    arguments = bare_arguments(m, p)
    return shortest(lambda: bare(PERIODS, *arguments)) / (3 * PERIODS)


def bare_arguments(m: Model, p: Pulses) -> tuple[Any, ...]:
    """Return the arguments of the bare loop after the number of periods."""
    currents, lengths = zip(*p.segments, strict=True)
    both = (m.fast, m.slow)
    decay = tuple(tuple(math.exp(-length / pair.time_constant_s) for pair in both) for length in lengths)
    pairs = tuple(
        (pair.resistance_ohm, pair.time_constant_s, 0.5 * pair.time_constant_s / pair.resistance_ohm) for pair in both
    )
    return (
        1.0 - p.initial_soc, currents, lengths, decay, pairs, m.full_v, m.slope_v, m.series_ohm, 1.0 / m.capacity_as,
        1.0 / m.heat_capacity_j_k, 1.0 / m.thermal_k_w,
    )  # fmt: skip


def rows() -> list[dict[str, Any]]:
    """Return what bounds an edge of each case [s]."""
    warm_up()
    takes = latencies()
    cycle_s = takes["add"] / LEAST_LATENCY
    every, made = chemistry.every_case(), []
    for name in CASES:
        case = every[name]
        took_s = edge_s(case)
        found = counts(name, takes)
        made.append(
            {
                "case": name,
                "edge_s": took_s,
                "chain_s": found["chain_s"],
                "divisions_s": found["divide"] * takes["free_divide"],
                "issue_s": max(found["add"], found["multiply"]) / WIDTH * cycle_s,
                **{kind: found[kind] for kind in ("add", "multiply", "divide", "compare", "function")},
                "bare_s": bare_edge_s() if name == chemistry.COMMON else None,
            }
        )
    return made


def table(found: list[dict[str, Any]], takes: dict[str, float]) -> str:
    """Return the Markdown table of what bounds an edge."""
    kinds = ("add", "multiply", "divide", "free_divide", "function")
    named = dict(
        zip(kinds, ("addition", "multiplication", "division", "division that waits for none", "exp"), strict=True)
    )
    lines = [
        "Latencies: " + ", ".join(f"{named[kind]} {1e9 * takes[kind]:.2f} ns" for kind in kinds) + ".",
        "",
        "| an edge of | + - | x | / | functions | comparisons | issue | divisions | longest chain | takes | over all |",
        "|---" * 11 + "|",
    ]
    for row in found:
        bounds = [row[key] for key in ("issue_s", "divisions_s", "chain_s")]
        number = " | ".join(f"{row[kind]:.0f}" for kind in ("add", "multiply", "divide", "function", "compare"))
        times = " | ".join(f"{1e9 * bound:.0f} ns" for bound in bounds)
        name = "the common model" if row["case"] == chemistry.COMMON else row["case"]
        lines.append(
            f"| {name} | {number} | {times} | {1e9 * row['edge_s']:.0f} ns | {row['edge_s'] / max(bounds):.1f} x |"
        )
    bare_s = found[0]["bare_s"]
    ratio = found[0]["edge_s"] / bare_s
    return "\n".join(
        [*lines, "", f"The bare loop: {1e9 * bare_s:.0f} ns an edge; the driver takes {ratio:.1f} times that."]
    )


def main() -> None:
    """Measure, print, and write the table."""
    takes, found = latencies(), rows()
    lines = table(found, takes)
    print(lines)
    about = results.facts(("numba",))
    written = [
        {key: results.rounded(value) if isinstance(value, float) else value for key, value in row.items()} | about
        for row in found
    ]
    results.FOLDER.mkdir(exist_ok=True)
    (results.FOLDER / "bound.json").write_text(json.dumps(written, indent=2) + "\n")
    results.METHOD.write_text(results.put(results.METHOD.read_text(), lines, BEGIN, END))


if __name__ == "__main__":
    main()
