"""The statements that charges alone answer, put to the charges of another battery."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from pipeline.published.names import kind
from pipeline.published.records import Statement, needs

SECOND = "second_charge"
"""First word of the names of the second battery's charges."""


def answered_by_charges(statements: Mapping[str, Statement]) -> dict[str, Statement]:
    """Return the statements that our charges answer, and nothing else of a run."""
    return {
        name: stated
        for name, stated in statements.items()
        if stated.basis == "model" and {kind(artefact) for artefact in needs(stated)} == {"charge"}
    }


def of_second(artefact: str) -> str:
    """Return the name of the second battery's charge that stands beside one of the first."""
    return artefact.replace("charge/", f"{SECOND}/", 1)


def in_place_of_the_first(inputs: Mapping[str, Path]) -> dict[str, Path]:
    """Return the second battery's charges under the names of the first's, and nothing else of a run."""
    return {f"charge/{name.partition('/')[2]}": path for name, path in inputs.items() if kind(name) == SECOND}
