"""The variants of a function study as the paper's control loop, in numbers."""

from __future__ import annotations

from typing import cast

import numpy as np

from pipeline.quantity import Quantity
from pipeline.search.algorithms.cuckoo import Settings
from pipeline.search.function_names import OF_A_LOOP, OF_THE_GAIN
from pipeline.search.function_records import FunctionStudy
from pipeline.search.levy import BLOCK, draws
from pipeline.search.stability import is_ringing, is_stable, steady_state_error, step_poles
from pipeline.search.streams import generators

_GENERATIONS = 420


def quantities(study: FunctionStudy, seed: int) -> list[Quantity]:
    """Return how the loop of each variant behaves if its random gain stood still at its median size.

    Arguments
    ---------
    study : as configured; searches that are no cuckoo search are left out.
    seed : root of the random numbers that the gain is measured from.
    """
    every = study.searches(1.0)
    searches = {name: cast(Settings, every[name]) for name in study.loops()}
    if study.plain not in searches:
        return []
    gains = _gains(searches[study.plain], study.dimensions, seed)
    median = float(np.median(np.abs(gains)))
    values = {"kp_median": median, "kp_negative_share": float(np.mean(gains < 0.0))}
    found = [Quantity(name, values[name], "1", text) for name, text in OF_THE_GAIN.items()]
    for name, one in searches.items():
        loop = float(one.weights().mean()), median, one.ki
        numbers = {
            "loop_error": steady_state_error(*loop),
            "loop_stable": float(is_stable(*loop)),
            "loop_rings": float(is_ringing(*loop)),
            "loop_factor": float(np.abs(step_poles(*loop, one.leak)).max()),
        }
        found += [
            Quantity(f"{name}_{part}", numbers[part], "1", text.format(search=name)) for part, text in OF_A_LOOP.items()
        ]
    return found


def _gains(plain: Settings, dimensions: int, seed: int) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Return many values of Kp, what a flight multiplies the distance to the best nest by."""
    drawn = draws(plain.nests, dimensions, plain.levy_exponent, generators(seed, 0, 1))
    return np.concatenate([-plain.step_scale * next(drawn).levy.ravel() for _ in range(_GENERATIONS // BLOCK)])
