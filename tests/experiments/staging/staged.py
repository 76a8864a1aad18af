"""Batteries and stages that tests of staged charges share."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from pipeline.cell.records import Battery
from pipeline.config.compose import compose_tree
from pipeline.experiments.staging.kernel import Grid, make_grid
from pipeline.experiments.staging.optimum import Problem
from pipeline.experiments.staging.records import Currents, Reading
from pipeline.experiments.staging.stage_charges import Limits

CONF = Path(__file__).parents[3] / "conf"
PRINTED = np.array([39.2, 36.6, 29.8, 14.3, 12.9, 11.8, 8.5, 9.7])
EDGES = tuple(np.round(np.arange(1, 10) / 10, 12).tolist())
CURRENTS = Currents(low=8.0, high=40.0)
LIMITS = Limits(3.65, 60.0)
CALIBRATIONS = ("lfp_8ah", "lfp_8ah_half_entropy", "lfp_8ah_no_entropy", "lfp_8ah_no_entropy_heavy")


@cache
def shipped(name: str) -> Battery:
    """Return a battery of conf/battery as a study composes it."""
    tree = compose_tree(["study=lfp_cuckoo", f"battery={name}"]).tree["battery"]
    return Battery.model_validate({key: value for key, value in tree.items() if key != "sources"})


def simple(**changes: object) -> Battery:
    """Return a cell of constant values: 8 Ah, 5 mOhm, no pair, no entropy, hardly cooled."""
    values: dict[str, object] = {
        "name": "simple",
        "title": "Simple",
        "cells_in_series": 1,
        "capacity_ah": 8.0,
        "open_circuit_voltage_v": 3.2,
        "series_resistance_ohm": 0.005,
        "thermal": {"heat_capacity_j_k": 270.0, "resistance_k_w": 1e15},
    }
    return Battery.model_validate(values | changes)


def grid(battery: Battery, edges: tuple[float, ...] = EDGES, slowest_a: float = 4.0) -> Grid:
    """Return the grid of a battery's stages at 25 degC."""
    return make_grid(battery, edges, 25.0, slowest_a)


def problem(battery: Battery, reading: Reading = "peak", limits: Limits = LIMITS) -> Problem:
    """Return the eight stages with a battery, currents from 8 to 40 A."""
    return Problem(grid(battery, slowest_a=CURRENTS.low), CURRENTS, reading, limits)
