"""Sweeps: the outcomes of many runs in one table, a page and a summary of it."""

from __future__ import annotations

from importlib import import_module
from typing import Any


def __getattr__(name: str) -> Any:
    """Return the declaration, imported when it is asked for: a job of the experiment does without it."""
    if name != "EXPERIMENT":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return import_module(f"{__name__}.declaration").EXPERIMENT
