"""The values of a column in some rows: numbers in the project's unit, within what is possible."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import UserError
from pipeline.files import quantities
from pipeline.files.cells import Table, Torn, number, shown
from pipeline.files.headings import unit_of
from pipeline.files.quantities import Quantity
from pipeline.record import OwnFile

Array = NDArray[np.float64]


def values(
    table: Table,
    own: OwnFile,
    quantity: Quantity,
    heading: str,
    rows: Sequence[int],
    lengths_s: Array,
    key: str,
) -> tuple[Array, tuple[str, ...]]:
    """Return a column's values in some rows, and what was found of it.

    Arguments
    ---------
    table, own : the table, and its record with `units` and `missing`.
    quantity, heading : what is read, and of which column.
    rows : places of the rows; `lengths_s` : lengths of their intervals [s], shape (n,), for amounts in each interval.
    key : key path of the record with a dot behind, for messages.

    Returns
    -------
    Values, shape (n,), NaN where nothing was measured.

    Raises
    ------
    UserError : a cell that is no number, or beyond what is possible, with row, column, value, what is allowed, a guess.
    """
    unit, said = unit_of(table, own, quantity, heading, key)
    cells, stated = table.columns[heading], said is not None
    found = np.empty(len(rows))
    for place, row in enumerate(rows):
        cell = cells[row]
        raw = np.nan if _is_missing(cell, own, table.decimal) else number(cell, table.decimal)
        if raw is None:
            raise _refused(table, quantity, heading, row, cell, key)
        value = (raw + unit.shift) * unit.factor
        found[place] = value / lengths_s[place] if unit.each_interval else value
        if not quantity.low <= found[place] <= quantity.high and not np.isnan(found[place]):
            converted = f", {found[place]:.4g} {quantity.unit}" if stated else ""
            guess = "" if stated else quantities.of_value(quantity, float(found[place]), key)
            raise _refused(table, quantity, heading, row, cell, key, converted, guess)
    if not stated and len(found):
        quantities.refuse(table.path, quantity, heading, found, key)
    return found, () if said is None else (said,)


def _is_missing(cell: Any, own: OwnFile, decimal: str) -> bool:
    if not own.missing:
        return False
    text = "" if cell is None else str(cell).strip()
    if text in own.missing:
        return True
    value = number(cell, decimal)
    return value is not None and any(number(mark) == value for mark in own.missing)


def _refused(
    table: Table, quantity: Quantity, heading: str, row: int, cell: Any, key: str, converted: str = "", guess: str = ""
) -> UserError:
    if isinstance(cell, Torn):
        return table.refused(row, heading, cell.told(), "")
    if not converted and not guess and number(cell, table.decimal) is None:
        word = "" if cell is None or cell == "" else str(cell)
        guess = f"; where it means that nothing was measured, '{key}missing=[\"{word}\"]'"
    return UserError(
        f"{table.path}: {table.named(row)}, column {heading}: {shown(cell)}{converted}; allowed is a number from "
        f"{quantity.low:g} to {quantity.high:g} {quantity.unit}{guess}"
    )
