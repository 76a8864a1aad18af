"""What no staged charge within a range of currents can exceed, from the size of its parts alone."""

from __future__ import annotations

import numpy as np

from pipeline.objective.staging_grid import Grid
from pipeline.objective.staging_records import Currents

# A curve may rise a little between two places of the grid.
_MARGIN = 1.02


def never_limited(grid: Grid, currents: Currents, voltage_v: float, temperature_k: float) -> bool:
    """Return whether no currents of the range, however they follow each other, reach a limit."""
    largest_v, rise_k = largest(grid, currents)
    return largest_v < voltage_v and grid.ambient_k + rise_k < temperature_k


def largest(grid: Grid, currents: Currents) -> tuple[float, float]:
    """Return bounds of the voltage [V] and of the temperature rise [K], in size.

    The voltage of a pair never passes current times resistance, and its heat is at most what it takes up. Cooling,
    which brings a rise nearer to zero, is left out.
    """
    pairs_ohm = np.divide(1.0, grid.conductance, out=np.zeros_like(grid.conductance), where=grid.conductance > 0.0)
    relaxing_ohm = pairs_ohm.max(axis=(0, 2), initial=0.0).sum()
    piece_v = _MARGIN * currents.high * (grid.series_ohm.max(axis=1) + relaxing_ohm)
    heating_k = grid.cells / grid.heat_capacity_j_k * grid.charge_as * piece_v
    growth = np.prod(np.maximum(grid.warming.max(axis=1), 1.0))
    rise_k = float(growth * np.sum(heating_k + _MARGIN * np.abs(grid.reversible).max(axis=1)))
    entropic_v = _MARGIN * np.abs(grid.entropic).max() * rise_k
    return float(grid.cells * (np.max(grid.open_v.max(axis=1) + piece_v) + entropic_v)), rise_k
