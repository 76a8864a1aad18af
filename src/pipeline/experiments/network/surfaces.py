"""Surfaces that stand in for the paper's lost data: the charging rate over temperature and its gradient."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.experiments.network.records import (
    GRADIENT_SECONDS,
    DataSettings,
    Grid,
    PlateauRamp,
    PlateauSteps,
    Sigmoid,
    Surfaces,
    TakagiSugeno,
)
from pipeline.grnn.records import Data, data_of

Array = NDArray[np.float64]
Surface = PlateauSteps | PlateauRamp | Sigmoid | TakagiSugeno


def rate(surface: Surface, temperature_c: Array, gradient: Array) -> Array:
    """Return a surface's charging rate [C-rate] at temperatures [degC] and gradients [the data's unit], (m,) each."""
    if isinstance(surface, PlateauSteps):
        rates: Array = np.array(surface.rates_c)
        return rates[np.searchsorted(surface.edges_c, temperature_c, side="right")]
    if isinstance(surface, PlateauRamp):
        return np.interp(temperature_c, surface.temperatures_c, surface.rates_c)
    if isinstance(surface, Sigmoid):
        exponent = (temperature_c - surface.middle_c + surface.lead_k * gradient) / surface.slope_k
        found: Array = surface.rest_c + surface.fall_c / (1.0 + np.exp(np.clip(exponent, -500.0, 500.0)))
        return found
    memberships = (_triangles(temperature_c, surface.temperatures_c), _triangles(gradient, surface.gradients))
    mixed: Array = np.einsum("im,jm,ij->m", *memberships, np.array(surface.rates_c))
    return mixed


def _triangles(values: Array, peaks: tuple[float, ...]) -> Array:
    """Return the membership of values in triangles that sum to 1, shape (peaks, m)."""
    return np.stack([np.interp(values, peaks, one) for one in np.eye(len(peaks))])


def grid_points(grid: Grid) -> tuple[Array, Array]:
    """Return temperature [degC] and gradient of every point, (m,) each; the gradient runs fastest."""
    temperatures = np.linspace(0.0, grid.highest_temperature_c, grid.temperatures)
    # Rounded, so that 0.3 is the 0.3 of a table and not 0.30000000000000004.
    gradients = np.round(np.linspace(0.0, grid.highest_gradient, grid.gradients), 12)
    return np.repeat(np.round(temperatures, 12), grid.gradients), np.tile(gradients, grid.temperatures)


def every_surface(settings: DataSettings) -> dict[str, Data]:
    """Return the data of every surface on the study's grid."""
    temperature, gradient = grid_points(settings.grid)
    seconds = GRADIENT_SECONDS[settings.gradient_unit]
    return {
        name: data_of(temperature, gradient, rate(getattr(settings.surfaces, name), temperature, gradient), seconds)
        for name in Surfaces.model_fields
    }


class Printed(NamedTuple):
    """A legible row of the paper's Table II."""

    row: int
    temperature_c: float
    gradient: float
    rate_c: float
    certainty: str


class Agreement(NamedTuple):
    """A surface held against a printed row."""

    surface: str
    printed: Printed
    computed_c: float
    """The surface's rate there [C-rate]."""
    consistent: bool


def agreements(settings: DataSettings, printed: list[Printed]) -> list[Agreement]:
    """Return every surface against every printed row, within the tolerance to which rates are printed."""
    temperature = np.array([row.temperature_c for row in printed])
    gradient = np.array([row.gradient for row in printed])
    found = []
    for name in Surfaces.model_fields:
        computed = rate(getattr(settings.surfaces, name), temperature, gradient)
        for row, value in zip(printed, computed.tolist(), strict=True):
            found.append(Agreement(name, row, value, abs(value - row.rate_c) <= settings.table_tolerance_c))
    return found
