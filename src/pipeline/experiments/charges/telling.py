"""What the terminal says at the end: what charges were to reach and did not, and which phases did not run."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

from pipeline.experiments.charges.tables import CHARGE
from pipeline.kernel.publish import made


def lines(run: Mapping[str, Any], steps: Collection[str], results: Path) -> Iterator[str]:
    """Yield a line for each charge of a run that is in the store and missed something.

    Arguments
    ---------
    run : as the plan holds it.
    steps : those that were asked for.
    """
    for name, columns in made(run, "charge", CHARGE["summary"], results) if "charge" in steps else ():
        for quantity, text in zip(columns["quantity"], columns["text"], strict=True):
            if quantity == "missed" and text:
                yield f"{run['study']}/{run['name']} {name}: {text}"
