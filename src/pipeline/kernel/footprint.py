"""What a job is to be given: cores, memory and time, from the effort of its nodes and what was measured beside it.

Nothing of this is part of a key: what a job is given changes nothing that it makes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from math import ceil
from typing import Any

from pipeline.kernel.experiment import Effort, Step

MEMORY_MARGIN = 1.25
TIME_MARGIN = 4.0
"""Estimates are good within a factor of a few, and a node of a cluster may be busy or slow."""
LEAST_MINUTES = 10
"""Also a short job may find the kernels not compiled yet, or a file server that is slow."""


@dataclass(frozen=True)
class Footprint:
    """A step's `effort` with what its jobs take beside that of their nodes.

    `tests/slurm/measured.json` holds what was measured, and a test holds the declared numbers against it.

    Arguments
    ---------
    effort : `(config, **which)` -> what a node is likely to take, where that can grow with the configuration.
    memory_mb : of the process with nodes of the usual size [MB].
    start_s : of one core, for imports and for loading kernels [s].
    node_s : of one core for a node, where its effort is less [s].
    threads : cores that it keeps busy.
    together : nodes that it holds in memory at once.
    """

    effort: Callable[..., Effort] | None = None
    memory_mb: float = 370.0
    start_s: float = 4.0
    node_s: float = 0.2
    threads: int = 1
    together: int = 1

    def __call__(self, config: Any, **which: Any) -> Effort:
        """Return what a node is likely to take; one whose effort does not grow: the time that was measured."""
        return Effort(0.0, self.node_s, ()) if self.effort is None else self.effort(config, **which)

    def work_s(self, effort: Effort | None) -> float:
        """Return the time of one core that a node is likely to take [s]."""
        return max(self.node_s, effort.time_s if effort is not None else 0.0)


def of_step(step: Step) -> Footprint:
    """Return what the jobs of a step take, the usual where its declaration does not say."""
    return step.effort if isinstance(step.effort, Footprint) else Footprint(step.effort)


def resources(footprint: Footprint, efforts: Iterable[Effort | None]) -> dict[str, int]:
    """Return what a job is to be given, as the plan holds it: `threads`, `mem_mb` [MB], `runtime` [min].

    Arguments
    ---------
    efforts : of its nodes.
    """
    nodes: Sequence[Effort | None] = list(efforts)
    largest = sorted((one.memory_b for one in nodes if one is not None), reverse=True)[: footprint.together]
    memory_mb = MEMORY_MARGIN * (footprint.memory_mb + sum(largest) / 1e6)
    minutes = TIME_MARGIN * (footprint.start_s + sum(map(footprint.work_s, nodes))) / 60.0
    return {
        "threads": footprint.threads,
        "mem_mb": 50 * ceil(memory_mb / 50.0),
        "runtime": max(LEAST_MINUTES, ceil(minutes)),
    }
