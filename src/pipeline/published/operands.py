"""What a predicate compares: a number, a value of an artefact, or a little arithmetic on these."""

from __future__ import annotations

import re
from typing import Annotated, Any

from pydantic import BeforeValidator, Discriminator, Field, Tag

from pipeline.kernel import registry
from pipeline.kernel.experiment import kind_of
from pipeline.record import Record

_VALUE = re.compile(
    r"(?P<quantity>.+?) of (?P<artefact>[\w./-]+?)(?:\.(?P<table>[a-z]\w*))?(?: where (?P<where>.+))?", re.ASCII
)


class Value(Record):
    """One number of an artefact, or a column of it: `quantity of artefact.table where column=value and ...`.

    The table may be left out where the step that makes the artefact declares a usual one.
    """

    quantity: str = Field(min_length=1, description="name of a quantity or a column")
    artefact: str = Field(min_length=1, description="name of the input, e.g. charge/same_peak/cc_cv")
    table: str = Field(min_length=1, description="table of that input, e.g. summary")
    where: dict[str, float | str] = Field(default={}, description="column -> value that its row must have")

    def __str__(self) -> str:
        """Return the compact form it was written in."""
        rows = " and ".join(
            f"{column}={value:g}" if isinstance(value, float) else f"{column}={value}"
            for column, value in self.where.items()
        )
        return f"{self.quantity} of {self.artefact}.{self.table}" + (f" where {rows}" if rows else "")


def parse(text: Any) -> Any:
    """Read the compact form of a value; anything but text is handed on as it is."""
    if not isinstance(text, str):
        return text
    found = _VALUE.fullmatch(text.strip())
    if not found:
        raise ValueError(f"{text!r} is not a value; write 'quantity of artefact.table where column=value'")
    artefact = found["artefact"]
    table = found["table"] or _usual_table(artefact)
    return {"quantity": found["quantity"].strip(), "artefact": artefact, "table": table, "where": _rows(found["where"])}


def _usual_table(artefact: str) -> str:
    """Return the table that is meant where none is named; a paper's own has one of its own name."""
    step = registry.steps().get(kind_of(artefact))
    return artefact.split("/")[-1] if step is None or step.usual_table is None else step.usual_table


def _rows(text: str | None) -> dict[str, float | str]:
    rows: dict[str, float | str] = {}
    for part in text.split(" and ") if text else []:
        column, equals, value = (piece.strip() for piece in part.partition("="))
        if not (column and equals and value):
            raise ValueError(f"{part!r} does not choose a row; write 'column=value'")
        try:
            rows[column] = float(value)
        except ValueError:
            rows[column] = value
    return rows


Reading = Annotated[Value, BeforeValidator(parse, json_schema_input_type=str | Value)]
"""A value in compact or in long form."""


class Difference(Record):
    """The first operand less the second."""

    difference: tuple[Operand, Operand]


class Ratio(Record):
    """The first operand over the second."""

    ratio: tuple[Operand, Operand]


class Product(Record):
    """The product of all operands."""

    product: tuple[Operand, ...] = Field(min_length=1)


class Total(Record):
    """The sum of a column over the rows chosen."""

    total: Reading


class Moment(Record):
    """A column of a table in time, and the time in s."""

    value: Reading
    time: Operand


class AtTime(Record):
    """A column at a time, linear between rows; before the first row and after the last, that row's value."""

    at_time: Moment


_OPERATIONS = ("difference", "ratio", "product", "total", "at_time")


def _kind(operand: Any) -> str | None:
    if isinstance(operand, bool):
        return None
    if isinstance(operand, (int, float)):
        return "number"
    if isinstance(operand, (str, Value)) or (isinstance(operand, dict) and "quantity" in operand):
        return "value"
    keys = operand if isinstance(operand, dict) else type(operand).__name__.lower()
    if isinstance(operand, Record):
        keys = type(operand).model_fields
    return next((name for name in _OPERATIONS if name in keys), None)


Operand = Annotated[
    Annotated[float, Tag("number")]
    | Annotated[Reading, Tag("value")]
    | Annotated[Difference, Tag("difference")]
    | Annotated[Ratio, Tag("ratio")]
    | Annotated[Product, Tag("product")]
    | Annotated[Total, Tag("total")]
    | Annotated[AtTime, Tag("at_time")],
    Discriminator(
        _kind,
        custom_error_type="operand",
        custom_error_message="must be a number, a value 'quantity of artefact', or one of "
        "difference, ratio, product, total, at_time",
    ),
]
"""What stands on either side of a predicate."""

for _record in (Difference, Ratio, Product, Moment, AtTime):
    _record.model_rebuild()


def atoms(operand: float | Record) -> list[Value | AtTime | Total]:
    """Return what an operand or a predicate takes from artefacts, each a single number."""
    if isinstance(operand, (Value, AtTime, Total)):
        return [operand]
    if not isinstance(operand, Record):
        return []
    parts = (getattr(operand, name) for name in type(operand).model_fields)
    listed = (part for one in parts for part in (one if isinstance(one, (tuple, list)) else (one,)))
    return [found for part in listed if isinstance(part, Record) for found in atoms(part)]


def text(operand: float | Record) -> str:
    """Return an operand in one line, by which what reads the same is the same."""
    match operand:
        case Value():
            return str(operand)
        case Total(total=column):
            return f"sum of {column}"
        case AtTime(at_time=moment):
            return f"{moment.value} at {text(moment.time)}"
        case Difference(difference=(left, right)):
            return f"({text(left)} - {text(right)})"
        case Ratio(ratio=(left, right)):
            return f"({text(left)} / {text(right)})"
        case Product(product=factors):
            return f"({' x '.join(map(text, factors))})"
    return f"{operand:.17g}" if isinstance(operand, float) else str(operand)


def values(operand: float | Record) -> list[Value]:
    """Return every artefact value an operand reads."""
    if isinstance(operand, Value):
        return [operand]
    if not isinstance(operand, Record):
        return []
    found: list[Value] = []
    for name in type(operand).model_fields:
        content = getattr(operand, name)
        for part in content if isinstance(content, (tuple, list)) else (content,):
            if isinstance(part, (Record, float)):
                found += values(part)
    return found
