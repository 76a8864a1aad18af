"""A named number, as steps hand it to the report and to the published statements."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple


class Quantity(NamedTuple):
    """A named number with its unit and meaning; NaN where there is none."""

    name: str
    value: float
    unit: str
    description: str


def columns(found: Iterable[Quantity]) -> dict[str, list[Any]]:
    """Return numbers as the columns of `schemas.QUANTITIES`."""
    rows = list(found)
    return {
        "quantity": [row.name for row in rows],
        "value": [row.value for row in rows],
        "unit": [row.unit for row in rows],
        "description": [row.description for row in rows],
    }
