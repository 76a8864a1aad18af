"""Particle swarm with uniform, chaotic or arcsine `Rand` (eq. 2-4), all replicates advanced together as arrays.

Eberhart and Kennedy (1995), DOI 10.1109/MHS.1995.494215, with the inertia weight of Shi and Eberhart (1998), DOI
10.1109/ICEC.1998.699146. The paper states neither the size of the swarm nor any limit on velocity and position, without
which inertia 1 diverges; here both limits are settings.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from pipeline.record import Number, Reference
from pipeline.search.box import Box, History, Objective, SearchSettings
from pipeline.search.streams import STREAMS, Generators, Rand, generators

Array = NDArray[np.float64]
Knob = float | Array
"""A number, or one per replicate."""


class Settings(SearchSettings):
    """The swarm's settings; `c1`, `c2` and `w` may be references to what a tuning finds."""

    kind: Literal["swarm"] = "swarm"
    rand: Rand = Field(description="what the two Rand of eq. (2) are")
    particles: int = Field(ge=2, description="particles of the swarm")
    iterations: int = Field(ge=1, description="moves of the swarm, after its random start")
    c1: Number = Field(description="learning constant C1, towards the particle's own best [1]")
    c2: Number = Field(description="learning constant C2, towards the swarm's best [1]")
    w: Number = Field(description="inertia weight W [1]")
    velocity_limit: float = Field(gt=0, le=1, description="largest velocity over the width of the box [1]")
    position_limit: Literal["clamp", "reflect"] = Field(
        description="clamp: stop at the wall; reflect: come back from it as far as it was passed"
    )


class Knobs(NamedTuple):
    """W, C1 and C2 of eq. (2): numbers, or an array (r,) with a value per replicate."""

    w: Knob
    c1: Knob
    c2: Knob


class State(NamedTuple):
    """The swarm between two moves, for r replicates of n particles in d dimensions."""

    position: Array
    """Shape (r, n, d)."""
    velocity: Array
    """Shape (r, n, d)."""
    own_position: Array
    """Best position of each particle, shape (r, n, d)."""
    own_value: Array
    """Its value, shape (r, n)."""
    best_position: Array
    """Best position of each swarm, shape (r, d)."""
    best_value: Array
    """Its value, shape (r,)."""


def knobs(settings: Settings) -> Knobs:
    """Return the plain numbers of the settings.

    Raises
    ------
    ValueError : one is still a reference to something not yet found.
    """
    return Knobs(_number("w", settings.w), _number("c1", settings.c1), _number("c2", settings.c2))


def begin(box: Box, particles: int, random: Generators) -> State:
    """Return swarms at rest, uniformly in the box, not yet evaluated."""
    shape = (particles, len(box.low))
    share = np.stack([generator.random(shape) for generator in random])
    position = box.low + share * (box.high - box.low)
    replicates = len(share)
    return State(
        position,
        np.zeros_like(position),
        position,
        np.full((replicates, particles), np.inf),
        position[:, 0],
        np.full(replicates, np.inf),
    )


def learn(state: State, values: Array) -> State:
    """Return the state after its positions have been evaluated, `values` (r, n): new own and common bests."""
    better = values < state.own_value
    own_value = np.where(better, values, state.own_value)
    own_position = np.where(better[..., None], state.position, state.own_position)
    leader = np.argmin(own_value, axis=1)
    rows = np.arange(len(leader))
    return state._replace(
        own_value=own_value,
        own_position=own_position,
        best_position=own_position[rows, leader],
        best_value=own_value[rows, leader],
    )


def move(settings: Settings, knobs: Knobs, box: Box, state: State, rand: Array) -> State:
    """Return the state after eq. (2) and (3), within the limits.

    Arguments
    ---------
    settings : the limits.
    knobs : W, C1, C2.
    box : where the particles may be.
    state : the swarms after `learn`.
    rand : numbers in [0, 1], shape (r, 2, n, d): the two independent Rand of every particle and dimension.
    """
    w, c1, c2 = (np.reshape(np.asarray(knob, dtype=float), (-1, 1, 1)) for knob in knobs)
    limit = settings.velocity_limit * (box.high - box.low)
    velocity = w * state.velocity
    velocity += c1 * rand[:, 0] * (state.own_position - state.position)
    velocity += c2 * rand[:, 1] * (state.best_position[:, None] - state.position)
    velocity = np.clip(velocity, -limit, limit)
    free = state.position + velocity
    inside = np.clip(free, box.low, box.high)
    if settings.position_limit == "reflect":
        # A velocity is at most the width of the box, so one reflection is enough.
        return state._replace(position=2.0 * inside - free, velocity=np.where(free == inside, velocity, -velocity))
    return state._replace(position=inside, velocity=np.where(free == inside, velocity, 0.0))


def step(settings: Settings, knobs: Knobs, box: Box, state: State, values: Array, rand: Array) -> State:
    """Return the next state from the values (r, n) of the present positions: learn, then move."""
    return move(settings, knobs, box, learn(state, values), rand)


def minimise(objective: Objective, box: Box, settings: Settings, rng: np.random.Generator) -> History:
    """Run one search.

    Arguments
    ---------
    objective : positions (n, d) to values (n,).
    box : where to look.
    settings : the swarm's settings; its number of replicates does not count here.
    rng : where all its random numbers come from.

    Returns
    -------
    History of one replicate, a row for the start and for each move.
    """
    return run(objective, box, settings, knobs(settings), [rng])


def replicate(objective: Objective, box: Box, settings: Settings, seed: int) -> History:
    """Run all replicates together; number i is what `minimise` finds with SeedSequence([seed, i])."""
    return run(objective, box, settings, knobs(settings), generators(seed, 0, settings.replicates))


def run(objective: Objective, box: Box, settings: Settings, knobs: Knobs, random: Generators) -> History:
    """Run one search per generator, all advanced together; the objective sees all their particles at once."""
    state = begin(box, settings.particles, random)
    replicates, particles, dimensions = state.position.shape
    rows = settings.iterations + 1
    position, value = np.empty((replicates, rows, dimensions)), np.empty((replicates, rows))
    rands = STREAMS[settings.rand](random, (2, particles, dimensions), settings.iterations)
    for row in range(rows):
        if row > 0:
            state = move(settings, knobs, box, state, next(rands))
        values = objective(state.position.reshape(-1, dimensions)).reshape(replicates, particles)
        state = learn(state, values)
        position[:, row], value[:, row] = state.best_position, state.best_value
    counted = particles * np.arange(1, rows + 1, dtype=np.int64)
    return History(np.broadcast_to(counted, (replicates, rows)).copy(), position, value)


def _number(name: str, value: Number) -> float:
    if isinstance(value, Reference):
        raise ValueError(f"{name} is {value.value} of {value.source}, which has not been found yet")
    return float(value)
