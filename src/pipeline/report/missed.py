"""Charges that ended before they were where they were to go, in a sentence each."""

from __future__ import annotations

from pipeline.report.data import ReportData


def missed(data: ReportData) -> list[str]:
    """Return a sentence for every charge of a run that reached none of its goals: which, how far it came, and why."""
    found = []
    for comparison, title in data.comparisons.items():
        for mode in data.charged(comparison):
            text = _missed(data, comparison, mode)
            if text is not None:
                found.append(f"{data.modes[mode].title} ({title}): {text}.")
    return found


def _missed(data: ReportData, comparison: str, mode: str) -> str | None:
    summary = data.charge(comparison, mode, "summary")
    told = dict(zip(map(str, summary["quantity"]), summary["text"], strict=True))
    return told.get("missed")
