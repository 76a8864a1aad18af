"""Chaos: how to look at the logistic map in; its orbits, its disorder over r, and their numbers out."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.experiments.frequency.tuning_tables import CHAOS_NUMBERS
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.quantity import Quantity
from pipeline.search.box import ChaosSettings
from pipeline.search.chaos import FULL_CHAOS, arcsine_cumulative, arcsine_entropy, orbit
from pipeline.search.disorder import Disorder, disorder

Array = NDArray[np.float64]


def quantities(measured: Mapping[int, Disorder], orbit: Array) -> list[Quantity]:
    """Return the numbers that describe the map.

    Arguments
    ---------
    measured : number of bins -> disorder over r; the last r is 4.
    orbit : many values at r = 4, shape (n,).
    """
    number = CHAOS_NUMBERS.quantity
    found: list[Quantity] = []
    for bins, found_there in measured.items():
        most = int(np.argmax(found_there.entropy))
        found += [
            number("most_disordered_r_{bins}_bins", found_there.r[most], bins=bins),
            number("most_entropy_{bins}_bins_nats", found_there.entropy[most], bins=bins),
            number("entropy_at_4_{bins}_bins_nats", found_there.entropy[-1], bins=bins),
            number("exact_entropy_at_4_{bins}_bins_nats", arcsine_entropy(bins), bins=bins),
            number("uniform_entropy_{bins}_bins_nats", math.log(bins), bins=bins),
        ]
    any_of_them = next(iter(measured.values()))
    return [
        *found,
        number("most_unstable_r", any_of_them.r[int(np.argmax(any_of_them.lyapunov))]),
        number("lyapunov_at_4_nats", any_of_them.lyapunov[-1]),
        number("mean_at_4", float(np.mean(orbit))),
        number("variance_at_4", float(np.var(orbit))),
        number("distance_to_uniform", distance(orbit, orbit)),
        number("distance_to_arcsine", distance(orbit, arcsine_cumulative(orbit))),
    ]


def distance(values: Array, cumulative: Array) -> float:
    """Return the Kolmogorov-Smirnov distance of values (n,) to a law, given its distribution function at them (n,)."""
    expected = np.sort(cumulative)
    count = len(values)
    above = np.arange(1, count + 1) / count - expected
    below = expected - np.arange(count) / count
    return float(max(above.max(), below.max()))


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Follow the map at r = 4 and over r, and measure its disorder."""
    chosen = ChaosSettings.model_validate(settings["chaos"])
    parameters = np.linspace(chosen.r_low, FULL_CHAOS, chosen.r_points)
    measured = {
        bins: disorder(parameters, bins, chosen.disorder_steps, chosen.transient, chosen.start) for bins in chosen.bins
    }
    long = orbit(chosen.start, chosen.disorder_steps, transient=chosen.transient)
    at_four = orbit(chosen.start, chosen.orbit_steps)
    over_r = orbit(np.full(len(parameters), chosen.start), chosen.bifurcation_steps, parameters, chosen.transient)
    output.write("orbit", _orbit(np.array([FULL_CHAOS]), at_four[:, None]))
    output.write("bifurcation", _orbit(parameters, over_r))
    output.write("disorder", _disorder(measured))
    output.numbers(quantities(measured, long))


def _orbit(parameters: NDArray[np.float64], values: NDArray[np.float64]) -> dict[str, Any]:
    """Return values, shape (steps, parameters), as columns: one parameter after the other."""
    steps = len(values)
    return {
        "r": np.repeat(parameters, steps),
        "step": np.tile(np.arange(steps), len(parameters)),
        "value": values.T.ravel(),
    }


def _disorder(measured: Mapping[int, Disorder]) -> dict[str, Any]:
    return {
        "r": np.concatenate([found.r for found in measured.values()]),
        "bins": np.concatenate([np.full(len(found.r), bins) for bins, found in measured.items()]),
        "entropy_nats": np.concatenate([found.entropy for found in measured.values()]),
        "lyapunov_nats": np.concatenate([found.lyapunov for found in measured.values()]),
    }
