"""How the table of a sweep is named and read: prefixes of its columns, kinds of swept values, headlines."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from pipeline.kernel.tables import Kind

TABLE, CSV = "runs.parquet", "runs.csv"
MARKS = "time_to_soc_"
HEADLINES = {
    "peak_temperature_c": ("peak temperature", "°C", 1.0),
    "energy_efficiency": ("energy efficiency", "%", 100.0),
}
"""Quantities of a charge that are looked at first, in words, with unit and factor; before them the time."""


class Outcome(NamedTuple):
    """A column of the table of a sweep that is looked at first.

    `charge` is what the charge is called there; `title`, `unit` and `factor` are those in which it is shown.
    """

    column: str
    charge: str
    title: str
    unit: str
    factor: float


def prefixes(nodes: Iterable[str]) -> dict[str, str]:
    """Return name of a charge -> what the names of its columns begin with: its mode, and what tells it from others.

    Arguments
    ---------
    nodes : names of charges, `charge/<comparison>/<mode>`, of the second battery `second_charge/...`.
    """
    named = {node: node.split("/") for node in nodes}
    comparisons = {words[1] for words in named.values()}
    found = {}
    for node, (kind, comparison, mode) in named.items():
        own = [] if kind == "charge" else [kind.removesuffix("_charge")]
        found[node] = ".".join([*own, *([comparison] if len(comparisons) > 1 else []), mode])
    return found


def kind_of(values: Sequence[Any]) -> Kind:
    """Return the kind of column that holds some swept values."""
    given = [value for value in values if value is not None]
    if given and all(isinstance(value, bool) for value in given):
        return "truth"
    if given and all(isinstance(value, int) and not isinstance(value, bool) for value in given):
        return "integer"
    if given and all(isinstance(value, int | float) and not isinstance(value, bool) for value in given):
        return "number"
    return "text"


def outcomes(columns: Mapping[str, Any]) -> list[Outcome]:
    """Return the columns that are looked at first, charge by charge.

    The time is that to the highest SOC which half of the runs reach, the same for all charges.

    Arguments
    ---------
    columns : column -> values.
    """
    charges = [name.removesuffix(".end_time_s") for name in columns if name.endswith(".end_time_s")]
    reached: dict[str, list[float]] = {}
    for charge in charges:
        for name in (name for name in columns if name.startswith(f"{charge}.{MARKS}")):
            share = float(np.isfinite(np.asarray(columns[name], float)).mean())
            reached.setdefault(name.removeprefix(f"{charge}."), []).append(share)
    usual = [quantity for quantity, shares in reached.items() if np.mean(shares) >= 0.5]
    first = {quantity: (f"time to SOC {soc(quantity):g}", "h", 1.0 / 3600.0) for quantity in usual}
    last = dict(sorted(first.items(), key=lambda item: soc(item[0]))[-1:])
    last = last or {"end_time_s": ("time to the end", "h", 1.0 / 3600.0)}
    return [
        Outcome(f"{charge}.{quantity}", charge, *words)
        for charge in charges
        for quantity, words in (last | HEADLINES).items()
        if f"{charge}.{quantity}" in columns
    ]


def soc(quantity: str) -> float:
    """Return the SOC of a quantity such as `time_to_soc_0.95_s`."""
    return float(quantity.removeprefix(MARKS).removesuffix("_s"))


def text(value: Any, factor: float = 1.0) -> str:
    """Return a value of the table as a person reads it; nothing where it was not reached."""
    if value is None or (isinstance(value, float) and np.isnan(value)):
        return ""
    return f"{factor * value:.5g}" if isinstance(value, float) else str(value)
