"""A study of searches on test functions, as it is configured; light to import."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal, get_args

from pydantic import Field, field_validator, model_validator

from pipeline.errors import best_matches
from pipeline.record import Record
from pipeline.search.box import SearchSettings
from pipeline.search.registry import settings_from

Placement = Literal["centred", "shifted", "rotated"]
PLACEMENTS: tuple[Placement, ...] = get_args(Placement)
CENTRED, SHIFTED, ROTATED = PLACEMENTS

HALF_WIDTHS = {
    "sphere": 5.12,
    "schwefel_222": 10.0,
    "schwefel_12": 100.0,
    "rosenbrock": 2.048,
    "rastrigin": 5.12,
    "griewank": 600.0,
    "ackley": 32.768,
}
"""Test function -> half the width of its usual cube around the origin."""


class SearchGroup(Record):
    """Searches with one budget: what they share, and what each has of its own."""

    replicates: int = Field(ge=2, description="independent runs of each search [1]")
    shared: dict[str, Any] = Field(default_factory=dict, description="settings of every search of the group")
    searches: dict[str, dict[str, Any]] = Field(
        min_length=1, description="name -> its own settings, its kind among them"
    )

    def settings(self, name: str, dimensions: int, half_width: float) -> SearchSettings:
        """Return the settings of a search on a cube of so many dimensions."""
        edge = {"low": -half_width, "high": half_width}
        variables = {f"x{number}": edge for number in range(1, dimensions + 1)}
        own = {"title": name} | self.shared | self.searches[name]
        read: SearchSettings = settings_from(own | {"replicates": self.replicates, "variables": variables})
        return read


class FunctionStudy(Record):
    """Which searches run on which functions; every function in every placement."""

    dimensions: int = Field(ge=2, le=1000, description="dimensions of every function [1]")
    functions: tuple[str, ...] = Field(min_length=1, description="names of the functions")
    placements: tuple[Placement, ...] = Field(default=PLACEMENTS, description="where their minima are put")
    shift_share: float = Field(gt=0, le=1, description="farthest a minimum is moved, over half the cube's width [1]")
    threshold: float = Field(gt=0, description="value at which a run counts as successful; every minimum is 0 [1]")
    plain: str = Field(description="the variant that the others are held against")
    variants: SearchGroup = Field(description="the searches under examination, run side by side from the same starts")
    baselines: SearchGroup | None = Field(default=None, description="other searches, at a budget of their own")

    @field_validator("functions")
    @classmethod
    def _known(cls, functions: tuple[str, ...]) -> tuple[str, ...]:
        for name in functions:
            if name not in HALF_WIDTHS:
                raise ValueError(f"no test function {name!r}; {best_matches(name, HALF_WIDTHS)}")
        _check_once(functions)
        return functions

    @field_validator("placements")
    @classmethod
    def _placed_once(cls, placements: tuple[Placement, ...]) -> tuple[Placement, ...]:
        if not placements:
            raise ValueError(f"placements is empty; allowed are {', '.join(PLACEMENTS)}")
        _check_once(placements)
        return placements

    @model_validator(mode="after")
    def _complete(self) -> FunctionStudy:
        if self.plain not in self.variants.searches:
            raise ValueError(f"plain is {self.plain!r}, no variant; {best_matches(self.plain, self.variants.searches)}")
        twice = set(self.variants.searches) & set(self.baselines.searches if self.baselines else ())
        if twice:
            raise ValueError(f"{', '.join(sorted(twice))}: both a variant and a baseline; give each search one name")
        self.searches(1.0)
        return self

    def searches(self, half_width: float) -> dict[str, SearchSettings]:
        """Return every search, the variants first, on a cube of a half width."""
        groups = [self.variants, *([self.baselines] if self.baselines else [])]
        return {name: group.settings(name, self.dimensions, half_width) for group in groups for name in group.searches}

    def loops(self) -> list[str]:
        """Return the searches that are cuckoo searches, which the paper reads as control loops."""
        return [name for name, settings in self.searches(1.0).items() if settings.kind == "cuckoo"]

    def kinds(self) -> set[str]:
        """Return the algorithms that are used."""
        return {settings.kind for settings in self.searches(1.0).values()}


def _check_once(names: Sequence[str]) -> None:
    if len(set(names)) < len(names):
        raise ValueError(f"{list(names)}: each may stand there once")
