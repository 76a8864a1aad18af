"""Made-up but plausible artefacts: a charge to 14.4 V with pulses, a small panel, a supply."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pipeline.report.tables import ModeLabel, ReportData
from tests import making
from tests.experiments.frequency.artefacts import ALGORITHM, search_half
from tests.experiments.supply.system import SYSTEM

REFLEX = {
    "voltage_v": 14.4,
    "max_current_a": 2.1,
    "charge_a": 2.1,
    "charge_share": 0.9,
    "discharge_a": 0.5,
    "discharge_share": 0.05,
    "frequency_hz": 90.0,
}
PULSE = REFLEX | {"discharge_a": 0.0, "discharge_share": 0.0}
STEADY = PULSE | {"charge_share": 1.0}
MODES = {"cc_cv": ("CC-CV", STEADY), "cv_pulse": ("CV-pulse", PULSE), "cv_reflex": ("CV-Reflex", REFLEX)}
CELLS = ("One battery", "Another battery")
COMPARISONS = {"same_peak": "Same peak current", "same_mean": "Same mean current"}


def panel(folder: Path) -> None:
    rows, ends = [], []
    for irradiance in (400.0, 1000.0):
        for temperature in (25.0, 50.0):
            isc, voc = 3.99 * irradiance / 1000, 21.7 - 0.08 * (temperature - 25)
            voltage = np.linspace(0, voc, 41)
            current = isc * (1 - np.expm1(voltage / 1.2) / np.expm1(voc / 1.2))
            best = np.argmax(voltage * current)
            rows += [(irradiance, temperature, v, i, v * i) for v, i in zip(voltage, current, strict=True)]
            ends.append(
                (irradiance, temperature, isc, voc, current[best], voltage[best], current[best] * voltage[best])
            )
    output = making.output("panel", folder)
    for name, values in (("curves", rows), ("points", ends)):
        output.write(name, dict(zip(output.columns(name), np.array(values).T, strict=True)))


def supply(folder: Path, rows: int = 1) -> None:
    power = np.linspace(65.25, 20.0, rows)
    bus, load = 0.9405 * power, np.full(rows, 20.0)
    columns = {
        "time_s": 3600.0 * np.arange(rows),
        "irradiance_w_m2": 1000.0 * power / 65.25,
        "cell_temperature_c": np.full(rows, 25.0),
        "panel_power_w": power,
        "bus_power_w": bus,
        "load_power_w": load,
        "battery_power_w": 0.92 * np.maximum(0, bus - load),
        "buck_efficiency": np.full(rows, 0.92),
        "boost_efficiency": np.full(rows, 0.95),
    }
    making.output("supply", folder).write("supply", columns)


def charge(
    folder: Path,
    knobs: dict,
    factor: float = 1.0,
    stop_s: float = 14400.0,
    windows: bool = True,
    supply_limited_s: float = 0.0,
) -> None:
    peak = factor * knobs["charge_a"]
    mean_share = knobs["charge_share"] - knobs["discharge_share"] * knobs["discharge_a"] / knobs["charge_a"]
    time = np.arange(60.0, stop_s + 1, 60.0)
    soc, temperature, soc_now, t_now = [], [], 0.2, 25.0
    mean = []
    for at in time:
        share = 1.0 if at <= 3600 else mean_share
        mean.append(share * peak * min(1.0, (1.0 - soc_now) / 0.2))
        soc_now += mean[-1] * 60 / 3600 / 7.0
        t_now += 60 / 2100 * (0.9 * mean[-1] - (t_now - 25.0) / 1.9)
        soc.append(soc_now)
        temperature.append(t_now)
    soc, mean = np.array(soc), np.array(mean)
    low = np.where(time > 3600, -knobs["discharge_a"] if knobs["charge_share"] < 1 else mean, mean)
    high = np.where(time > 3600, mean / mean_share, mean)
    voltage = np.minimum(14.4, 12.3 + 1.5 * soc + 0.2 * mean)
    ah, wh, zero = np.cumsum(mean) / 60, np.cumsum(mean * voltage) / 60, np.zeros_like(time)
    trace = {
        "Test Time / s": time,
        "Voltage / V": voltage,
        "Current / A": mean,
        "Step Count / 1": np.where(time > 3600, 2, 1),
        "Ambient Temperature / degC": zero + 25.0,
        "Charging Capacity / Ah": ah,
        "Charging Energy / Wh": wh,
        "Surface Temperature / degC": np.array(temperature),
        "soc": soc,
        "voltage_min_v": voltage + 0.1 * (low - mean),
        "voltage_max_v": voltage + 0.1 * (high - mean),
        "current_min_a": low,
        "current_max_a": high,
        "supply_limited_share": np.where(time < supply_limited_s, 0.5, 0.0),
    }
    output = making.output("charge", folder)
    output.write("trace", dict.fromkeys(output.columns("trace"), zero) | trace)
    output.write("waveform", waveform(knobs, factor, stop_s) if windows else waveform(knobs, factor, 0.0))
    marks = {
        f"time_to_soc_{m:g}_s": (float(np.interp(m, soc, time)) if soc[-1] > m else None) for m in (0.5, 0.8, 0.95)
    }
    summary = {
        "quantity": [*marks, "end_reason"],
        "value": [*marks.values(), None],
        "text": [None] * 3 + ["stop: elapsed"],
        "unit": ["s"] * 3 + [""],
        "description": ["time at which the state of charge passes a mark"] * 3 + ["what ended it"],
    }
    output.write("summary", summary)
    paths = ["electrical input", "stored energy", "series resistance", "fast pair", "side reaction", "tiny", "residual"]
    energy = {
        "path": paths,
        "role": ["input", "stored", "loss", "loss", "loss", "loss", "residual"],
        "energy_j": np.array([3600 * wh[-1], 3500 * wh[-1], 7000 * peak, 3000.0, 900.0 * factor, 3.0, 0.0]),
        "description": paths,
    }
    output.write("energy", energy)


def waveform(knobs: dict, factor: float, stop_s: float) -> dict:
    rows = []
    for window, start in enumerate((5400.0, 12600.0)):
        if start > stop_s:
            continue
        period = 1 / knobs["frequency_hz"]
        edges = np.cumsum([0.0, knobs["charge_share"], knobs["discharge_share"]])
        for count in range(4):
            ends = [*edges, 1.0]
            levels = (factor * knobs["charge_a"], -knobs["discharge_a"], 0.0)
            for begin, end, level in zip(ends[:-1], ends[1:], levels, strict=True):
                for share in (begin, end):
                    voltage = 13.6 + 0.4 * window + 0.05 * level
                    rows.append((window, start + (count + share) * period, level, voltage, 0.6, 27.0))
    values = np.array(rows).reshape(-1, 6).T
    names = ("window", "time_s", "current_a", "voltage_v", "soc", "temperature_c")
    found = dict(zip(names, values, strict=True))
    found["window"] = found["window"].astype(np.int64)
    return found


def build(
    root: Path,
    modes=tuple(MODES),
    stop_s: float = 14400.0,
    windows: bool = True,
    rows: int = 1,
    supply_limited_s: float = 0.0,
) -> ReportData:
    panel(root / "panel")
    supply(root / "supply", rows)
    inputs = {"panel": root / "panel", "supply": root / "supply"} | search_half(root)
    for comparison in COMPARISONS:
        for mode in modes:
            knobs = MODES[mode][1]
            mean = knobs["charge_share"] - knobs["discharge_share"] * knobs["discharge_a"] / knobs["charge_a"]
            folder = root / "charge" / comparison / mode
            factor = 1.0 if comparison == "same_peak" else 1 / mean
            charge(folder, knobs, factor, stop_s, windows, supply_limited_s)
            inputs[f"charge/{comparison}/{mode}"] = folder
            folder = root / "second_charge" / comparison / mode
            charge(folder, knobs, 0.8 * factor, stop_s, windows, supply_limited_s)
            inputs[f"second_charge/{comparison}/{mode}"] = folder
    labels = {mode: ModeLabel(MODES[mode][0], MODES[mode][1]) for mode in modes}
    settings = {"system": SYSTEM, "algorithm": ALGORITHM, "cells": {"titles": CELLS}}
    return ReportData(making.inputs(inputs), labels, COMPARISONS, settings)


VARIANTS = {
    "many modes": {},
    "one mode": {"modes": ("cc_cv",)},
    "stopped early": {"stop_s": 1500.0},
    "no waveform": {"windows": False},
    "weather that changes": {"rows": 5, "supply_limited_s": 3000.0},
}
