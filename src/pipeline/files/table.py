"""A person's table as it stands in the file: headings, cells, and what each row is called."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from pipeline.errors import UserError

_ONE_EACH = "one a column"


class Preamble(NamedTuple):
    """What stands above a table: its lines, and the pairs of key and value among them."""

    lines: tuple[str, ...] = ()
    pairs: Mapping[str, str] = {}


class Table(NamedTuple):
    """Columns as they stand in a file.

    Arguments
    ---------
    path : the file.
    columns : heading -> cells, all of one length; in a row of another length than the headings each is a `Torn`.
    units : heading -> unit, where a row of units stands below the headings.
    place : what rows are called, "line" or "row"; `places` : number of each.
    preamble : what stands above.
    decimal : decimal sign of its text.
    said : what was found, in sentences.
    """

    path: Path
    columns: Mapping[str, Sequence[Any]]
    units: Mapping[str, str]
    place: str
    places: Sequence[int]
    preamble: Preamble = Preamble()
    decimal: str = "."
    said: tuple[str, ...] = ()

    def named(self, row: int) -> str:
        """Return what a row is called in a message."""
        return f"{self.place} {self.places[row]}"

    def refused(self, row: int, column: str, told: str, allowed: str) -> UserError:
        """Return the refusal of a cell, or of a row that has another length than the headings.

        Arguments
        ---------
        row, column : its place and heading.
        told : what stands there, as `pipeline.files.numbers.shown` or `Torn.told` says it.
        allowed : what may stand there.
        """
        where = f"{self.path}: {self.named(row)}"
        return UserError(
            f"{where}: {told}" if _ONE_EACH in told else f"{where}, column {column}: {told}; allowed is {allowed}"
        )


class Torn(NamedTuple):
    """Stands in every cell of a row whose number of cells is not that of the headings."""

    cells: int
    wanted: int

    def told(self) -> str:
        """Return what is wrong with the row, for a message."""
        hint = ""
        if self.cells >= 2 * self.wanted - 1:
            hint = (
                "; decimal commas between commas cannot be told apart: save it with semicolons or tabs between columns"
            )
        return f"{self.cells} values; allowed are {self.wanted}, {_ONE_EACH}{hint}"


class Stamp(NamedTuple):
    """A time that a file holds as a time: seconds since 1970-01-01 00:00, of universal or of local time."""

    seconds: float
    universal: bool
