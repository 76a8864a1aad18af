"""The paper's drawings of the system, with the configured parts: circuit, both modes, architecture (Figures 1-3, 5)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal

from pydantic import Field

from pipeline.record import Record
from pipeline.report import style
from pipeline.report.circuit_parts import Circuit
from pipeline.report.records import FigureCard

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pipeline.report.tables import ReportData


READS = ("system", "modes")


class Options(Record):
    """One of the paper's diagrams of the system."""

    part: Literal["system", "mode_1", "mode_2", "architecture"]
    mode: str = Field(default="cv_reflex", min_length=1, description="mode whose discharge the resistor is drawn for")


_CHARGING = ("buck", "s2", "s3", "battery")
_DISCHARGING = ("discharge", "s4", "battery")
_SWITCHES = {
    "system": {},
    "mode_1": {"s1": "S1:\nchops", "s2": "S2 on:\nchops", "s3": "S3 on", "s4": "S4 off"},
    "mode_2": {"s1": "S1:\nchops", "s2": "S2 on", "s3": "S3 off", "s4": "S4 on"},
}
"""What each switch does: on or off as section 2.1 states it; those of the converters chop while they are on."""


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw one of the diagrams.

    Arguments
    ---------
    figure : the card; its options name the diagram.
    data : the system as configured, and the modes' knobs.

    Returns
    -------
    The figure; it says so where the study has no panel.
    """
    options = figure.chosen()
    assert isinstance(options, Options)
    system = data.settings.get("system", {})
    drawing = style.figure(2.8 if options.part == "architecture" else 2.45)
    axes = drawing.subplots()
    axes.set_axis_off()
    if not system.get("panel"):
        style.nothing(axes, "this study has no panel")
        return drawing
    label = data.modes.get(options.mode)
    knobs = dict(label.knobs) if label else {}
    if options.part == "architecture":
        _architecture(Circuit(axes), system)
        return drawing
    lit = {"system": (), "mode_1": _CHARGING, "mode_2": _DISCHARGING}[options.part]
    dim = {"system": (), "mode_1": ("discharge", "s4"), "mode_2": ("s3",)}[options.part]
    circuit = Circuit(axes, lit, dim, style.MARKS[2].colour if options.part == "mode_2" else style.MARKS[0].colour)
    _circuit(circuit, system, _SWITCHES[options.part], _resistance_ohm(system, knobs))
    axes.set_title(_title(options.part, knobs))
    return drawing


def _title(part: str, knobs: Mapping[str, float]) -> str:
    if part == "system":
        return ""
    if part == "mode_1":
        found = f", {knobs['voltage_v']:g} V, at most {knobs['max_current_a']:g} A" if "max_current_a" in knobs else ""
        return f"Mode 1: constant voltage{found}; S2 and S3 on, S4 off"
    share = knobs.get("discharge_share")
    found = f", {knobs['discharge_a']:g} A for {100 * share:g} % of each period" if share else ""
    return f"Mode 2: the resistor discharges the battery{found}; S2 and S4 on, S3 off"


def _resistance_ohm(system: Mapping[str, Any], knobs: Mapping[str, float]) -> float | None:
    """Return the resistance that takes the configured current at the voltage the objective states."""
    current, voltage = knobs.get("discharge_a"), system.get("discharge_voltage_v")
    return voltage / current if current and voltage else None


def _circuit(
    circuit: Circuit, system: Mapping[str, Any], switches: Mapping[str, str], resistance_ohm: float | None
) -> None:
    panel, converter, load, battery = (system[name] for name in ("panel", "converter", "load", "battery"))

    def switch(name: str, part: str, start: tuple[float, float], end: tuple[float, float]) -> None:
        words = switches.get(name, name.upper())
        circuit.switch(part, start, end, " on" in words, words)

    circuit.part("Solar", "source", (0.0, 0.0), (0.0, 4.0))
    circuit.text((-0.9, 2.0), f"{panel['title']}\n{panel['max_power_w']:g} W", "right")
    circuit.part("Inductor2", "boost", (0.0, 4.0), (2.6, 4.0))
    switch("s1", "boost", (2.6, 4.0), (2.6, 0.0))
    circuit.part("Diode", "boost", (2.6, 4.0), (5.0, 4.0))
    circuit.part("Capacitor", "boost", (5.0, 4.0), (5.0, 0.0))
    circuit.text((2.5, 4.75), f"boost, {_efficiency(converter['boost'])}")
    circuit.part("Line", "bus", (5.0, 4.0), (7.0, 4.0))
    circuit.part("RBox", "load", (7.0, 4.0), (7.0, 0.0))
    circuit.text((7.5, 2.0), load["title"].replace(" ", "\n") + f"\n{load['power_w']:g} W", "left")
    circuit.text((6.0, 4.75), f"bus {converter['bus_voltage_v']:g} V")
    switch("s2", "s2", (7.0, 4.0), (9.8, 4.0))
    circuit.part("Diode", "buck", (9.8, 0.0), (9.8, 4.0))
    circuit.part("Inductor2", "buck", (9.8, 4.0), (12.2, 4.0))
    circuit.part("Capacitor", "buck", (12.2, 4.0), (12.2, 0.0))
    circuit.text((11.0, 4.75), f"buck, {_efficiency(converter['buck'])}")
    switch("s3", "s3", (12.2, 4.0), (14.6, 4.0))
    switch("s4", "s4", (14.6, 4.0), (14.6, 2.0))
    circuit.part("Resistor", "discharge", (14.6, 2.0), (14.6, 0.0))
    if resistance_ohm is not None:
        circuit.text((15.1, 1.0), f"{resistance_ohm:.3g} Ω", "left")
    circuit.part("Line", "battery", (14.6, 4.0), (17.0, 4.0))
    circuit.part("Battery", "battery", (17.0, 0.0), (17.0, 4.0))
    circuit.text((17.9, 2.0), battery["title"].replace(" ", "\n", 1), "left")
    for part, left, right in (("source", 0.0, 14.6), ("battery", 14.6, 17.0)):
        circuit.part("Line", part, (left, 0.0), (right, 0.0))
    circuit.done((-3.4, 20.4), (-0.6, 5.2))


def _architecture(circuit: Circuit, system: Mapping[str, Any]) -> None:
    panel, converter, load, battery = (system[name] for name in ("panel", "converter", "load", "battery"))
    boxes = {
        (0.0, 3.6): f"Panel\n{panel['title']}\n{panel['max_power_voltage_v']:g} V, {panel['max_power_current_a']:g} A",
        (5.0, 3.6): f"Boost converter\n{_efficiency(converter['boost'])}\ntracker {converter['tracker_efficiency']:g}",
        (10.0, 3.6): f"Buck converter\n{_efficiency(converter['buck'])}\nS2, S3",
        (15.0, 3.6): f"Battery\n{battery['title']}\ndischarge through S4",
        (5.0, 0.0): f"{load['title'].capitalize()}\n{load['power_w']:g} W at {converter['bus_voltage_v']:g} V",
        (10.0, 0.0): "Controller\nchooses the mode,\nsets the pulses",
    }
    for (x, y), text in boxes.items():
        circuit.box((x, y), 3.9, 1.9, text)
    for x, words in ((0.0, ""), (5.0, f"{converter['bus_voltage_v']:g} V"), (10.0, "")):
        circuit.arrow((x + 1.95, 3.6), (x + 3.05, 3.6), words)
    circuit.arrow((7.3, 3.6), (7.3, 0.6), part="bus", ends_at=(6.95, 0.6))
    circuit.arrow((10.0, 0.95), (10.0, 2.65), "PWM", beside=True, part="signal")
    circuit.arrow((15.0, 2.65), (15.0, 0.0), part="signal", ends_at=(11.95, 0.0))
    circuit.text((15.2, 1.2), "voltage, current,\ntemperature", "left")
    circuit.arrow((-1.9, 0.5), (-0.6, 0.5))
    circuit.text((-0.4, 0.5), "power", "left")
    circuit.arrow((-1.9, -0.3), (-0.6, -0.3), part="signal")
    circuit.text((-0.4, -0.3), "measured and set", "left")
    circuit.done((-2.3, 18.6), (-1.2, 5.0))


def _efficiency(converter: Mapping[str, Any]) -> str:
    return f"efficiency {converter['efficiency']:g}" if "efficiency" in converter else "losses by load"
