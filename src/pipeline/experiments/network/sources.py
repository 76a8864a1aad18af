"""What the steps of the network take: measured and printed data, and surfaces made where a paper gives none."""

from __future__ import annotations

import csv
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
from pipeline.kernel.artefacts import Inputs
from pipeline.published.reference import REFERENCE

LEARNT = "learnt"
"""Name of the data that the network learns, among the surfaces."""


def surfaces(inputs: Inputs) -> dict[str, Data]:
    """Return the data of every surface that the step `surface` made, `LEARNT` among them."""
    table = inputs.table("surface", "surface")
    found = {}
    for name in dict.fromkeys(map(str, table["surface"])):
        own = {key: values[table["surface"] == name] for key, values in table.items()}
        seconds = float(own["gradient_seconds"][0])
        found[name] = data_of(own["temperature_c"], own["gradient"], own["rate_c"], seconds)
    return found


def printed_rows() -> list[Printed]:
    """Return those rows of the paper's Table II that are legible as a whole."""
    found = []
    for row in printed("nicd_table2"):
        numbers = [row[key] for key in ("temperature_c", "gradient", "rate_c")]
        if all(numbers):
            temperature, gradient, rate = map(float, numbers)
            found.append(Printed(int(row["row"]), temperature, gradient, rate, row["certainty"]))
    return found


def printed_temperatures() -> set[float]:
    """Return the temperatures legible in the paper's Table II, also of rows that are not as a whole [degC]."""
    return {float(row["temperature_c"]) for row in printed("nicd_table2") if row["temperature_c"]}


def printed_mse() -> float:
    """Return the error that the paper's Table III prints for its network [C-rate^2]."""
    return next(float(row["mse"]) for row in printed("nicd_table3") if row["network"] == "GA-trained GRNN")


def printed(name: str) -> list[dict[str, str]]:
    """Return the rows of a table of the paper as printed: column -> text, empty where it cannot be read."""
    with (REFERENCE / f"{name}.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


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
