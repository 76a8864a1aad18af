"""How the logistic map is looked at, as a study gives it; light to import."""

from __future__ import annotations

from pydantic import Field, model_validator

from pipeline.record import Record


class ChaosSettings(Record):
    """The orbits of the map x -> r x (1 - x) and the measures of its disorder."""

    start: float = Field(gt=0, lt=1, description="where every orbit begins [1]")
    orbit_steps: int = Field(ge=2, description="steps of the orbit at r = 4, from its start [1]")
    r_low: float = Field(gt=0, lt=4, description="lowest parameter r [1]")
    r_points: int = Field(ge=2, description="parameters from the lowest to 4, both included [1]")
    transient: int = Field(ge=0, description="steps left out before anything over r is counted [1]")
    bifurcation_steps: int = Field(ge=1, description="values kept for each r [1]")
    disorder_steps: int = Field(ge=100, description="steps over which disorder is measured, for each r [1]")
    bins: tuple[int, ...] = Field(min_length=1, description="numbers of equal bins that visits are counted in [1]")

    @model_validator(mode="after")
    def _chaotic(self) -> ChaosSettings:
        if 4.0 * self.start in (1.0, 2.0, 3.0):
            raise ValueError(f"start is {self.start:g}, whose orbit at r = 4 ends in a fixed point; take another")
        if min(self.bins) < 2 or len(set(self.bins)) < len(self.bins):
            raise ValueError(f"bins is {list(self.bins)}; each must be 2 or more and stand there once")
        return self
