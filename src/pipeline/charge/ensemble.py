"""Samples over the ranges of estimated parameters, to see how far a claim depends on the estimates."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import Field

from pipeline.record import Record

Ranges = Mapping[str, tuple[float, float]]


class EnsembleSettings(Record):
    """How the estimated parameters are sampled."""

    samples: int = Field(default=32, ge=0, le=10_000, description="samples; 0 leaves the ensemble out [1]")
    pulse_frequency_hz: float = Field(
        default=10.0, gt=0, description="frequency of every pulse in the samples, low to be quick [Hz]"
    )


def draw(ranges: Ranges, followers: Mapping[str, str], samples: int, seed: int) -> list[dict[str, float]]:
    """Draw a Latin hypercube over the ranges.

    Arguments
    ---------
    ranges : key path -> lowest and highest value. Knobs of one name and one range are one parameter in all modes,
        so that modes stay comparable.
    followers : key path -> the path whose value it takes.
    samples : number of samples.
    seed : seed of the draw.

    Returns
    -------
    A mapping key path -> value for each sample.
    """
    from scipy.stats import qmc

    shared = {path: _shared_name(path, ranges[path]) for path in sorted(ranges)}
    names = sorted(set(shared.values()))
    if not names:
        return [{} for _ in range(samples)]
    unit = qmc.LatinHypercube(d=len(names), rng=seed).random(samples)
    place = {name: column for column, name in enumerate(names)}
    drawn = [
        {path: low + (high - low) * float(row[place[shared[path]]]) for path, (low, high) in ranges.items()}
        for row in unit
    ]
    return [values | {path: values[other] for path, other in followers.items()} for values in drawn]


def with_values(tree: Mapping[str, Any], values: Mapping[str, float]) -> dict[str, Any]:
    """Return a copy of a plain tree with the values at some key paths replaced.

    Raises
    ------
    KeyError : a path that is not there.
    """
    result = {key: with_values(item, {}) if isinstance(item, Mapping) else item for key, item in tree.items()}
    for path, value in values.items():
        here = result
        *parents, last = path.split(".")
        for key in parents:
            here = here[key]
        if last not in here:
            raise KeyError(path)
        here[last] = value
    return result


def _shared_name(path: str, limits: tuple[float, float]) -> str:
    keys = path.split(".")
    if keys[0] == "modes":
        return f"modes.*.{'.'.join(keys[2:])} {limits[0]:.17g} {limits[1]:.17g}"
    return path
