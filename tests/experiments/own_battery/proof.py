"""Made measurements with known cards: how often the 95 % intervals of a fit hold the truth, and what it calls unknown.

    python -m tests.experiments.own_battery.proof --draws 100

A draw is a start card of which every number that might be fitted is off at random, by up to 0.4 of what is plausible
without a measurement, and a noise of its own. What the measurement cannot tell stays off: the intervals of the others
have to allow for that.

Lead-acid, rows a second apart: behind a change of current the fast pair (6 ms) is over before the next row, so that
only the sum of its resistance and the series resistance is seen, and no measurement of the kind tells the two apart
(`test_a_pair_over_before_the_next_row_keeps_its_prior` computes it). The pair keeps its prior, and the series
resistance is told to what that leaves open of it, which is less than its own prior.
"""

from __future__ import annotations

import argparse
import fnmatch
import sys
import time
from collections import Counter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.records import Battery
from pipeline.experiments.own_battery.card import parameters
from pipeline.experiments.own_battery.numbers import with_values
from pipeline.experiments.own_battery.outcome import Fitted
from pipeline.experiments.own_battery.own_fit import fitted
from pipeline.experiments.own_battery.records import Fit
from pipeline.experiments.own_battery.unknowns import unknowns_of
from tests.experiments.own_battery.making import card, charged, made, pulsed, record, steps

Array = NDArray[np.float64]


class Case(NamedTuple):
    """A battery, what is done to it, and what that must tell and cannot tell (patterns of key paths)."""

    name: str
    soc: float
    pairs: int
    told: tuple[str, ...]
    not_told: tuple[str, ...]
    step_v: float


CASES = {
    "lfp_8ah": Case(
        "lfp_8ah", 1.0, 1,
        ("series_resistance_ohm.*", "pairs.slow.*", "open_circuit_voltage_v.value.*", "thermal.*"),
        (), 5.0 / 4096,
    ),
    "lead_acid_12v7ah": Case(
        "lead_acid_12v7ah", 0.3, 2,
        ("series_resistance_ohm.polynomial.0", "acceptance.resistance_ohm", "thermal.*", "side_reaction.current_a"),
        ("pairs.fast.*",), 16.0 / 4096,
    ),
    "nicd_2s_600mah": Case(
        "nicd_2s_600mah", 0.1, 0,
        ("series_resistance_ohm", "thermal.heat_capacity_j_k", "thermal.resistance_k_w", "open_circuit_voltage_v.*"),
        (), 5.0 / 4096,
    ),
}  # fmt: skip


def current_of(case: Case, battery: Battery) -> Array:
    """Return the current of a case's measurement, a row a second."""
    capacity = battery.capacity_ah
    if case.name.startswith("lfp"):
        return pulsed(capacity, 9, 1200)
    if case.name.startswith("lead"):
        pulses = [(0.0, 300), *[(0.3 * capacity, 60), (0.0, 120)] * 5, (-0.2 * capacity, 600), (0.0, 900)]
        charge = charged(battery, 0.32, 0.3 * capacity, 14.4, 5 * 3600)
        return np.concatenate([steps(*pulses), charge, np.zeros(3600)])
    pulses = [(0.0, 300), *[(capacity, 60), (0.0, 120), (2.0 * capacity, 30), (0.0, 120)] * 3]
    return np.concatenate([steps(*pulses), np.full(3300, capacity), np.zeros(2400)])


def fit_of(case: Case) -> Fit:
    """Return how a case is fitted: its structure is known, so that what is tested is the fit alone."""
    side = "with" if card(case.name).side_reaction is not None else "auto"
    return Fit.model_validate(
        {"pairs": [case.pairs], "side_reaction": side, "starts": 1, "folds": 2, "temperature_dependence": "without"}
    )


def draw(case: Case, number: int) -> tuple[Fitted, Battery, dict[str, float]]:
    """Return the fit of one draw, its start card, and the truth by key path."""
    rng = np.random.default_rng(np.random.SeedSequence([2026, number]))
    truth = card(case.name)
    series = made(truth, case.soc, current_of(case, truth), rng, case.step_v)
    model = unknowns_of(truth, [case.soc], (1.0, 1200.0), True, {}, [True])
    values = {one.path: one.start for one in model.unknowns}
    off = {}
    for one in model.unknowns:
        # A start card's tables are the truth's; its scales are multiplied out before the fit.
        if ".value." not in one.path and not one.path.endswith(".scale"):
            away = rng.uniform(-0.4, 0.4) * one.prior
            off[one.path] = one.start * float(np.exp(away)) if one.log else one.start + away
    start = with_values(truth, off)
    one = record(series, start, case.soc)
    return fitted(start, [one], fit_of(case), {}, rng), start, values


class Count(NamedTuple):
    """How often intervals held the truth, by number; how often each was called identified; fits."""

    held: Counter[str]
    identified: Counter[str]
    draws: int
    seconds: float


def count(name: str, draws: int, say: bool = False) -> Count:
    """Fit a case's draws."""
    case = CASES[name]
    begun = time.perf_counter()
    held: Counter[str] = Counter()
    identified: Counter[str] = Counter()
    for number in range(1, draws + 1):
        found, start, truth = draw(case, number)
        for path, _, _, _, _, low, high, known, _ in parameters(found, start):
            identified[path] += known
            held[path] += known and low <= truth[path] <= high
        if say:
            sys.stderr.write(f"{name}: {number} of {draws}, {time.perf_counter() - begun:.0f} s\n")
    return Count(held, identified, draws, time.perf_counter() - begun)


def wrong_flags(name: str, found: Count) -> list[str]:
    """Return the numbers that were called identified, or not, against the case's lists in more than a tenth of fits."""
    case = CASES[name]
    wrong = []
    for path, times in found.identified.items():
        if any(fnmatch.fnmatch(path, one) for one in case.told) and times < 0.9 * found.draws:
            wrong.append(f"{path} identified in {times} of {found.draws}")
        if any(fnmatch.fnmatch(path, one) for one in case.not_told) and times > 0.1 * found.draws:
            wrong.append(f"{path} identified in {times} of {found.draws}, which it cannot be")
    return wrong


def main() -> int:
    """Count every case and print what comes of it; 1 where a bound is broken."""
    parser = argparse.ArgumentParser(description="coverage of the intervals of own-battery fits on made data")
    parser.add_argument("--draws", type=int, default=100)
    parser.add_argument("--cases", nargs="*", default=list(CASES))
    asked = parser.parse_args()
    broken = False
    for name in asked.cases:
        found = count(name, asked.draws, say=True)
        paths = [path for path, times in found.identified.items() if times >= 0.5 * found.draws]
        shares = {path: found.held[path] / found.identified[path] for path in paths}
        whole = sum(found.held[path] for path in paths) / max(sum(found.identified[path] for path in paths), 1)
        low = {path: f"{share:.2f}" for path, share in shares.items() if share < 0.85}
        flags = wrong_flags(name, found)
        never = sorted(path for path, times in found.identified.items() if times < 0.5 * found.draws)
        sys.stdout.write(
            f"{name}: {found.draws} draws, {len(paths)} numbers identified, {found.seconds / found.draws:.1f} s a draw"
            "\n"
        )
        sys.stdout.write(f"  intervals hold the truth in {100 * whole:.1f} % over all; below 85 %: {low or 'none'}\n")
        sys.stdout.write(f"  not identified: {never or 'none'}; flags against the lists: {flags or 'none'}\n")
        broken = broken or bool(low or flags) or not 0.93 <= whole <= 0.97
    return int(broken)


if __name__ == "__main__":
    sys.exit(main())
