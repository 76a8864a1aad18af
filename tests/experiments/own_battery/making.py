"""Measurements made with known cards: currents of a bench, what the model answers, noise of a logger."""

from __future__ import annotations

import functools
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import yaml
from numpy.typing import NDArray

from pipeline.cell.circuit import CELL, ZERO_CELSIUS_K, compile_cell
from pipeline.cell.records import Battery
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.charge.simulate import BENCH, simulate
from pipeline.config.compose import CONF
from pipeline.config.sources import split
from pipeline.experiments.own_battery.numbers import baked
from pipeline.experiments.own_battery.outcome import Record
from pipeline.experiments.own_battery.reading import Series
from pipeline.experiments.own_battery.replay import Drive, replays
from pipeline.experiments.own_battery.segments import segments, thinned, whole

Array = NDArray[np.float64]
AMBIENT_C = 22.0
SHARED = Path(__file__).resolve().parents[4] / "shared" / "data"
"""Files that nobody here made, beside the project; what needs them is skipped where they are not there."""


@functools.cache
def card(name: str) -> Battery:
    """Return a card of conf/battery that builds on no other, its scales multiplied out."""
    tree = yaml.safe_load((CONF / "battery" / f"{name}.yaml").read_text(encoding="utf-8"))
    return baked(Battery.model_validate(split(tree)[0]))


def series_of(current_a: Array, voltage_v: Array, temperature_c: Array, jumps: bool = True) -> Series:
    """Return rows a second apart as a series."""
    count = len(current_a)
    return Series(
        file="made.csv",
        row=np.arange(2, count + 2),
        time_s=np.arange(count, dtype=float),
        voltage_v=voltage_v,
        current_a=current_a,
        temperature_c=temperature_c,
        ambient_c=np.full(count, AMBIENT_C),
        step=np.full(count, -1),
        jumps=jumps,
        said=(),
    )


def steps(*parts: tuple[float, int]) -> Array:
    """Return a current a second from pairs of current [A] and seconds, a row without current first."""
    return np.concatenate([[0.0], *(np.full(seconds, current) for current, seconds in parts)])


def charged(battery: Battery, soc: float, current_a: float, voltage_v: float, seconds: int) -> Array:
    """Return the current of a charge at constant current, then constant voltage, a mean a second, by the engine."""
    sheet = {"constant_voltage": {"voltage_v": voltage_v, "max_current_a": current_a}}
    mode = Mode.model_validate({"title": "charge", "phases": {"charge": sheet}, "stop": {"elapsed_s": seconds}})
    settings = ChargeSettings(initial_soc=soc, ambient_c=AMBIENT_C, sample_interval_s=1.0)
    return np.asarray(simulate(battery, mode, BENCH, settings, EngineSettings()).trace["Current / A"])[:seconds]


def made(
    battery: Battery, soc: float, current_a: Array, rng: np.random.Generator | None, step_v: float = 0.0
) -> Series:
    """Return what a logger would write of a battery driven by a current.

    Arguments
    ---------
    rng : noise of 1 mV, 0.1 % of the current, 0.1 K; none: the model itself.
    step_v : step of the logger's voltage, 0: none [V].
    """
    bare = series_of(current_a, np.zeros(len(current_a)), np.full(len(current_a), AMBIENT_C))
    drive = whole(bare, AMBIENT_C).drive
    cells = np.zeros(1, dtype=np.dtype((np.record, CELL)))
    cells[:] = compile_cell(battery)
    found = replays(cells, np.array([soc]), np.array([AMBIENT_C + ZERO_CELSIUS_K]), drive)
    volts, warm = found.voltage_v[0], found.temperature_k[0] - ZERO_CELSIUS_K
    if rng is None:
        return series_of(current_a, volts, warm)
    count = len(current_a)
    noisy = volts + 1e-3 * rng.standard_normal(count)
    if step_v:
        noisy = step_v * np.round(noisy / step_v)
    told = current_a * (1.0 + 1e-3 * rng.standard_normal(count))
    return series_of(told, noisy, warm + 0.1 * rng.standard_normal(count))


def record(series: Series, battery: Battery, soc: float, held_out: NDArray[np.bool_] | None = None) -> Record:
    """Return a series as the fit takes it, its state of charge at the start stated."""
    out = np.zeros(len(series.time_s), dtype=bool) if held_out is None else held_out
    found = segments(series, soc, battery.capacity_in_use_ah)
    return Record(series, thinned(series, AMBIENT_C), out, found, soc, True, AMBIENT_C)


def pulsed(capacity_ah: float, levels: int, rest_s: int, share: float = 0.1) -> Array:
    """Return a discharge in steps with pulses at every level, as a cycler's pulse test has it."""
    parts: list[tuple[float, int]] = [(0.0, 60)]
    for _ in range(levels):
        parts += [(-capacity_ah, 10), (0.0, 120), (capacity_ah, 10), (0.0, 120)]
        parts += [(-0.5 * capacity_ah, round(3600 * share / 0.5)), (0.0, rest_s)]
    return steps(*parts)


def drive(current_a: Sequence[float], spacing_s: float) -> Drive:
    """Return a drive of currents that flow from row to row, the surroundings and the start at 25 degC."""
    count = len(current_a) + 1
    after = np.append(np.asarray(current_a, dtype=float), current_a[-1])
    before = np.append(current_a[0], np.asarray(current_a, dtype=float))
    around = np.full(count, 25.0 + ZERO_CELSIUS_K)
    nothing = np.full(count, np.nan)
    return Drive(spacing_s * np.arange(count), before, after, before, around, nothing, nothing, np.zeros(count))


def written(path: Path, series: Series, **columns: str) -> Path:
    """Write a series as CSV; return its path.

    Arguments
    ---------
    columns : quantity -> heading, where it is not the quantity's own name.
    """
    names = ("time_s", "voltage_v", "current_a", "temperature_c", "ambient_c")
    head = ",".join(columns.get(name, name) for name in names)
    rows = zip(*(getattr(series, name).tolist() for name in names), strict=True)
    lines = [",".join(f"{value:.6f}" for value in row) for row in rows]
    path.write_text("\n".join([head, *lines]) + "\n", encoding="utf-8")
    return path


@functools.cache
def small_file() -> Path:
    """Return a short measurement of an LFP cell, made once."""
    battery = card("lfp_8ah")
    series = made(battery, 0.9, pulsed(battery.capacity_ah, 3, 300), np.random.default_rng(1))
    return written(Path(tempfile.mkdtemp()) / "small.csv", series)
