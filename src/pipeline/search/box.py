"""What is searched, and how a search went: a box, its objective, the history of its evaluations."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Annotated, Any, Literal, NamedTuple, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, ValidationError, model_validator

from pipeline.record import Record


class Interval(Record):
    """The range of one variable."""

    low: float = Field(description="lower end [unit of the variable]")
    high: float = Field(description="upper end [unit of the variable]")

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


def evaluations(settings: Mapping[str, Any]) -> float:
    """Return about how often a search evaluates its objective, with all its replicates: the product of its counts.

    Arguments
    ---------
    settings : of any algorithm, as plain data; what is written as no number counts once.
    """
    return math.prod(_counts(settings).values())


def kept_b(settings: Mapping[str, Any], dimensions: int) -> float:
    """Return about how much memory a search holds [B]: positions of all replicates, and their histories."""
    counts = _counts(settings)
    replicates = counts.pop("replicates", 1.0)
    return 4.0 * 8.0 * (dimensions + 2) * replicates * (sum(counts.values()) + 1.0)


def _counts(settings: Mapping[str, Any]) -> dict[str, float]:
    """Return the counts among settings: integers, and floats that can be nothing else."""
    numbers = {key: value for key, value in settings.items() if type(value) in (int, float)}
    return {
        key: float(value)
        for key, value in numbers.items()
        if value > 0 and (isinstance(value, int) or (value >= 10.0 and value.is_integer()))
    }


class Box(NamedTuple):
    """Lower and upper ends, shape (d,) each."""

    low: NDArray[np.float64]
    high: NDArray[np.float64]


class ChaosSettings(Record):
    """The orbits of the map x -> r x (1 - x) and the measures of its disorder."""

    start: float = Field(gt=0, lt=1, description="where every orbit begins [1]")
    orbit_steps: int = Field(ge=2, description="steps of the orbit at r = 4, from its start [1]")
    r_low: float = Field(gt=0, lt=4, description="lowest parameter r [1]")
    r_points: int = Field(ge=2, description="parameters from the lowest to 4, both included [1]")
    transient: int = Field(ge=0, le=10_000_000, description="steps left out before anything over r is counted [1]")
    bifurcation_steps: int = Field(ge=1, description="values kept for each r [1]")
    disorder_steps: int = Field(ge=100, description="steps over which disorder is measured, for each r [1]")
    bins: tuple[Annotated[int, Field(ge=2, le=1_000_000)], ...] = Field(
        min_length=1, max_length=64, description="numbers of equal bins that visits are counted in [1]"
    )

    @model_validator(mode="after")
    def _chaotic(self) -> ChaosSettings:
        if 4.0 * self.start in (1.0, 2.0, 3.0):
            raise ValueError(f"start is {self.start:g}, whose orbit at r = 4 ends in a fixed point; take another")
        if min(self.bins) < 2 or len(set(self.bins)) < len(self.bins):
            raise ValueError(f"bins is {list(self.bins)}; each must be 2 or more and stand there once")
        return self


class CuckooSettings(SearchSettings):
    """The settings of cuckoo search; as they stand by default it is plain cuckoo search."""

    kind: Literal["cuckoo"] = "cuckoo"
    nests: int = Field(ge=3, description="nests [1]")
    generations: int = Field(ge=1, description="flights and walks of all nests, after their random start [1]")
    pa: float = Field(default=0.25, ge=0, le=1, description="chance that a coordinate of a nest takes the walk [1]")
    step_scale: float = Field(default=0.01, gt=0, description="Levy step over the distance to the best nest [1]")
    levy_exponent: float = Field(default=1.5, gt=1, lt=2, description="exponent of the Levy law [1]")
    inertia: float = Field(default=1.0, ge=0, le=1, description="weight w of a nest's own position; 1: plain [1]")
    inertia_end: float | None = Field(
        default=None, ge=0, le=1, description="weight in the last generation, falling evenly; none: constant [1]"
    )
    ki: float = Field(default=0.0, ge=0, description="integral constant Ki; 0: plain [1]")
    leak: float = Field(default=0.9, ge=0, le=1, description="share of the integral that a generation keeps [1]")

    def weights(self) -> NDArray[np.float64]:
        """Return the inertia of every generation."""
        return np.linspace(
            self.inertia, self.inertia if self.inertia_end is None else self.inertia_end, self.generations
        )


Array: TypeAlias = NDArray[np.float64]
Objective: TypeAlias = Callable[[Array], Array]
"""A whole population at once: positions (n, d) to values (n,)."""


class History(NamedTuple):
    """The course of r replicates over t rows each; row 0 is what the search began with."""

    evaluations: NDArray[np.int64]
    """Evaluations of the objective so far, shape (r, t)."""
    position: Array
    """Best position so far, shape (r, t, d)."""
    value: Array
    """Its value, shape (r, t); never rises along t."""

    def best_position(self) -> Array:
        """Return where each replicate ended, shape (r, d)."""
        return self.position[:, -1]

    def best_value(self) -> Array:
        """Return the value with which each replicate ended, shape (r,)."""
        return self.value[:, -1]

    def columns(self, variables: Iterable[str]) -> dict[str, NDArray[np.float64] | NDArray[np.int64]]:
        """Return the history as a table, a row per replicate and iteration, a column per variable."""
        replicates, rows = self.value.shape
        table: dict[str, NDArray[np.float64] | NDArray[np.int64]] = {
            "replicate": np.repeat(np.arange(replicates), rows),
            "iteration": np.tile(np.arange(rows), replicates),
            "evaluations": self.evaluations.ravel(),
        }
        for index, name in enumerate(variables):
            table[name] = self.position[:, :, index].ravel()
        table["value"] = self.value.ravel()
        return table


def joined(histories: list[History]) -> History:
    """Return histories of equally many rows as one, replicate after replicate."""
    return History(*(np.concatenate(parts) for parts in zip(*histories, strict=True)))


def iterations_until(reached: NDArray[np.bool_]) -> Array:
    """Return the first iteration from which on a condition holds to the end.

    Arguments
    ---------
    reached : whether the condition holds, shape (r, t).

    Returns
    -------
    Iteration, shape (r,); infinite where the condition does not hold at the end.
    """
    rows = reached.shape[1]
    held = np.logical_and.accumulate(reached[:, ::-1], axis=1).sum(axis=1)
    return np.where(held > 0, (rows - held).astype(float), np.inf)


class Recorder:
    """An objective that remembers how often it was asked and its best answer."""

    def __init__(self, objective: Objective) -> None:
        self._objective = objective
        self._best: tuple[Array | None, float] = (None, np.inf)
        self.count = 0
        self._rows: list[tuple[int, Array, float]] = []

    def __call__(self, x: Array) -> Array:
        """Return the values (n,) of positions (n, d)."""
        values = self._objective(np.ascontiguousarray(x))
        self.count += len(values)
        leader = int(np.argmin(values))
        if self._best[0] is None or values[leader] < self._best[1]:
            self._best = (np.array(x[leader], dtype=float), float(values[leader]))
        return values

    def mark(self) -> None:
        """End a row of the history."""
        position, value = self._best
        assert position is not None, "nothing has been evaluated yet"
        self._rows.append((self.count, position, value))

    def history(self, rows: int) -> History:
        """Return the history of one replicate; a search that stopped early stands still in its last rows."""
        kept = (self._rows + self._rows[-1:] * rows)[:rows]
        evaluations, position, value = zip(*kept, strict=True)
        return History(np.array([evaluations], dtype=np.int64), np.array([position]), np.array([value]))


def drive(
    make: Callable[[], Any], objective: Objective, box: Box, generations: int, rng: np.random.Generator
) -> History:
    """Run one search.

    Arguments
    ---------
    make : returns the algorithm.
    objective : positions (n, d) to values (n,).
    box : where to look.
    generations : how many, after the start.
    rng : where the seed of its random numbers comes from.

    Returns
    -------
    History of one replicate, a row for the start and for each generation.
    """
    from pymoo.core.problem import Problem

    recorder = Recorder(objective)

    class Boxed(Problem):  # type: ignore[misc]
        def _evaluate(self, x: Any, out: Any, *args: Any, **kwargs: Any) -> None:
            out["F"] = recorder(x)

    problem = Boxed(n_var=len(box.low), n_obj=1, xl=box.low, xu=box.high)
    algorithm = make()
    algorithm.setup(problem, termination=("n_gen", generations + 1), seed=int(rng.integers(2**31)), verbose=False)
    while algorithm.has_next():
        algorithm.next()
        recorder.mark()
    return recorder.history(generations + 1)
