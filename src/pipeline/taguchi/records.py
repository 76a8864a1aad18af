"""A parameter design as `conf/design/*.yaml` gives it; light to import."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, model_validator

from pipeline.record import Record


class Design(Record):
    """Factors with their levels, and the runs of the array."""

    title: str = Field(min_length=1, description="name of the design, for people")
    factors: dict[str, tuple[float, ...]] = Field(min_length=1, description="factor -> its levels, L1 first [1]")
    array: str | tuple[tuple[int, ...], ...] = Field(
        description="a row per run, in it the number of each factor's level from 1; or a standard array, `L16(4^5)`"
    )
    printed: str | None = Field(
        default=None, description="table of a paper's results for these factors, in conf/published/reference"
    )
    replicates: int = Field(ge=1, description="searches per run of the array, each with a random stream of its own")
    factorial_replicates: int = Field(
        ge=0, description="searches per combination of the full factorial that checks the array; 0: none"
    )
    statistic: Literal["cumulative", "final"] = Field(
        description="what a search counts for: the best value summed over its iterations, or the best at its end"
    )

    @model_validator(mode="after")
    def _levels_exist(self) -> Design:
        for name, levels in self.factors.items():
            if len(set(levels)) != len(levels) or len(levels) < 2:
                raise ValueError(f"factors.{name} is {list(levels)}; it must hold two or more levels, all different")
        if isinstance(self.array, str):
            return self
        counts = [len(levels) for levels in self.factors.values()]
        for number, row in enumerate(self.array, start=1):
            if len(row) != len(counts):
                raise ValueError(f"array row {number} has {len(row)} entries; the design has {len(counts)} factors")
            for (name, levels), level in zip(self.factors.items(), row, strict=True):
                if not 1 <= level <= len(levels):
                    raise ValueError(
                        f"array row {number} has level {level} of {name}; its levels are 1 to {len(levels)}"
                    )
        return self
