"""What the summary takes from the end of a charge: what was stored, what is left over, and the fastest warming.

The sums are those of `energy.balance`, term by term in its order.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import Cell, enthalpy, pair_ohm
from pipeline.charge.record_keeping import Book
from pipeline.charge.state import DEPTH, ELECTRICAL, RELAXATIONS, TEMPERATURE, TO_AMBIENT
from pipeline.jit import kernel

Array = NDArray[np.float64]


class Settled(NamedTuple):
    """Chemical energy gained and the first law's residual [J], charge of the battery [A s], fastest warming [K/s]."""

    chemical_j: float
    residual_j: float
    charge_as: float
    warming_k_s: float


def settled_of(cells: NDArray[Any], book: Book, before: Array, after: Array) -> Settled:
    """Return what a finished run comes to; arguments as those of `settle`."""
    out = np.empty(len(Settled._fields))
    settle(cells, book.gains, before, after, book.samples[: book.filled[0]], out)
    return Settled(*out.tolist())


@kernel
def settle(cells: NDArray[Any], gains: Array, before: Array, after: Array, samples: Array, out: Array) -> None:
    """Write the numbers of `Settled`.

    Arguments
    ---------
    cells : the battery's `Cell`, in an array of one.
    gains : sums over the run, as in its book.
    before, after : its states.
    samples : those taken.
    """
    cell = cells[0]
    chemical = cell.cells * (enthalpy(cell, after[DEPTH]) - enthalpy(cell, before[DEPTH]))
    stored = 0.0
    for k in range(cell.pairs + cell.acceptance):
        stored += _pair_store(cell, k, after) - _pair_store(cell, k, before)
    gas = 0.0
    if cell.recombination == 1:
        k = cell.relaxations - 1
        gas_as = cell.cells * cell.gas_v * cell.tau_s[k]
        gas = gas_as * after[RELAXATIONS + k] - gas_as * before[RELAXATIONS + k]
    sensible = cell.heat_capacity_j_k * (after[TEMPERATURE] - before[TEMPERATURE])
    out[0] = chemical
    out[1] = gains[ELECTRICAL] - chemical - stored - gas - sensible - gains[TO_AMBIENT]
    out[2] = cell.charge_as
    time_s, kelvin, fastest = 0.0, before[TEMPERATURE], 0.0
    for n in range(len(samples)):
        rate = (samples[n, 8] - kelvin) / (samples[n, 0] - time_s)
        fastest = rate if n == 0 else max(fastest, rate)
        time_s, kelvin = samples[n, 0], samples[n, 8]
    out[3] = fastest


@kernel
def _pair_store(cell: Cell, k: int, state: Array) -> float:
    """Return C v^2 / 2 of a pair, for the whole battery [J]."""
    resistance = pair_ohm(cell, k, state[DEPTH], state[TEMPERATURE])
    voltage = state[RELAXATIONS + k]
    if resistance > 0.0:
        return float(cell.cells * 0.5 * cell.tau_s[k] * voltage * voltage / resistance)
    return 0.0
