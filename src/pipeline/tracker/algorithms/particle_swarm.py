"""A particle swarm over the duty, which looks at all of the curve and so is not caught on a local maximum.

A particle is tried in each period. When the swarm is done its best duty is kept and followed by perturb and observe,
until the power jumps or some time has passed. The weights are values of the logistic map, of which there are two.
Miyatake, Veerachary, Toriumi, Fujii and Ko, IEEE Trans. Aerosp. Electron. Syst. 47 (2011) 367,
DOI 10.1109/TAES.2011.5705681.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.jit import inlined
from pipeline.tracker.algorithms import perturb_observe
from pipeline.tracker.algorithms.moves import BEGUN
from pipeline.tracker.records import ParticleSwarm, Scales

Array = NDArray[np.float64]

_HEAD = 12
_DETUNING = 0.1234567
TURN, ROUND, BEST_DUTY, BEST_POWER, FIRST, SECOND, WAITED, LAST = range(4, _HEAD)
"""Places in the memory after those of perturb and observe; particles follow: duty, velocity, best duty, best power."""

_observe = perturb_observe.decide


def numbers(settings: ParticleSwarm, scales: Scales) -> list[float]:
    """Return step, particles, iterations, W, C1, C2, restart share and periods, limits of the duty, chaos' start."""
    periods = settings.restart_period_s / settings.perturbation_period_s
    return [
        *(settings.duty_step, float(settings.particles), float(settings.iterations)),
        *(settings.inertia, settings.c1, settings.c2, settings.restart_share, periods),
        *(settings.least_duty, settings.most_duty, settings.chaos_start),
    ]


def memory_size(settings: ParticleSwarm) -> int:
    """Return how many numbers it remembers."""
    return _HEAD + 4 * settings.particles


@inlined
def decide(voltage: float, current: float, duty: float, memory: Array, own: Array) -> float:
    """Return the next duty; `memory` begins with zeros."""
    power, particles = voltage * current, int(own[1])
    if memory[FIRST] == 0.0:
        memory[FIRST], memory[SECOND] = own[10], abs(own[10] - _DETUNING) + 1e-3
        return _start(memory, own, particles)
    turn = int(memory[TURN])
    if turn < 0:
        return _follow(voltage, current, duty, memory, own, particles)
    _learn(memory, particles, turn, power)
    if turn + 1 < particles:
        memory[TURN] = turn + 1.0
        return float(memory[_HEAD + turn + 1])
    memory[ROUND] += 1.0
    if memory[ROUND] > own[2]:
        memory[TURN], memory[WAITED], memory[LAST], memory[BEGUN] = -1.0, 0.0, -1.0, 0.0
        return float(memory[BEST_DUTY])
    _move(memory, own, particles)
    memory[TURN] = 0.0
    return float(memory[_HEAD])


@inlined
def _start(memory: Array, own: Array, particles: int) -> float:
    """Spread the particles evenly over the duties, without velocity."""
    for place in range(particles):
        memory[_HEAD + place] = own[8] + (own[9] - own[8]) * (place + 0.5) / particles
        memory[_HEAD + particles + place] = 0.0
        memory[_HEAD + 3 * particles + place] = -1.0
    memory[TURN], memory[ROUND], memory[BEST_POWER] = 0.0, 0.0, -1.0
    return float(memory[_HEAD])


@inlined
def _learn(memory: Array, particles: int, place: int, power: float) -> None:
    if power > memory[_HEAD + 3 * particles + place]:
        memory[_HEAD + 3 * particles + place] = power
        memory[_HEAD + 2 * particles + place] = memory[_HEAD + place]
    if power > memory[BEST_POWER]:
        memory[BEST_POWER], memory[BEST_DUTY] = power, memory[_HEAD + place]


@inlined
def _move(memory: Array, own: Array, particles: int) -> None:
    for place in range(particles):
        here = memory[_HEAD + place]
        first, second = _chaotic(memory, FIRST), _chaotic(memory, SECOND)
        velocity = own[3] * memory[_HEAD + particles + place]
        velocity += own[4] * first * (memory[_HEAD + 2 * particles + place] - here)
        velocity += own[5] * second * (memory[BEST_DUTY] - here)
        memory[_HEAD + particles + place] = velocity
        memory[_HEAD + place] = min(max(here + velocity, own[8]), own[9])


@inlined
def _chaotic(memory: Array, which: int) -> float:
    """Return a stream's next value, r = 4; from a point that ends in a fixed point at once it goes on elsewhere."""
    value = 4.0 * memory[which] * (1.0 - memory[which])
    if 4.0 * value == np.floor(4.0 * value):
        value = _DETUNING
    memory[which] = value
    return float(value)


@inlined
def _follow(voltage: float, current: float, duty: float, memory: Array, own: Array, particles: int) -> float:
    power, last = voltage * current, memory[LAST]
    memory[WAITED] += 1.0
    memory[LAST] = power
    jumped = last > 0.0 and abs(power - last) > own[6] * last
    if jumped or memory[WAITED] > own[7]:
        return _start(memory, own, particles)
    return _observe(voltage, current, duty, memory, own)
