"""What a fit takes of each file, and what comes of it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.experiments.own_battery.certainty import Certainty
from pipeline.experiments.own_battery.fitting import Problem, Result
from pipeline.experiments.own_battery.reading import Series
from pipeline.experiments.own_battery.segments import Segment, Thinned
from pipeline.experiments.own_battery.structures import Tried
from pipeline.experiments.own_battery.unknowns import Model


class Record(NamedTuple):
    """A file as the fit takes it: its rows, thinned, which of them it may see, and what it starts from.

    `held` tells whether the voltage drives the replay where a charger held one.
    """

    series: Series
    thinned: Thinned
    held_out: NDArray[np.bool_]
    segments: list[Segment]
    soc: float
    stated: bool
    ambient_c: float
    held: bool = False


class Fitted(NamedTuple):
    """What came of a fit.

    Arguments
    ---------
    tried, chosen : the structures that were compared.
    model : the model of the chosen one, before any number kept its prior.
    problem, result : of the last fit; `starts` : all of them, the best first.
    kept : key paths of the numbers that keep their priors.
    certainty : what is known of the fitted ones.
    """

    tried: list[Tried]
    chosen: Tried
    model: Model
    problem: Problem
    result: Result
    starts: list[Result]
    kept: list[str]
    certainty: Certainty
