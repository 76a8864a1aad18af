"""What the logistic map comes to, as named numbers: how disordered it is over r, and what its density at r = 4 is."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from pipeline.quantity import Quantity
from pipeline.search.chaos import arcsine_cumulative, arcsine_entropy
from pipeline.search.disorder import Disorder

Array = NDArray[np.float64]


def quantities(measured: Mapping[int, Disorder], orbit: Array) -> list[Quantity]:
    """Return the numbers that describe the map.

    Arguments
    ---------
    measured : number of bins -> disorder over r; the last r is 4.
    orbit : many values at r = 4, shape (n,).
    """
    found: list[Quantity] = []
    for bins, disorder in measured.items():
        most = int(np.argmax(disorder.entropy))
        found += [
            Quantity(f"most_disordered_r_{bins}_bins", float(disorder.r[most]), "1", f"r of most entropy, {bins} bins"),
            Quantity(f"most_entropy_{bins}_bins_nats", float(disorder.entropy[most]), "nat", "entropy there"),
            Quantity(f"entropy_at_4_{bins}_bins_nats", float(disorder.entropy[-1]), "nat", "entropy at r = 4"),
            Quantity(f"exact_entropy_at_4_{bins}_bins_nats", arcsine_entropy(bins), "nat", "the same, exactly"),
            Quantity(f"uniform_entropy_{bins}_bins_nats", math.log(bins), "nat", "entropy of uniform numbers"),
        ]
    any_of_them = next(iter(measured.values()))
    found += [
        Quantity(
            "most_unstable_r",
            float(any_of_them.r[int(np.argmax(any_of_them.lyapunov))]),
            "1",
            "r of the largest Lyapunov exponent",
        ),
        Quantity("lyapunov_at_4_nats", float(any_of_them.lyapunov[-1]), "nat/step", "Lyapunov exponent at r = 4"),
        Quantity("mean_at_4", float(np.mean(orbit)), "1", "mean of the values at r = 4; 1/2 for uniform numbers"),
        Quantity("variance_at_4", float(np.var(orbit)), "1", "their variance; 1/12 for uniform numbers"),
        Quantity("distance_to_uniform", distance(orbit, orbit), "1", _DISTANCE.format("uniform")),
        Quantity("distance_to_arcsine", distance(orbit, arcsine_cumulative(orbit)), "1", _DISTANCE.format("arcsine")),
    ]
    return found


_DISTANCE = "largest distance between the distribution function of the values at r = 4 and the {} one"


def distance(values: Array, cumulative: Array) -> float:
    """Return the Kolmogorov-Smirnov distance of values (n,) to a law, given its distribution function at them (n,)."""
    expected = np.sort(cumulative)
    count = len(values)
    above = np.arange(1, count + 1) / count - expected
    below = expected - np.arange(count) / count
    return float(max(above.max(), below.max()))
