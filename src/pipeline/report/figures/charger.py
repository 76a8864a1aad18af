"""The charger's circuit and its control loop, with the run's own numbers (Figures 3 and 4)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from matplotlib.figure import Figure

from pipeline.report import style
from pipeline.report.data import ReportData
from pipeline.report.figures.circuit_parts import Circuit
from pipeline.report.records import ControllerOptions, FigureCard


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
    assert isinstance(options, ControllerOptions)
    drawing = style.figure(3.7 if options.part == "current_source" else 3.1)
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
    own = table["network"] == "genetic"
    return {
        "centres": int(own.sum()),
        "units": int(data.numbers("network").get("units", 0)),
        "kernel": str(table["kernel"][own][0]),
        "highest_c": float(table["rate_c"][own].max()),
        "unit": "K/min" if float(table["gradient_seconds"][own][0]) == 60.0 else "K/s",
    }


def _reading(knobs: Mapping[str, float]) -> str:
    step, noise = knobs.get("temperature_step_k", 0.0), knobs.get("temperature_noise_k", 0.0)
    said = f"steps of {step:g} K" if step else "no steps"
    return f"{said}, {f'noise {noise:g} K' if noise else 'no noise'}"


def _current_source(
    circuit: Circuit, battery: Mapping[str, Any], knobs: Mapping[str, float], network: Mapping[str, Any]
) -> None:
    highest = network["highest_c"] * float(battery.get("capacity_ah", 0.0))
    sampled = f"a sample every {knobs.get('sample_interval_s', 0.0):g} s"
    circuit.box(
        (0.6, 3.4), 4.4, 3.4, f"Target computer\n{sampled}\nnetwork of {network['units']} units\nchecks the voltage"
    )
    circuit.arrow((2.8, 4.3), (5.0, 4.3), "D/A")
    circuit.part("Opamp", "source", (5.0, 3.9), (7.4, 3.9))
    circuit.text((6.3, 5.1), "LM324")
    circuit.part("Line", "source", (7.4, 3.9), (8.9, 3.9))
    circuit.part("BjtNpn", "source", (8.9, 3.9), (10.1, 3.9))
    circuit.part("Battery", "battery", (10.1, 7.4), (10.1, 5.2))
    circuit.part("Line", "battery", (10.1, 5.2), (10.1, 4.5))
    circuit.part("Line", "battery", (10.1, 7.4), (12.6, 7.4))
    circuit.text((12.7, 7.4), "supply", "left")
    circuit.text((10.9, 6.3), f"{battery.get('title', '')}\nup to {highest:g} A", "left")
    circuit.part("Line", "sense", (10.1, 3.3), (10.1, 2.6))
    circuit.part("Resistor", "sense", (10.1, 2.6), (10.1, 0.6))
    circuit.text((10.9, 1.6), "sense resistor:\nthe command over it\nis the current", "left")
    circuit.part("Ground", "sense", (10.1, 0.6), (10.1, 0.1))
    circuit.part("Line", "sense", (10.1, 2.6), (4.4, 2.6))
    circuit.part("Line", "sense", (4.4, 2.6), (4.4, 3.5))
    circuit.part("Line", "sense", (4.4, 3.5), (5.0, 3.5))
    circuit.box((15.6, 4.0), 3.4, 1.5, f"LM335 on the cells\n{_reading(knobs)}")
    circuit.arrow((15.6, 4.75), (15.6, 8.2), part="signal", ends_at=(0.6, 8.2))
    circuit.arrow((0.6, 8.2), (0.6, 5.1), "A/D: temperature and voltage", beside=True, part="signal")
    circuit.done((-2.2, 18.0), (-0.5, 8.8))


def _loop(circuit: Circuit, battery: Mapping[str, Any], knobs: Mapping[str, float], network: Mapping[str, Any]) -> None:
    interval = knobs.get("sample_interval_s", 0.0)
    span = knobs.get("rate_span_s", 0.0) or interval
    capacity = float(battery.get("capacity_ah", 0.0))
    circuit.box((0.0, 3.6), 4.2, 2.0, f"Sensor\n{_reading(knobs)}\nsampled every {interval:g} s")
    circuit.box((6.1, 1.2), 4.4, 1.9, f"dT/dt\n(T − T a span ago) / span\nspan {span:g} s, in {network['unit']}")
    circuit.box(
        (12.2, 3.6), 4.6, 2.0, f"GRNN\n{network['centres']} centres, {network['kernel']} kernel\nT, dT/dt to C-rate"
    )
    circuit.box((18.0, 3.6), 3.6, 2.0, f"Current\nC-rate x {capacity:g} Ah\n0 A or more")
    circuit.box((23.2, 3.6), 3.6, 2.0, f"Unit delay\none sample,\n{interval:g} s")
    circuit.box((23.2, -0.9), 3.6, 1.7, f"Battery\n{battery.get('title', '')}".replace(" 600", "\n600"))
    circuit.box((12.2, -0.9), 4.6, 1.7, "Stops: −ΔV, dT/dt,\ntemperature, time")
    circuit.arrow((2.1, 3.6), (9.9, 3.6), "T")
    circuit.arrow((3.0, 3.6), (3.0, 1.2), ends_at=(3.9, 1.2))
    circuit.arrow((8.3, 1.2), (12.2, 1.2), ends_at=(12.2, 2.6))
    circuit.arrow((14.5, 3.6), (16.2, 3.6))
    circuit.arrow((19.8, 3.6), (21.4, 3.6))
    circuit.arrow((23.2, 2.6), (23.2, -0.05), "current", beside=True)
    circuit.arrow((21.4, -0.9), (14.5, -0.9), "V, T", part="signal")
    circuit.arrow((23.2, -1.75), (23.2, -2.6), part="signal", ends_at=(23.2, -2.6))
    circuit.arrow((23.2, -2.6), (0.0, -2.6), part="signal", ends_at=(0.0, 2.6))
    circuit.text((6.0, -2.2), "temperature of the cells")
    circuit.done((-2.6, 25.6), (-3.2, 5.2))
