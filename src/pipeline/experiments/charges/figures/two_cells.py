"""Current, voltage, SOC and temperature of two batteries under the same modes, a column for each battery."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pipeline.experiments.charges.figures.over_time import QUANTITIES, key_of_band, line
from pipeline.experiments.charges.second_cell import cells, second
from pipeline.report import style
from pipeline.report.records import FigureCard, NoOptions

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pipeline.report.tables import ReportData


READS = ("charge", "second_charge", "cells")
Options = NoOptions


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw every quantity over time, the modes together.

    Arguments
    ---------
    figure : the card; its comparison is the one shown, or else the first that has charges.
    data : the charges of both batteries.

    Returns
    -------
    The figure, a row for each quantity, each battery on its own axis of time and each row on one of its quantity.
    """
    drawing = style.figure(0.9 + 1.95 * len(QUANTITIES))
    fields = drawing.subplots(len(QUANTITIES), 2, sharex="col", sharey="row", squeeze=False)
    marks = style.marks(list(data.modes))
    seen: set[str] = set()
    is_pulsed = False
    for column, (title, cell) in enumerate(zip(cells(data), (data, second(data)), strict=True)):
        fields[0, column].set_title(title)
        compared = cell.shown(figure.comparison)[:1]
        charged = cell.charged(compared[0]) if compared else []
        for row, quantity in enumerate(QUANTITIES.values()):
            if not charged:
                style.nothing(fields[row, column], "no charge in this run")
            for place, mode in enumerate(charged):
                seen.add(mode)
                trace = cell.charge(compared[0], mode, "trace")
                band = line(fields[row, column], trace, quantity, marks[mode], min(3, len(charged) - 1 - place))
                is_pulsed = is_pulsed or band is not None
    for row, quantity in enumerate(QUANTITIES.values()):
        fields[row, 0].set_ylabel(quantity.label)
    for axes in fields[-1]:
        axes.set_xlabel("Time [h]")
    titles = {mode: label.title for mode, label in data.modes.items()}
    shown = style.handles(titles, {mode: mark for mode, mark in marks.items() if mode in seen})
    style.above(drawing, [*shown, *([key_of_band()] if is_pulsed else [])], size=10.0)
    return drawing
