"""Where the energy went, closed against state functions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import FIRST_PAIR, Cell, enthalpy
from pipeline.cell.curves import value_and_slope
from pipeline.charge.state import (
    DEPTH,
    ELECTRICAL,
    HYSTERESIS_HEAT,
    PAIR_HEAT,
    RELAXATIONS,
    REVERSIBLE_HEAT,
    SERIES_HEAT,
    SIDE_HEAT,
    TEMPERATURE,
    TO_AMBIENT,
    TRANSFER_HEAT,
)


def pair_stores(cell: Cell, state: NDArray[np.float64]) -> list[float]:
    """Return C v^2 / 2 of each pair, the acceptance pair last, for the whole battery [J]."""
    stores = []
    for k in range(cell.pairs + cell.acceptance):
        x = float(state[DEPTH])
        acceptance = k == cell.pairs
        resistance = cell.acceptance_ohm / x if acceptance else value_and_slope(cell, FIRST_PAIR + k, x)[0]
        voltage = float(state[RELAXATIONS + k])
        stores.append(cell.cells * 0.5 * cell.tau_s[k] * voltage * voltage / resistance if resistance > 0 else 0.0)
    return stores


def gas_store(cell: Cell, state: NDArray[np.float64]) -> float:
    """Return the energy of gas not yet recombined, for the whole battery [J]."""
    if not cell.recombination:
        return 0.0
    return float(cell.cells * cell.gas_v * cell.tau_s[cell.relaxations - 1] * state[RELAXATIONS + cell.relaxations - 1])


def balance(
    cell: Cell,
    gains: NDArray[np.float64],
    before: NDArray[np.float64],
    after: NDArray[np.float64],
    pairs: Sequence[str],
) -> dict[str, Any]:
    """Return the rows of the energy table.

    The residual is electrical energy less every change of a state function less the heat to the ambient; the heat that
    warmed the battery was added up from the dissipations, so the residual shows what they miss.

    Arguments
    ---------
    gains : sums over the run, (10 + relaxations,).
    before, after : states, (3 + relaxations,).
    pairs : names of the pairs.
    """
    chemical = cell.cells * (enthalpy(cell, after[DEPTH]) - enthalpy(cell, before[DEPTH]))
    stored = np.array(pair_stores(cell, after)) - np.array(pair_stores(cell, before))
    gas = gas_store(cell, after) - gas_store(cell, before)
    sensible = cell.heat_capacity_j_k * (after[TEMPERATURE] - before[TEMPERATURE])
    names = [*pairs, *(["acceptance"] if cell.acceptance else [])]
    residual = gains[ELECTRICAL] - chemical - stored.sum() - gas - sensible - gains[TO_AMBIENT]
    rows = [
        ("electrical", "input", gains[ELECTRICAL], "electrical energy put in, less that taken out"),
        ("chemical", "stored", chemical, "change of the stored chemical energy H(SOC)"),
        *((f"pair {n} store", "stored", e, "change of C v^2 / 2") for n, e in zip(names, stored, strict=True)),
        ("gas", "stored", gas, "change of the energy of gas not yet recombined"),
        ("series resistance", "loss", gains[SERIES_HEAT], "R0 I^2"),
        *((f"pair {name}", "loss", gains[PAIR_HEAT + k], "v^2 / R - (v^2 / 2) dC/dt") for k, name in enumerate(names)),
        ("charge transfer", "loss", gains[TRANSFER_HEAT], "overpotential times main current"),
        *([("hysteresis", "loss", gains[HYSTERESIS_HEAT], "hysteresis times main current")] if cell.hysteresis else []),
        ("side reaction", "loss", gains[SIDE_HEAT], "side current times voltage, less energy of the gas"),
        ("reversible", "loss", gains[REVERSIBLE_HEAT], "main current times T dU/dT"),
        ("sensible", "heat", sensible, "heat that warmed the battery"),
        ("ambient", "heat", gains[TO_AMBIENT], "heat to the ambient"),
        ("residual", "residual", residual, "electrical less stored, less heat"),
    ]
    path, role, energy, description = zip(*rows, strict=True)
    return {
        "path": list(path),
        "role": list(role),
        "energy_j": np.array(energy, dtype=np.float64),
        "description": list(description),
    }
