"""The charger's circuit and its control loop, with the run's own numbers (Figures 3 and 4)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal

from pydantic import Field

from pipeline.experiments.network.records import USED, gradient_unit
from pipeline.record import Record
from pipeline.report import style
from pipeline.report.circuit_parts import Circuit
from pipeline.report.records import FigureCard
from pipeline.report.text import times

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pipeline.report.tables import ReportData


READS = ("system", "modes", "network")


class Options(Record):
    """One of the paper's diagrams of the charger."""

    part: Literal["current_source", "loop"]
    mode: str = Field(default="grnn", min_length=1, description="mode whose controller is drawn")


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw one of the diagrams.

    Arguments
    ---------
    figure : the card; its options name the diagram and the mode.
    data : battery and knobs as configured, and the network that was found.

    Returns
    -------
    The figure; it says so where the mode is not part of the run.
    """
    options = figure.chosen()
    assert isinstance(options, Options)
    drawing = style.figure(3.7 if options.part == "current_source" else 2.5)
    axes = drawing.subplots()
    axes.set_axis_off()
    if options.mode not in data.modes or "network" not in data.inputs:
        style.nothing(axes, f"no mode {options.mode} in this run")
        return drawing
    battery = data.settings.get("system", {}).get("battery", {})
    knobs, network = dict(data.modes[options.mode].knobs), _network(data)
    part = _current_source if options.part == "current_source" else _loop
    part(Circuit(axes), battery, knobs, network)
    return drawing


def _network(data: ReportData) -> dict[str, Any]:
    table = data.table("network", "networks")
    own = table["network"] == USED
    return {
        "centres": int(own.sum()),
        "units": int(data.numbers("network").get("units", 0)),
        "kernel": str(table["kernel"][own][0]),
        "highest_c": float(table["rate_c"][own].max()),
        "unit": gradient_unit(float(table["gradient_seconds"][own][0])),
    }


def _reading(knobs: Mapping[str, float]) -> str:
    step, noise = knobs.get("temperature_step_k", 0.0), knobs.get("temperature_noise_k", 0.0)
    said = f"steps of {step:g} K" if step else "no steps"
    return f"{said}, {f'noise {noise:g} K' if noise else 'no noise'}"


def _current_source(
    circuit: Circuit, battery: Mapping[str, Any], knobs: Mapping[str, float], network: Mapping[str, Any]
) -> None:
    highest = network["highest_c"] * float(battery.get("capacity_in_use_ah", 0.0))
    sampled = f"a sample every {knobs.get('sample_interval_s', 0.0):g} s"
    computer = f"Target computer\n{sampled}\nnetwork of {network['units']} units\nchecks the voltage"
    circuit.box((0.4, 3.7), 4.4, 3.0, computer)
    circuit.arrow((2.6, 4.3), (5.0, 4.3), "D/A")
    circuit.placed("Opamp", "source", (5.0, 4.3), "in2", flip=True)
    circuit.text((6.1, 5.2), "LM324")
    circuit.part("Line", "source", (7.17, 3.68), (8.9, 3.68))
    circuit.placed("BjtNpn", "source", (8.9, 3.68), "base")
    circuit.part("Line", "battery", (9.65, 4.38), (9.65, 5.0))
    circuit.part("Battery", "battery", (9.65, 5.0), (9.65, 7.0))
    circuit.part("Line", "battery", (9.65, 7.0), (11.6, 7.0))
    circuit.text((11.7, 7.0), "supply", "left")
    circuit.arrow((9.65, 7.0), (9.65, 8.0), part="signal")
    circuit.text((10.5, 5.9), f"{times(battery.get('title', ''))}\nup to {highest:g} A", "left")
    circuit.part("Line", "sense", (9.65, 2.98), (9.65, 2.3))
    circuit.part("Resistor", "sense", (9.65, 2.3), (9.65, 0.4))
    circuit.text((10.4, 1.35), "sense resistor: the command\nsets its voltage", "left")
    circuit.placed("Ground", "sense", (9.65, 0.4), "start")
    for start, end in (((9.65, 2.3), (4.3, 2.3)), ((4.3, 2.3), (4.3, 3.06)), ((4.3, 3.06), (5.0, 3.06))):
        circuit.part("Line", "sense", start, end)
    circuit.box((15.4, 3.9), 4.2, 1.5, f"LM335 on the cells\n{_reading(knobs)}")
    circuit.arrow((15.4, 4.65), (15.4, 8.0), part="signal", ends_at=(15.4, 8.0))
    circuit.arrow((15.4, 8.0), (0.4, 8.0), part="signal", ends_at=(0.4, 5.2))
    circuit.text((4.8, 8.35), "A/D: temperature, and the battery's voltage")
    circuit.text((9.9, 7.55), "voltage", "left")
    circuit.text((15.6, 6.3), "temperature", "left")
    circuit.done((-2.2, 17.8), (-0.5, 8.8))


def _loop(circuit: Circuit, battery: Mapping[str, Any], knobs: Mapping[str, float], network: Mapping[str, Any]) -> None:
    interval = knobs.get("sample_interval_s", 0.0)
    span = knobs.get("rate_span_s", 0.0) or interval
    capacity = float(battery.get("capacity_in_use_ah", 0.0))
    circuit.box((0.0, 3.6), 4.8, 2.2, f"Sensor\n{_reading(knobs)}\nsampled every {interval:g} s")
    circuit.box((6.7, 0.9), 6.2, 2.1, f"dT/dt\n(T - T a span ago) / span\nspan {span:g} s, in {network['unit']}")
    answer = f"GRNN\n{network['centres']} centres, {network['kernel']} kernel\nT, dT/dt to C-rate"
    circuit.box((13.6, 3.6), 7.0, 2.2, answer)
    circuit.box((20.6, 3.6), 4.4, 2.2, f"Current\nC-rate × {capacity:g} Ah\n0 A or more")
    circuit.box((26.4, 3.6), 4.4, 2.2, f"Unit delay\none sample,\n{interval:g} s")
    circuit.box((26.4, -0.9), 4.4, 2.2, f"Battery\n{times(battery.get('title', ''))}".replace(" 600", "\n600"))
    circuit.box((13.6, -0.9), 5.6, 1.7, "Stops: −ΔV, dT/dt,\ntemperature, time")
    circuit.arrow((2.4, 3.6), (10.1, 3.6), "T")
    circuit.arrow((3.0, 3.6), (3.0, 0.9), ends_at=(3.6, 0.9))
    circuit.arrow((9.8, 0.9), (13.6, 0.9), ends_at=(13.6, 2.5))
    circuit.arrow((17.1, 3.6), (18.4, 3.6))
    circuit.arrow((22.8, 3.6), (24.2, 3.6))
    circuit.arrow((26.4, 2.5), (26.4, 0.2), "current", beside=True)
    circuit.arrow((24.2, -0.9), (16.4, -0.9), "V, T", part="signal")
    circuit.arrow((26.4, -2.0), (26.4, -2.9), part="signal", ends_at=(26.4, -2.9))
    circuit.arrow((26.4, -2.9), (0.0, -2.9), part="signal", ends_at=(0.0, 2.5))
    circuit.text((6.0, -2.5), "temperature of the cells")
    circuit.done((-2.6, 29.2), (-3.3, 5.0))
