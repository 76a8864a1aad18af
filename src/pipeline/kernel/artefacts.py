"""What a step reads and where it writes: artefacts by the name of the input, tables by their declared names."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from pipeline.kernel import tables
from pipeline.kernel.experiment import kind_of
from pipeline.kernel.tables import TableFile

Columns = dict[str, np.ndarray[Any, Any]]


class NamedNumber(Protocol):
    """A number with its name, unit and meaning."""

    @property
    def name(self) -> str:
        """Return its name."""

    @property
    def value(self) -> float:
        """Return its value; NaN where there is none."""

    @property
    def unit(self) -> str:
        """Return its unit."""

    @property
    def description(self) -> str:
        """Return what it is."""


class Inputs(Mapping[str, Path]):
    """The artefacts that a step reads: input name -> folder; a table is read once, when it is first asked for.

    Arguments
    ---------
    folders : input name -> folder of its artefact.
    declared : input name -> the tables of the step that made it.
    """

    def __init__(self, folders: Mapping[str, Path], declared: Mapping[str, Mapping[str, TableFile]]) -> None:
        self._folders = dict(folders)
        self._declared = dict(declared)
        self._read: dict[tuple[str, str], Columns] = {}

    def __getitem__(self, name: str) -> Path:
        return self._folders[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._folders)

    def __len__(self) -> int:
        return len(self._folders)

    def table(self, source: str, name: str) -> Columns:
        """Return a table of an input as column name -> array.

        Raises
        ------
        KeyError : no such input, or no such table declared for it.
        TableError : the file is not what was declared.
        """
        if (source, name) not in self._read:
            found = self.declared(source, name)
            if found is None:
                raise KeyError(f"{source} has no table {name!r}")
            self._read[source, name] = tables.read(found.table, self._folders[source] / found.file)
        return self._read[source, name]

    def declared(self, source: str, name: str) -> TableFile | None:
        """Return how a table of an input is declared; none where it has no such table."""
        return tables.find(self._declared.get(source, {}), name)

    def holds(self, source: str, name: str) -> bool:
        """Tell whether an input is there and has written a table."""
        found = self.declared(source, name)
        return source in self and found is not None and (self._folders[source] / found.file).is_file()

    def numbers(self, source: str, name: str = "quantities") -> dict[str, float]:
        """Return the named numbers that an input found, without those that have no value."""
        columns = self.table(source, name)
        pairs = zip(columns["quantity"], columns["value"], strict=True)
        return {str(key): float(value) for key, value in pairs if value is not None and np.isfinite(value)}

    def kinds(self) -> set[str]:
        """Return the kinds of the inputs: the first words of their names."""
        return {kind_of(name) for name in self}

    def of_kind(self, kind: str) -> list[str]:
        """Return the names of the inputs of a kind, in the order of the plan."""
        return [name for name in self if kind_of(name) == kind]

    def renamed(self, names: Mapping[str, str]) -> Inputs:
        """Return some inputs under other names, and nothing else.

        Arguments
        ---------
        names : new name -> the name of an input here.
        """
        folders = {new: self._folders[old] for new, old in names.items()}
        return Inputs(folders, {new: self._declared.get(old, {}) for new, old in names.items()})


class Output:
    """The folder that a step fills, and the tables that it declared.

    Arguments
    ---------
    folder : where the artefact is written, empty at first.
    declared : name -> table file.
    """

    def __init__(self, folder: Path, declared: Mapping[str, TableFile]) -> None:
        self.folder = folder
        self._declared = dict(declared)

    def write(self, name: str, columns: Mapping[str, Any]) -> None:
        """Write a table: column name -> array or list; raise `TableError` where it is not what was declared."""
        found = tables.find(self._declared, name)
        if found is None:
            raise tables.TableError(f"table {name!r} is not declared; declared are: {', '.join(self._declared)}")
        tables.write(found.table, columns, self.folder / found.file)

    def rows(self, name: str, rows: Iterable[Any], columns: Iterable[str] | None = None) -> None:
        """Write a table from rows: tuples in the order of the columns, or objects with the columns as attributes."""
        names, listed = self.columns(name) if columns is None else list(columns), list(rows)
        plain = [row if type(row) is tuple else tuple(getattr(row, key) for key in names) for row in listed]
        self.write(name, {key: [row[place] for row in plain] for place, key in enumerate(names)})

    def numbers(self, found: Iterable[NamedNumber], name: str = "quantities") -> None:
        """Write named numbers with their units and meanings."""
        self.rows(name, [(one.name, one.value, one.unit, one.description) for one in found])

    def columns(self, name: str) -> list[str]:
        """Return the names of the columns of a declared table."""
        found = tables.find(self._declared, name)
        return [] if found is None else [column.name for column in found.table.columns]

    def empty(self, name: str) -> dict[str, list[Any]]:
        """Return the columns of a declared table without rows."""
        return {column: [] for column in self.columns(name)}

    def found(self, values: Mapping[str, Any]) -> None:
        """Write the values that others ask for with `{from: step, value: name}`: numbers, lists, records as data."""
        text = json.dumps(dict(values), indent=1, sort_keys=True, allow_nan=False)
        (self.folder / "found.json").write_text(text + "\n", encoding="utf-8")
