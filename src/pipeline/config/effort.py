"""What a run is likely to take, held against limits when it is planned, before anything is computed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pydantic import Field

from pipeline.config.choices import told
from pipeline.config.compose import Composed
from pipeline.errors import UserError
from pipeline.kernel.experiment import Draft, Effort
from pipeline.record import Record

GIB = 2.0**30


class Limits(Record):
    """What a run may take; stands in no key, so that raising it computes nothing anew."""

    memory_gib: float = Field(default=2.0, gt=0, le=65_536, description="memory of a job, by estimate [GiB]")
    hours: float = Field(default=8.0, gt=0, le=1e6, description="time of one core for the whole run, by estimate [h]")


def check_effort(composed: Composed, study: Any, made: Sequence[Draft]) -> None:
    """Refuse a run that would take more than its limits.

    Raises
    ------
    UserError : with what it grows with, what it is likely to take, the limit, and how that is raised.
    """
    known = [(node, node.effort) for node in made if node.effort is not None and node.effort.grows_with]
    if not known:
        return
    most: float = study.limits.memory_gib * GIB
    for node, effort in known:
        if effort.memory_b > most:
            taken = f"{_plain(effort.memory_b / GIB)} GiB of memory"
            raise _refused(composed, node, effort, taken, f"{study.limits.memory_gib:g}", "memory_gib")
    total_s = sum(effort.time_s for _, effort in known)
    if total_s > 3600.0 * study.limits.hours:
        node, effort = max(known, key=lambda one: one[1].time_s)
        taken = f"{_plain(total_s / 3600.0)} h of one core's time"
        raise _refused(composed, node, effort, taken, f"{study.limits.hours:g}", "hours")


def _refused(composed: Composed, node: Draft, effort: Effort, taken: str, limit: str, name: str) -> UserError:
    words = {path: composed.touched(path) or composed.overridden(path) for path in effort.grows_with}
    path = next((path for path, word in words.items() if word is not None), effort.grows_with[0])
    word = words[path]
    where = composed.origin(path) if word is None else f"override {told(word)}"
    return UserError(
        f"{where}: {path}: the step {node.step} would take about {taken}; the limit is {limit}; "
        f"ask for less, or raise limits.{name}"
    )


def _plain(value: float) -> str:
    return f"{value:.2g}" if value < 10 else f"{value:,.0f}".replace(",", " ") if value < 1e6 else f"{value:.1e}"
