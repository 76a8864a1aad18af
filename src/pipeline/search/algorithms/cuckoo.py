"""Cuckoo search, plain, with inertia, and with an integral term, all replicates advanced together as arrays.

Plain: Yang and Deb, Cuckoo search via Levy flights, NaBIC 2009, DOI 10.1109/NABIC.2009.5393690, with the steps of their
published program: Levy numbers by Mantegna, Phys. Rev. E 49 (1994) 4677, DOI 10.1103/PhysRevE.49.4677, times a normal
one, 0.01 of the distance to the best nest; a biased walk; greedy choice after both.

The paper's own formulas are lost. With e = best nest - X its words fix them: plain search is "a discrete proportional
control", inertia multiplies X by w, and "the integral is added, the rest unchanged":

    X(t+1) = w X(t) + Kp e(t) + Ki (e(t) + leak e(t-1) + leak^2 e(t-2) + ...)

Here Kp is the random -0.01 L of the flight. The leak is ours: without one the sum goes on long after the best nest has
moved.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipeline.search.box import Box, CuckooSettings, History, Objective
from pipeline.search.streams import generators

Settings = CuckooSettings


def minimise(objective: Objective, box: Box, settings: Settings, rng: np.random.Generator) -> History:
    """Run one search.

    Arguments
    ---------
    objective : positions (n, d) to values (n,).
    box : where to look.
    settings : of the search; its number of replicates does not count here.
    rng : where all its random numbers come from.

    Returns
    -------
    History of one replicate, a row for the start and for each generation.
    """
    from pipeline.search.nests import together

    return together([(objective, box, settings)], [rng])[0]


def replicate(objective: Objective, box: Box, settings: Settings, seed: int) -> History:
    """Run all replicates together; number i is what `minimise` finds with SeedSequence([seed, i])."""
    from pipeline.search.nests import together

    return together([(objective, box, settings)], generators(seed, 0, settings.replicates))[0]


def replicate_alike(tasks: Sequence[tuple[Objective, Box, Settings]], seed: int) -> list[History]:
    """Run several searches side by side on the same random numbers; each is what `replicate` finds alone.

    Arguments
    ---------
    tasks : objective, box and settings of each; they agree in nests, generations, exponent and replicates.
    """
    from pipeline.search.nests import together

    return together(tasks, generators(seed, 0, tasks[0][2].replicates))
