"""Inputs that several steps read in the same way."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from pipeline import schemas, tables
from pipeline.charge.simulate import Supply


def supply(inputs: Mapping[str, Path]) -> Supply:
    """Return the power at the battery's terminals; without a supply step, a bench supply that gives any."""
    if "supply" not in inputs:
        return Supply(time_s=np.zeros(1), power_w=np.full(1, np.inf))
    table = tables.read(schemas.SUPPLY, inputs["supply"] / "supply.parquet")
    return Supply(time_s=table["time_s"], power_w=table["battery_power_w"])
