"""Ensembles: points over the ranges of estimated parameters, and what statements read in each of them.

A step of an experiment makes one: it draws points, computes in each what it computes for the study's own values, and
writes the numbers that statements ask for. The points of a study's ensembles are the same where they share a parameter.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field, TypeAdapter, ValidationError, field_validator

from pipeline.errors import UserError
from pipeline.kernel import tables
from pipeline.kernel.artefacts import Output
from pipeline.kernel.experiment import kind_of
from pipeline.kernel.scope import below
from pipeline.kernel.tables import Column, Table, TableFile
from pipeline.published.artefacts import Lookup, Unanswerable, number
from pipeline.published.operands import Operand, atoms, text, values
from pipeline.published.words import PARAMETERS
from pipeline.record import Record

NAME = "ensemble"
"""First word of the names of all ensembles."""
VARIED = ("battery", "modes", "charge", "objective", "converter.switched", "staging", "trade_off")
"""Parts of the configuration whose estimates are varied, in the order of their columns of the draw."""
DIMENSIONS = 256
"""Columns of the draw, always as many: what stands in a later part moves no point of an earlier one."""
IMPOSSIBLE = (UserError, ValidationError, ValueError, ZeroDivisionError)
"""What says that no battery, mode or converter can be as a point has it."""
ANSWERS = {
    "ensemble": TableFile(
        "ensemble.parquet",
        Table(
            "ensemble",
            "What statements read in each point of the estimated parameters, or in each experiment of other seeds",
            (
                Column("point", "1", "number of the point, from 0", "integer"),
                Column("operand", "", "what is read, as statements write it", "text"),
                Column("value", "see the operand", "its value; empty where it has none", optional=True),
                Column("possible", "1", "0 where no battery can be as this point has it", "integer"),
                Column("of", "", "what the points are", "text"),
            ),
        ),
    )
}
"""What every step of an ensemble writes."""
Row = tuple[int, str, float | None, int, str]
_OPERAND: TypeAdapter[Operand] = TypeAdapter(Operand)


class EnsembleSettings(Record):
    """How many points are drawn over the ranges of the estimated parameters; powers of two, as Sobol's points are."""

    points: int = Field(default=128, ge=0, le=8192, description="points; 0 leaves the ensembles out [1]")
    slow_points: int = Field(default=64, ge=0, le=8192, description="points where one costs over 0.1 s [1]")
    experiments: int = Field(default=32, ge=0, le=8192, description="repetitions of a search with other seeds [1]")

    @field_validator("points", "slow_points")
    @classmethod
    def _power_of_two(cls, value: int) -> int:
        if value & (value - 1):
            raise ValueError(f"{value} is no power of two, which Sobol's points must be to lie evenly")
        return value


def estimates(sources: Mapping[str, Any], parts: Collection[str]) -> dict[str, Any]:
    """Return what the points are drawn from, as plain data for the settings of a step.

    Arguments
    ---------
    sources : key path -> source, of the whole study.
    parts : key paths of the parts of the configuration that the ensemble varies.

    Returns
    -------
    `ranges`: key path -> lowest and highest value; `columns`: key path -> column of the draw, that of the study's other
    ensembles; `followers`: key path -> the path whose value it takes.
    """
    ranges = {path: source.range for path, source in sources.items() if source.range is not None}
    every = {path: _shared_name(path, limits) for path, limits in ranges.items() if below(path, VARIED)}
    part = {name: next(n for n, one in enumerate(VARIED) if below(path, [one])) for path, name in every.items()}
    order = {name: column for column, name in enumerate(sorted(part, key=lambda name: (part[name], name)))}
    if len(order) > DIMENSIONS:
        raise UserError(f"sources: {len(order)} estimates have a range; allowed are {DIMENSIONS}")
    own = {path: list(ranges[path]) for path in every if below(path, parts)}
    return {
        "ranges": own,
        "columns": {path: order[every[path]] for path in own},
        "followers": {
            path: leader
            for path, source in sources.items()
            if source.same_as and (leader := f"{path.rpartition('.')[0]}.{source.same_as}") in own
        },
    }


def draw(estimated: Mapping[str, Any], points: int, seed: int) -> list[dict[str, float]]:
    """Draw scrambled Sobol points over the ranges (Owen 1998, by scipy).

    Arguments
    ---------
    estimated : as `estimates` returns it.
    points : how many, a power of two.
    seed : of the scrambling.

    Returns
    -------
    A mapping key path -> value for each point. Fewer points are the first of more.
    """
    from scipy.stats import qmc

    unit = qmc.Sobol(d=DIMENSIONS, scramble=True, rng=np.random.default_rng(seed)).random(points)
    columns, followers = estimated["columns"], estimated["followers"]
    drawn = [
        {path: low + (high - low) * float(row[columns[path]]) for path, (low, high) in estimated["ranges"].items()}
        for row in unit
    ]
    return [values | {path: values[other] for path, other in followers.items()} for values in drawn]


def with_values(tree: Mapping[str, Any], values: Mapping[str, float]) -> dict[str, Any]:
    """Return a copy of a plain tree with the values at some key paths replaced, those of other trees left out.

    Raises
    ------
    KeyError : a path below an entry of the tree that is not there.
    """
    result = {key: with_values(item, {}) if isinstance(item, Mapping) else item for key, item in tree.items()}
    for path, value in values.items():
        here = result
        *parents, last = path.split(".")
        if parents[0] not in result:
            continue
        for key in parents:
            here = here[key]
        if last not in here:
            raise KeyError(path)
        here[last] = value
    return result


def _shared_name(path: str, limits: Sequence[float]) -> str:
    """Return the name of a parameter: knobs of one name and range are one in all modes, so that modes compare."""
    keys = path.split(".")
    if keys[0] == "modes":
        return f"modes.*.{'.'.join(keys[2:])} {limits[0]:.17g} {limits[1]:.17g}"
    return path


def asked(config: Any, kinds: Collection[str], basis: str = "model") -> list[dict[str, Any]]:
    """Return what statements of a basis, and the answer, read of some kinds of inputs, as plain data, each once.

    Arguments
    ---------
    config : a study, or the view of it; its `published` and `answer` are read.
    kinds : first words of inputs' names.
    """
    read: list[Any] = [one.check for one in config.published.values() if one.basis == basis and one.check is not None]
    read += [operand for choice in config.answer.values() for operand in choice.among.values() if basis == "model"]
    found = {
        text(one): one.model_dump(mode="json")
        for operand in read
        for one in atoms(operand)
        if {kind_of(value.artefact) for value in values(one)} <= set(kinds)
    }
    return [found[name] for name in sorted(found)]


def answers(
    point: int, wanted: Iterable[Mapping[str, Any]], reader: Lookup | None, of: str = PARAMETERS
) -> Iterator[Row]:
    """Yield the rows of a point.

    Arguments
    ---------
    wanted : as `asked` returns them.
    reader : what was computed in the point; none where no battery can be so.
    of : what the points are.
    """
    for data in wanted:
        one: Operand = _OPERAND.validate_python(data)
        value = None if reader is None else _found(one, reader)
        yield point, text(one), value, int(reader is not None), of


def _found(operand: Operand, reader: Lookup) -> float | None:
    """Return a number; none where it has none, and for an endless time, which no table holds."""
    try:
        value = number(operand, reader)
    except Unanswerable:
        return None
    return value if np.isfinite(value) else None


class Computed:
    """Tables that were computed and not written, where a lookup expects artefacts.

    Arguments
    ---------
    found : input -> table -> columns.
    declared : kind of input -> its tables.
    """

    def __init__(
        self, found: Mapping[str, Mapping[str, Mapping[str, Any]]], declared: Mapping[str, Mapping[str, TableFile]]
    ) -> None:
        self._found = found
        self._declared = declared

    def __contains__(self, name: object) -> bool:
        return name in self._found

    def holds(self, source: str, name: str) -> bool:
        """Tell whether a table was computed."""
        return name in self._found.get(source, {})

    def declared(self, source: str, name: str) -> TableFile | None:
        """Return how a table is declared; that of named numbers is the same in every step."""
        return tables.find({**tables.NUMBERS, **self._declared.get(kind_of(source), {})}, name)

    def table(self, source: str, name: str) -> dict[str, np.ndarray[Any, Any]]:
        """Return a table as column -> array."""
        return {key: np.asarray(column) for key, column in self._found[source][name].items()}


def reader(
    found: Mapping[str, Mapping[str, Mapping[str, Any]]],
    declared: Mapping[str, Mapping[str, TableFile]] | None = None,
) -> Lookup:
    """Return a lookup over tables that were computed; arguments are those of `Computed`."""
    held: Any = Computed(found, declared or {})
    return Lookup(held)


def numbers_table(quantities: Iterable[Any]) -> dict[str, list[Any]]:
    """Return the table that named numbers are written as: objects with a name, a value, a unit and a description."""
    listed = list(quantities)
    names = {"quantity": "name", "value": "value", "unit": "unit", "description": "description"}
    return {column: [getattr(one, name) for one in listed] for column, name in names.items()}


class Kept(Output):
    """Where a step writes tables that are read at once and not kept on disk; of rows, named numbers alone."""

    def __init__(self) -> None:
        super().__init__(Path(), {})
        self.tables: dict[str, Mapping[str, Any]] = {}

    def write(self, name: str, columns: Mapping[str, Any]) -> None:
        """Hold a table."""
        self.tables[name] = columns

    def numbers(self, found: Iterable[Any], name: str = "quantities") -> None:
        """Hold named numbers."""
        self.write(name, numbers_table(found))

    def found(self, values: Mapping[str, Any]) -> None:
        """Let go of values that others would ask for."""


def seeds(seed: int, count: int) -> list[int]:
    """Return the seeds of experiments that repeat a search, none of them the study's own."""
    return [int(np.random.SeedSequence([seed, 1, number]).generate_state(1)[0]) for number in range(count)]
