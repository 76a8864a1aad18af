"""The base of every parameter record: frozen, strict about its keys, finite in its numbers."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field


class Record(BaseModel):
    """A frozen record; an unknown key, NaN or infinity is refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, populate_by_name=True)


class Reference(Record):
    """A value that another step finds: `{from: search, value: frequency_hz}`; an edge of the plan."""

    source: str = Field(alias="from", min_length=1, description="name of the step that finds the value")
    value: str = Field(min_length=1, description="name of the value among those that step found")


Number = float | Reference
"""A number written in the configuration, or a reference to one that is found."""
