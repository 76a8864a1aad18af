"""The battery's equivalent circuit with its configured values (Figure 1)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from pipeline.report import style
from pipeline.report.circuit_parts import Circuit
from pipeline.report.records import FigureCard, NoOptions

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pipeline.report.tables import ReportData


READS = ("battery",)
Options = NoOptions


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw source, series resistance and pairs between the battery's terminals.

    Arguments
    ---------
    figure : the card.
    data : the battery as configured.
    """
    battery = data.settings.get("battery", {})
    drawing = style.figure(2.9)
    axes = drawing.subplots()
    axes.set_axis_off()
    circuit = Circuit(axes)
    left = 0.0
    circuit.part("SourceV", "source", (left, 0.0), (left, 3.0))
    circuit.text((left - 0.7, 1.5), f"U(SOC, T)\n{_span(battery['open_circuit_voltage_v'], 1.0)} V", "right")
    circuit.part("Resistor", "series", (left, 3.0), (left + 4.0, 3.0))
    circuit.text((left + 2.0, 3.8), f"R  {_span(battery['series_resistance_ohm'], 1e3)} mΩ")
    place = left + 4.0
    for number, pair in enumerate(battery["pairs"].values(), start=1):
        _pair(circuit, place, number, pair)
        place += 5.0
    circuit.part("Line", "wire", (place, 3.0), (place + 1.5, 3.0))
    circuit.part("Line", "wire", (left, 0.0), (place + 1.5, 0.0))
    for height in (0.0, 3.0):
        axes.plot(place + 1.5, height, "o", color="white", markeredgecolor="#222222", markersize=6, zorder=6)
    circuit.arrow((place + 1.3, 3.45), (place + 0.2, 3.45), "")
    circuit.text((place + 0.8, 3.95), "I > 0: charging")
    circuit.text((place + 1.8, 1.5), "terminal voltage\nU + I R + Up", "left")
    axes.set_title(f"{battery['title']}: values over the state of charge")
    circuit.done((-4.2, place + 5.5), (-0.7, 5.0))
    return drawing


def _pair(circuit: Circuit, place: float, number: int, pair: Mapping[str, Any]) -> None:
    circuit.part("Line", "pair", (place, 3.0), (place + 0.8, 3.0))
    circuit.part("Line", "pair", (place + 0.8, 2.2), (place + 0.8, 3.8))
    circuit.part("Line", "pair", (place + 4.2, 2.2), (place + 4.2, 3.8))
    circuit.part("Resistor", "pair", (place + 0.8, 3.8), (place + 4.2, 3.8))
    circuit.part("Capacitor", "pair", (place + 0.8, 2.2), (place + 4.2, 2.2))
    circuit.part("Line", "pair", (place + 4.2, 3.0), (place + 5.0, 3.0))
    circuit.text((place + 2.5, 4.55), f"R{number}  {_span(pair['resistance_ohm'], 1e3)} mΩ")
    circuit.text((place + 2.5, 1.25), f"C{number} = τ / R{number},  τ = {pair['time_constant_s']:g} s\nvoltage Up")


def _span(curve: Any, factor: float) -> str:
    """Return the least and the largest value of a quantity, or the one it has."""
    if isinstance(curve, Mapping) and "value" in curve:
        values = [factor * curve.get("scale", 1.0) * value for value in curve["value"]]
        return f"{min(values):.3g} to {max(values):.3g}"
    return f"{factor * curve:.3g}" if isinstance(curve, float | int) else "function of SOC"
