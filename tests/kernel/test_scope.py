"""A view shows what is declared and nothing else."""

from __future__ import annotations

import pytest
from pydantic import Field

from pipeline.kernel.scope import UndeclaredRead, view
from pipeline.record import Record


class Cell(Record):
    """A record with a derived value and a method."""

    capacity_ah: float
    scaled_to_ah: float | None = None
    title: str = "cell"

    @property
    def scale(self) -> float:
        """Return the scale."""
        return 1.0 if self.scaled_to_ah is None else self.scaled_to_ah / self.capacity_ah

    def charge_ah(self, share: float) -> float:
        """Return a share of the capacity."""
        return share * self.capacity_ah


class Root(Record):
    """A root record."""

    cell: Cell = Cell(capacity_ah=4.0, scaled_to_ah=6.0)
    cells: dict[str, Cell] = Field(default={"a": Cell(capacity_ah=1.0), "b": Cell(capacity_ah=2.0)})
    none: Cell | None = None
    sources: dict[str, str] = Field(default={"cell.capacity_ah": "sheet", "cells.a.capacity_ah": "guess"})


def test_what_is_declared_is_read_whole() -> None:
    assert view(Root(), ["cell"]).cell == Cell(capacity_ah=4.0, scaled_to_ah=6.0)


def test_what_is_not_declared_is_refused() -> None:
    for read in (lambda seen: seen.cell, lambda seen: seen.none, lambda seen: seen.cells["b"]):
        with pytest.raises(UndeclaredRead, match=r"read and not declared; declared are: cells\.a"):
            read(view(Root(), ["cells.a"]))


def test_properties_and_methods_see_no_more_than_their_record() -> None:
    seen = view(Root(), ["cell.capacity_ah", "cell.scaled_to_ah"])
    assert seen.cell.scale == 1.5
    assert seen.cell.charge_ah(0.5) == 2.0
    with pytest.raises(UndeclaredRead, match=r"cell\.scaled_to_ah"):
        _ = view(Root(), ["cell.capacity_ah"]).cell.scale


def test_a_record_of_which_parts_are_declared_is_not_taken_whole() -> None:
    with pytest.raises(UndeclaredRead, match="read whole"):
        view(Root(), ["cell.title"]).cell.model_dump()


def test_a_mapping_is_gone_through_where_every_entry_is_declared() -> None:
    seen = view(Root(), ["cells.b.title", "none.title"])
    assert seen.cells["b"].title == "cell"
    with pytest.raises(UndeclaredRead, match=r"cells\.a is read"):
        list(seen.cells)
    assert list(view(Root(), ["cells.a.title", "cells.b"]).cells) == ["a", "b"]
    assert seen.none is None


def test_sources_are_those_of_what_is_declared() -> None:
    seen = view(Root(), ["cell"])
    assert seen.sources_below("cell") == {"cell.capacity_ah": "sheet"}
    with pytest.raises(UndeclaredRead, match="sources of cells are read"):
        seen.sources_below("cell", "cells")
