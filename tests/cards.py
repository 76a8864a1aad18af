"""Sections of a study's configuration as a person writes them, from whichever file they stand in."""

from __future__ import annotations

from functools import cache
from typing import Any

from pipeline.config.compose import compose_tree
from pipeline.config.sources import split


def card(section: str, study: str = "solar_reflex") -> dict[str, Any]:
    """Return a section of a study as composed, without its sources."""
    values, _ = split(_composed(study))
    return dict(values[section])


def with_sources(section: str, study: str = "solar_reflex") -> dict[str, Any]:
    """Return a section of a study as composed, its sources beside its values."""
    return dict(_composed(study)[section])


@cache
def _composed(study: str) -> dict[str, Any]:
    return compose_tree((f"study={study}",)).tree
