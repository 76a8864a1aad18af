"""What the cell's quantities are over its state of charge, as configured."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.report import style
from pipeline.report.records import FigureCard, NoOptions

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pipeline.report.tables import ReportData


READS = ("battery",)
Options = NoOptions


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw open-circuit voltage, entropic coefficient and resistances.

    Arguments
    ---------
    figure : the card.
    data : the battery as configured.
    """
    battery = data.settings.get("battery", {})
    drawing = style.figure(3.2)
    voltage, entropic, resistance = drawing.subplots(1, 3)
    _line(voltage, battery["open_circuit_voltage_v"], 1.0, style.MARKS[0])
    voltage.set_ylabel("Open-circuit voltage [V]")
    _line(entropic, battery["entropic_coefficient_v_k"], 1e3, style.MARKS[2])
    entropic.set_ylabel("dU/dT [mV/K]")
    _line(resistance, battery["series_resistance_ohm"], 1e3, style.MARKS[0], "R")
    for number, (pair, mark) in enumerate(zip(battery["pairs"].values(), style.MARKS[1:], strict=False), start=1):
        _line(resistance, pair["resistance_ohm"], 1e3, mark, f"R{number}")
    resistance.set_ylabel("Resistance [mΩ]")
    resistance.set_ylim(bottom=0.0)
    resistance.legend()
    for axes in (voltage, entropic, resistance):
        axes.set_xlabel("State of charge [%]")
    return drawing


def _line(axes: Axes, curve: Any, factor: float, mark: style.Mark, label: str | None = None) -> None:
    if isinstance(curve, Mapping) and "value" in curve:
        values = factor * curve.get("scale", 1.0) * np.array(curve["value"])
        axes.plot(
            100.0 * np.array(curve["soc"]), values, color=mark.colour, marker=mark.marker, markersize=3.5, label=label
        )
    elif isinstance(curve, float | int):
        axes.plot([0.0, 100.0], [factor * curve] * 2, color=mark.colour, label=label)
    else:
        style.nothing(axes, "a function of SOC")
