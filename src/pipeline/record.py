"""The base of every parameter record, frozen and strict about keys and kinds; the record of a person's own file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, GetCoreSchemaHandler, field_validator
from pydantic_core import CoreSchema


def _exact(schema: Any) -> Any:
    if isinstance(schema, list):
        return [_exact(part) for part in schema]
    if isinstance(schema, tuple):
        return tuple(_exact(part) for part in schema)
    if not isinstance(schema, dict):
        return schema
    kind = schema.get("type")
    if kind in ("float", "bool"):
        return {**schema, "strict": True}
    if kind == "int" and not schema.get("strict"):
        whole = {"type": "no-info", "function": _whole}
        return {"type": "function-before", "function": whole, "schema": {**schema, "strict": True}}
    return {key: part if key in ("metadata", "cls", "serialization") else _exact(part) for key, part in schema.items()}


def _whole(value: Any) -> Any:
    """Return a float without a fraction as the integer that it is; everything else as it is."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


class Record(BaseModel):
    """A frozen record; an unknown key, NaN or infinity is refused, and a word or a truth value as a number."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, populate_by_name=True)

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Return the schema with every number and truth value in it taken as it is, none made of another kind."""
        return _exact(handler(source))  # type: ignore[no-any-return]


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
