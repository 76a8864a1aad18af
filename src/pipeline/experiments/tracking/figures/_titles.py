"""Titles of trackers and days, for figures and the page."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pipeline.report.tables import ReportData


def titles(data: ReportData, part: str = "trackers") -> Mapping[str, str]:
    """Return name -> title of the trackers, or of the days they are tried on."""
    found: Mapping[str, str] = data.settings.get("tracking", {}).get(part, {})
    return found
