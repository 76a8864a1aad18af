"""Which days and modes there are to show, for figures and the page."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pipeline.report.data import ReportData


def weathers(data: ReportData) -> Mapping[str, str]:
    """Return the name of each day's weather -> its title, in the order of the configuration."""
    found: Mapping[str, str] = data.settings.get("day", {}).get("weathers", {})
    return {name: title for name, title in found.items() if charged(data, name)}


def charged(data: ReportData, weather: str) -> list[str]:
    """Return the modes that were charged in a weather, in the order of the run."""
    return [mode for mode in data.modes if f"day/{weather}/{mode}" in data.inputs]
