"""The base of every parameter record, strict about keys and kinds, bounded by units; the record of a person's file."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Annotated, Any, Literal, NamedTuple, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, GetCoreSchemaHandler, field_validator
from pydantic_core import CoreSchema


class Span(NamedTuple):
    """Magnitudes that a quantity may have in a plant of the kind that is described here.

    `least` is that of a value which must be positive; `low` the lowest of all, minus the most where not given.
    """

    least: float
    most: float
    low: float | None = None


YEARS_S = 3.2e9
"""A hundred years [s]."""
# Wide enough for a coin cell and for a plant of gigawatts: what lies beyond is a slip of the hand or of the unit.
SPANS = {
    "A": Span(1e-30, 1e6),
    "Ah": Span(1e-6, 1e6),
    "C": Span(1e-15, 1e3),
    "C-rate": Span(1e-6, 1e3),
    "F": Span(1e-18, 1e6),
    "H": Span(1e-15, 1e3),
    "Hz": Span(1e-9, 1e10),
    "J/K": Span(1e-3, 1e9),
    "K": Span(1e-9, 1e4),
    "K/W": Span(1e-9, 1e15),
    "V": Span(1e-9, 1e6),
    "W": Span(1e-9, 1e12),
    "W/m2": Span(1e-9, 1e4),
    "degC": Span(1e-9, 1e4, -273.15),
    "h": Span(1e-12, YEARS_S / 3600.0),
    "ohm": Span(1e-12, 1e9),
    "s": Span(1e-15, YEARS_S),
}
_OTHERS = Span(0.0, 1e15)
MOST_COUNT = 10**9
_SEED = 2**63 - 1
_UNIT = re.compile(r"\[([^\[\]]+)\]$")


def _exact(schema: Any, span: Span | None = None, most: int = MOST_COUNT) -> Any:
    """Return a schema that makes no number or truth value of another kind, with the bounds that it lacks."""
    if isinstance(schema, list | tuple):
        return type(schema)(_exact(part, span, most) for part in schema)
    if not isinstance(schema, dict):
        return schema
    kind = schema.get("type")
    if kind == "bool":
        return {**schema, "strict": True}
    if kind == "float":
        return _bounded({**schema, "strict": True}, span or _OTHERS)
    if kind == "int" and not schema.get("strict"):
        whole = {"type": "no-info", "function": _whole}
        low = {} if {"ge", "gt"} & set(schema) else {"ge": -most}
        high = {} if {"le", "lt"} & set(schema) else {"le": most}
        return {"type": "function-before", "function": whole, "schema": {**schema, **low, **high, "strict": True}}
    left = ("metadata", "cls", "serialization", "keys_schema")
    return {key: part if key in left else _exact(part, span, most) for key, part in schema.items()}


def _bounded(schema: dict[str, Any], span: Span) -> dict[str, Any]:
    if not {"le", "lt"} & set(schema):
        schema["le"] = span.most
    if not {"ge", "gt"} & set(schema):
        schema["ge"] = -span.most if span.low is None else span.low
    if schema.get("gt") != 0 or not span.least:
        return schema

    def at_least(value: float) -> float:
        if value < span.least:
            raise ValueError(f"{value:g} is less than anything of its kind; allowed is {span.least:g} or more")
        return value

    return {"type": "function-after", "function": {"type": "no-info", "function": at_least}, "schema": schema}


def _whole(value: Any) -> Any:
    """Return a float without a fraction as the integer that it is; everything else as it is."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _fields(schema: Any, record: type[BaseModel]) -> Any:
    """Return the schema of a record with each field's numbers bounded by its unit; other records have their own."""
    if not isinstance(schema, dict):
        return schema
    if schema.get("type") == "model-fields":
        named = {}
        for name, part in schema["fields"].items():
            unit = _UNIT.search(record.model_fields[name].description or "")
            span = SPANS.get(unit[1]) if unit else None
            named[name] = _exact(part, span, _SEED if name == "seed" else MOST_COUNT)
        return {**_exact({key: part for key, part in schema.items() if key != "fields"}), "fields": named}
    if schema.get("type") == "definitions":
        return {**schema, "schema": _fields(schema["schema"], record)}
    return {key: _fields(part, record) if key == "schema" else part for key, part in schema.items()}


class Record(BaseModel):
    """A frozen record; an unknown key, NaN or infinity is refused, and a word or a truth value as a number."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, populate_by_name=True)

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Return the schema with every number and truth value in it taken as it is, none made of another kind."""
        return _fields(handler(source), cls)  # type: ignore[no-any-return]


class Reference(Record):
    """A value that another step finds: `{from: search, value: frequency_hz}`; an edge of the plan."""

    source: str = Field(alias="from", min_length=1, description="name of the step that finds the value")
    value: str = Field(min_length=1, description="name of the value among those that step found")


Number = float | Reference
"""A number written in the configuration, or a reference to one that is found."""


NOT_GIVEN = "not given"
"""How the source of a value begins that stands in the place of one that a data sheet leaves out."""

FileOffset: TypeAlias = Annotated[
    float | None,
    Field(
        ge=-12,
        le=14,
        description="local time less universal time, for a file whose times carry an offset; without, they are local "
        "as they stand there [h]",
    ),
]
"""The key `utc_offset_h` of a record that names a file."""

Label: TypeAlias = Literal["auto", "start", "middle", "end"]
"""Where in its interval a row's time stands; `auto`: as the format has it, the end where 24:00 occurs, or the start."""


class OwnFile(Record):
    """How a person's own file is read; what it does not say is found in the file, and told."""

    file: str = Field(description="CSV, Parquet or Excel file, compressed or not; relative to the working folder")
    sheet: str | None = Field(default=None, description="sheet of an Excel file, or file of a zip archive")
    columns: dict[str, str] = Field(default_factory=dict, description="quantity -> heading of its column in the file")
    units: dict[str, str] = Field(
        default_factory=dict, description="quantity -> its unit in the file, over the heading"
    )
    decimal: Literal["auto", ".", ","] = Field(default="auto", description="decimal sign of a text file")
    label: Label = Field(default="auto", description="what a row's time is of its interval: start, middle or end")
    time_format: str | None = Field(default=None, description="how times are written, as %d/%m/%Y %H:%M of strptime")
    time_zone: str | None = Field(
        default=None,
        description="zone of times that carry no offset, as Europe/Berlin with its daylight saving, or UTC",
    )
    utc_offset_h: FileOffset = None
    missing: tuple[str, ...] = Field(
        default=(), description="what stands where nothing was measured, as -999; such rows are gaps"
    )

    @field_validator("columns", "units", mode="before")
    @classmethod
    def _without_empty(cls, value: object) -> object:
        """Leave out quantities of which nothing is said, which stand in a configuration to be overridden."""
        if isinstance(value, Mapping):
            return {key: one for key, one in value.items() if one is not None}
        return {} if value is None else value

    @field_validator("missing", mode="before")
    @classmethod
    def _as_text(cls, value: object) -> object:
        given = [] if value is None else value
        return (
            [str(one) if isinstance(one, int | float) else one for one in given]
            if isinstance(given, list | tuple)
            else given
        )

    @field_validator("time_zone")
    @classmethod
    def _known_zone(cls, value: str | None) -> str | None:
        if value is None:
            return None
        import zoneinfo

        from pipeline.errors import best_matches

        known = zoneinfo.available_timezones()
        if value not in known:
            raise ValueError(f"time_zone is {value!r}, which is none of the IANA zones; {best_matches(value, known)}")
        return value
