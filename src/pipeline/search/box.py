"""The box a search looks in, and the settings every search shares; light to import."""

from __future__ import annotations

from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, ValidationError, model_validator

from pipeline.record import Record


class Interval(Record):
    """The range of one variable."""

    low: float = Field(description="lower end, in the variable's unit")
    high: float = Field(description="upper end, in the variable's unit")

    @model_validator(mode="after")
    def _rises(self) -> Interval:
        if self.low >= self.high:
            raise ValueError(f"low is {self.low:g}; it must lie below high, {self.high:g}")
        return self


class SearchSettings(Record):
    """What every search has; each algorithm adds its own."""

    kind: str = Field(pattern=r"^[a-z][a-z0-9_]*$", description="name of the algorithm")
    title: str = Field(min_length=1, description="name of the search, for people")
    variables: dict[str, Interval] = Field(min_length=1, description="the box: variable -> range")
    replicates: int = Field(default=1, ge=1, description="independent searches, each with a random stream of its own")
    variants: dict[str, dict[str, Any]] = Field(
        default_factory=dict, description="searches run beside this one: name -> settings that differ"
    )

    @model_validator(mode="after")
    def _variants_read(self) -> Self:
        for name in self.variants:
            try:
                self.variant(name)
            except ValidationError as error:
                first = error.errors(include_url=False)[0]
                key = ".".join(str(part) for part in first["loc"])
                raise ValueError(f"variants.{name}.{key}: {first['msg']} (value {first['input']!r})") from None
        return self

    def variant(self, name: str) -> Self:
        """Return the settings of a search that is run beside this one."""
        own = self.model_dump(by_alias=True, exclude={"variants"})
        return type(self).model_validate(own | self.variants[name])

    def box(self) -> Box:
        """Return the box as arrays, the variables in the order in which they are written."""
        low = np.array([interval.low for interval in self.variables.values()])
        return Box(low, np.array([interval.high for interval in self.variables.values()]))


class Box(NamedTuple):
    """Lower and upper ends, shape (d,) each."""

    low: NDArray[np.float64]
    high: NDArray[np.float64]
