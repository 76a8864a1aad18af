"""Which column of a table holds which quantity, in which unit, and the values that stand there."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import UserError, best_matches
from pipeline.files import quantities
from pipeline.files.cells import Table, Torn, bare, number, plain, shown
from pipeline.files.quantities import UNCLEAR, Quantity, Unit
from pipeline.record import OwnFile


class Found(NamedTuple):
    """Heading of each quantity that a table holds, and those that may be one and are not taken, as sentences."""

    headings: Mapping[str, str]
    open: tuple[str, ...]
    said: tuple[str, ...]


def match(table: Table, own: OwnFile, wanted: Sequence[Quantity], key: str) -> Found:
    """Find the columns of quantities: those a person names, then the exact name, then what it is usually called.

    Arguments
    ---------
    table, own : the table, and its record with `columns`.
    wanted : the quantities that may be there.
    key : key path of the record with a dot behind, for messages.

    Raises
    ------
    UserError : a named column that is not there.
    """
    headings: dict[str, str] = {}
    unclear: list[str] = []
    said: list[str] = []
    taken = {own.columns.get(name) for name in ("time", "time_s", "date")}
    free = [name for name in table.columns if name not in taken]
    for quantity in wanted:
        named = own.columns.get(quantity.name) or own.columns.get(quantity.alias)
        if named is not None:
            if named not in table.columns:
                raise UserError(
                    f"{table.path}: no column {named!r}, which {key}columns.{quantity.name} names; "
                    f"{best_matches(named, table.columns)}"
                )
            headings[quantity.name] = named
            continue
        candidates = _candidates(quantity, free)
        if len(candidates) == 1:
            headings[quantity.name] = candidates[0]
        elif candidates:
            listed = ", ".join(map(repr, candidates))
            unclear.append(
                f"the columns {listed} may all be the {quantity.meaning}; say which, "
                f"{spelled(key, quantity.name, candidates[0])}"
            )
    for name, heading in headings.items():
        if heading != name:
            said.append(f"column {heading!r} is {name}")
    return Found(headings, tuple(unclear), tuple(said))


def _candidates(quantity: Quantity, free: Iterable[str]) -> list[str]:
    names = list(free)
    for fits in (
        lambda name: name == quantity.name,
        lambda name: name == quantity.alias,
        lambda name: plain(name) in quantity.words,
        lambda name: bare(name) in quantity.words,
    ):
        found = [name for name in names if fits(name)]
        if found:
            return found
    return []


def unclear_light(table: Table) -> list[str]:
    """Return headings of light that do not say on which plane it falls."""
    return [name for name in table.columns if plain(name) in UNCLEAR or bare(name) in UNCLEAR]


def spelled(key: str, name: str, heading: str) -> str:
    """Return an override that names a column, as it is typed in a shell."""
    word = f'{key}columns={{{name}: "{heading}"}}'
    return f"'{word}'"


def unit_of(table: Table, own: OwnFile, quantity: Quantity, heading: str, key: str) -> tuple[Unit, str | None]:
    """Return the unit of a column, and how it was found where it is not the usual one.

    Raises
    ------
    UserError : a unit that is not known, or none where one is needed.
    """
    named = own.units.get(quantity.name) or own.units.get(quantity.alias)
    if named is not None:
        return quantities.wanted(named, quantity.dimension, quantity.name), f"{heading!r} is in {named}"
    if heading == quantity.name:
        return Unit(1.0), None
    written = table.units.get(heading) or quantities.split(heading)[1]
    if written:
        found = quantities.unit(written.strip("[]()"), quantity.dimension)
        if found is not None:
            usual = found == Unit(1.0)
            return found, None if usual else f"{heading!r} is in {written}"
        if any(mark in written for mark in "/²^°") or quantities.is_unit(written):
            known = ", ".join(sorted(quantities.known(quantity.dimension)))
            raise UserError(
                f"{table.path}: column {heading!r}: unit {written!r}; allowed is one of {known}; or say it, "
                f"'{key}units={{{quantity.name}: {quantity.unit}}}'"
            )
    if not quantity.assumed:
        raise UserError(
            f"{table.path}: column {heading!r} says no unit, and it may be power or energy; say it, "
            f"'{key}units={{{quantity.name}: W}}', or kW, Wh, kWh"
        )
    return Unit(1.0), None


def pick(cells: Sequence[Any], rows: Iterable[int]) -> list[Any]:
    """Return cells of some rows."""
    return [cells[row] for row in rows]


Array = NDArray[np.float64]
# Numbers of nines from here on down are marks that loggers write.
_LEAST_MARK = -90.0


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
            guess = _mark(raw, key) or ("" if stated else quantities.of_value(quantity, float(found[place]), key))
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


def _mark(value: float, key: str) -> str:
    """Return that -999, -9999, -99.9 and the like often mean that nothing was measured; empty of other values."""
    text = f"{value:g}"
    if not text.startswith("-") or not set(text) <= set("-.9") or value > _LEAST_MARK:
        return ""
    return f"; where it means that nothing was measured, '{key}missing=[\"{text}\"]'"


def _refused(
    table: Table, quantity: Quantity, heading: str, row: int, cell: Any, key: str, converted: str = "", guess: str = ""
) -> UserError:
    if isinstance(cell, Torn):
        return table.refused(row, heading, cell.told(), "")
    if not guess and (not converted or number(cell, table.decimal) is not None):
        word = "" if cell is None or cell == "" else str(cell)
        guess = f"; where it means that nothing was measured, '{key}missing=[\"{word}\"]'"
    return UserError(
        f"{table.path}: {table.named(row)}, column {heading}: {shown(cell)}{converted}; allowed is a number from "
        f"{quantity.low:g} to {quantity.high:g} {quantity.unit}{guess}"
    )
