"""Chaos: how to look at the logistic map in; its orbits, its disorder over r, and their numbers out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline import quantity, schemas, tables
from pipeline.search.chaos import FULL_CHAOS, orbit
from pipeline.search.disorder import Disorder, disorder
from pipeline.search.map_summary import quantities
from pipeline.search.records import ChaosSettings


def run(settings: Mapping[str, Any], inputs: Mapping[str, Path], output: Path) -> None:
    """Follow the map at r = 4 and over r, and measure its disorder."""
    chosen = ChaosSettings.model_validate(settings["chaos"])
    parameters = np.linspace(chosen.r_low, FULL_CHAOS, chosen.r_points)
    measured = {
        bins: disorder(parameters, bins, chosen.disorder_steps, chosen.transient, chosen.start) for bins in chosen.bins
    }
    long = orbit(chosen.start, chosen.disorder_steps, transient=chosen.transient)
    at_four = orbit(chosen.start, chosen.orbit_steps)
    over_r = orbit(np.full(len(parameters), chosen.start), chosen.bifurcation_steps, parameters, chosen.transient)
    tables.write(schemas.ORBIT, _orbit(np.array([FULL_CHAOS]), at_four[:, None]), output / "orbit.parquet")
    tables.write(schemas.ORBIT, _orbit(parameters, over_r), output / "bifurcation.parquet")
    tables.write(schemas.DISORDER, _disorder(measured), output / "disorder.parquet")
    numbers = quantity.columns(quantities(measured, long))
    tables.write(schemas.QUANTITIES, numbers, output / "quantities.parquet")


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
