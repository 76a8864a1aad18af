"""Figures of the studies' reports drawn from made-up artefacts."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import yaml

from pipeline.report import style
from pipeline.report.records import FigureCard
from pipeline.report.tables import ReportData
from tests.experiments.looking import faults_of_words

CONF = Path(__file__).parents[2] / "conf"


@cache
def cards(study: str = "solar_reflex") -> dict[str, FigureCard]:
    """Return name -> card of every figure of a study's report."""
    written = yaml.safe_load((CONF / "report" / f"{study}.yaml").read_text())
    return {name: FigureCard(**card) for name, card in written.items()}


def drawn(card: FigureCard, data: ReportData) -> Any:
    """Return the figure of a card, laid out."""
    with style.active():
        figure = card.drawing().draw(card, data)
        figure.draw_without_rendering()
    return figure


def looked_at(card: FigureCard, data: ReportData) -> list[str]:
    """Return what faults a card's figure has that made-up numbers show as well as real ones."""
    with style.active():
        return faults_of_words(card.drawing().draw(card, data))


def saved(card: FigureCard, data: ReportData, folder: Path, name: str = "figure") -> list[Path]:
    """Draw a card into a folder; return its files."""
    folder.mkdir(parents=True, exist_ok=True)
    with style.active():
        return list(style.save(card.drawing().draw(card, data), folder, name))
