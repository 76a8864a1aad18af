"""The model that the engine and independent codes have in common, and the charges that they are compared on.

A straight open-circuit voltage, a series resistance linear in SOC, two pairs, a lump of heat. Parts that a code lacks
(acceptance, side reaction, a potential that moves with temperature) are taken out of the battery.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.records import Battery, Pair, Polynomial
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode, Window
from pipeline.charge.simulate import BENCH, simulate
from pipeline.experiments.validation.records import Curve, Found, PeerSettings, Row, at_most, largest

# Clear of an edge by this, two codes agree on which side of it a moment lies.
_EDGE_S = 2e-5


class Trace(NamedTuple):
    """A charge moment by moment: voltage [V] and temperature [degC] of the battery, (m,) each."""

    time_s: NDArray[np.float64]
    voltage_v: NDArray[np.float64]
    soc: NDArray[np.float64]
    temperature_c: NDArray[np.float64]


class Circuit(NamedTuple):
    """The parameters of the common model, of one cell; thermal ones too."""

    capacity_ah: float
    open_v: tuple[float, float]
    series_ohm: tuple[float, float]
    pair_ohm: tuple[float, ...]
    pair_tau_s: tuple[float, ...]
    heat_capacity_j_k: float
    thermal_resistance_k_w: float
    cells: int


class Case(NamedTuple):
    """A charge: current, limit of the battery's voltage, share and frequency of its pulses; 0 Hz is steady.

    It begins at a state of charge, at rest and at the ambient temperature.
    """

    name: str
    current_a: float
    limit_v: float | None
    share: float
    frequency_hz: float
    seconds: float
    initial_soc: float
    ambient_c: float


def cases(current_a: float, limit_v: float, initial_soc: float, ambient_c: float) -> list[Case]:
    """Return the charges: constant current, then with a limit that is held, then pulses.

    Arguments
    ---------
    current_a : current of each [A].
    limit_v : voltage of the battery held at the end [V].
    initial_soc, ambient_c : at the start [1, degC].
    """
    start = (initial_soc, ambient_c)
    return [
        Case("CC", current_a, None, 1.0, 0.0, 1800.0, *start),
        Case("CC-CV", current_a, limit_v, 1.0, 0.0, 5400.0, *start),
        Case("pulse", current_a, None, 0.9, 90.0, 10.0, *start),
    ]


def reduced(battery: Battery) -> Battery:
    """Return a battery without the parts that other codes lack.

    Raises
    ------
    ValueError : its open-circuit voltage or series resistance is not linear in SOC, or a pair's resistance varies.
    """
    plain = {
        "acceptance": None,
        "side_reaction": None,
        "charge_transfer": None,
        "hysteresis": None,
        "thermoneutral_voltage_v": None,
        "entropic_coefficient_v_k": 0.0,
        "series_resistance_temperature": None,
        "pairs": {
            name: pair.model_copy(update={"resistance_temperature": None}) for name, pair in battery.pairs.items()
        },
    }
    found = battery.model_copy(update=plain)
    circuit(found)
    return found


def circuit(battery: Battery) -> Circuit:
    """Return the parameters of a reduced battery; the errors are those of `reduced`."""
    pairs: list[Pair] = list(battery.pairs.values())
    resistances = [_line(pair.resistance_ohm) for pair in pairs]
    if battery.scale != 1.0 or any(slope != 0.0 for _, slope in resistances):
        raise ValueError(f"battery {battery.name}: the common model has constant pairs and an unscaled capacity")
    return Circuit(
        battery.capacity_ah,
        _line(battery.open_circuit_voltage_v),
        _line(battery.series_resistance_ohm),
        tuple(value for value, _ in resistances),
        tuple(pair.time_constant_s for pair in pairs),
        battery.thermal.heat_capacity_j_k / battery.cells_in_series,
        battery.thermal.resistance_k_w * battery.cells_in_series,
        battery.cells_in_series,
    )


def _line(curve: object) -> tuple[float, float]:
    """Return value at SOC 1 and slope with 1 - SOC."""
    if isinstance(curve, float | int):
        return float(curve), 0.0
    if isinstance(curve, Polynomial) and len(curve.polynomial) <= 2:
        first, *rest = curve.polynomial
        return first, rest[0] if rest else 0.0
    raise ValueError("the common model has quantities that are constant or linear in SOC")


def mode_of(case: Case) -> Mode:
    """Return a charge as the engine's lab sheet."""
    if case.frequency_hz > 0.0:
        pulse = {"charge_a": case.current_a, "charge_share": case.share, "frequency_hz": case.frequency_hz}
        phase = {"pulse": pulse}
    elif case.limit_v is None:
        phase = {"constant_current": {"current_a": case.current_a}}
    else:
        phase = {"constant_voltage": {"voltage_v": case.limit_v, "max_current_a": case.current_a}}
    return Mode.model_validate({"title": case.name, "phases": {"charge": phase}, "stop": {"elapsed_s": case.seconds}})


def by_engine(battery: Battery, case: Case, tolerance: float = 1e-9) -> Trace:
    """Return a charge by the `edge` driver, moment by moment, away from the pulses' edges."""
    settings = ChargeSettings(
        initial_soc=case.initial_soc,
        ambient_c=case.ambient_c,
        sample_interval_s=case.seconds,
        windows=[Window(start_s=0.0, length_s=case.seconds)],
    )
    engine = EngineSettings(driver="edge", tolerance=tolerance)
    wave = simulate(battery, mode_of(case), BENCH, settings, engine).waveform
    columns = [np.asarray(wave[name]) for name in ("time_s", "voltage_v", "soc", "temperature_c")]
    inside = np.append(np.diff(columns[0]) > 0.0, True) & (columns[0] > _EDGE_S)
    if case.frequency_hz > 0.0:
        edges = np.concatenate(
            [np.arange(0.0, case.seconds * case.frequency_hz + 1.0) + part for part in (0.0, case.share)]
        )
        edges = np.sort(edges) / case.frequency_hz
        place = np.clip(np.searchsorted(edges, columns[0]), 1, len(edges) - 1)
        gap = np.minimum(np.abs(columns[0] - edges[place - 1]), np.abs(columns[0] - edges[place]))
        inside &= gap > _EDGE_S
    return Trace(*(column[inside] for column in columns))


def differences(ours: Trace, theirs: Trace) -> dict[str, NDArray[np.float64]]:
    """Return theirs less ours at each moment, by quantity."""
    return {
        "voltage": theirs.voltage_v - ours.voltage_v,
        "SOC": theirs.soc - ours.soc,
        "temperature": theirs.temperature_c - ours.temperature_c,
    }


def thinned(
    time_s: NDArray[np.float64], values: NDArray[np.float64], most: int = 300
) -> tuple[NDArray[np.float64], ...]:
    """Return the value of the largest magnitude in each of so many stretches of time, with its moment."""
    if len(time_s) <= most:
        return time_s, values
    parts = np.array_split(np.arange(len(time_s)), most)
    chosen = np.array([part[int(np.argmax(np.abs(values[part])))] for part in parts])
    return time_s[chosen], values[chosen]


UNITS = {"voltage": "V", "SOC": "1", "temperature": "K"}
Array = NDArray[np.float64]
Run = Callable[[Circuit, Case, Array], Trace]


def common_model(settings: PeerSettings) -> tuple[Battery, Circuit, list[Case]]:
    """Return the reduced battery, its parameters, and the charges it is compared on."""
    cell = reduced(settings.battery)
    own = circuit(cell)
    current_a = settings.current_c_rate * own.capacity_ah
    return cell, own, cases(current_a, settings.held_voltage_v, settings.initial_soc, settings.ambient_c)


def compare(settings: PeerSettings, bounds: Mapping[str, float], run: Run) -> Found:
    """Return the largest difference of each quantity in each charge, and the differences over time.

    Arguments
    ---------
    bounds : largest difference allowed of voltage [V], SOC [1] and temperature [K], by name.
    run : the other code.
    """
    cell, own, chosen = common_model(settings)
    rows: list[Row] = []
    curves: list[Curve] = []
    for case in chosen:
        if settings.version is None:
            rows += [at_most(f"{case.name}: {name}", None, bounds[name], UNITS[name]) for name in UNITS]
            continue
        ours = by_engine(cell, case)
        for name, gap in differences(ours, run(own, case, ours.time_s)).items():
            rows.append(at_most(f"{case.name}: {name}", largest(gap), bounds[name], UNITS[name]))
            curves.append(difference(case, name, "same heat", ours.time_s, gap))
    return Found(rows, curves)


def difference(case: Case, quantity: str, series: str, time_s: Array, gap: Array) -> Curve:
    """Return a difference over time as a line, its largest values kept."""
    up = f"{quantity} [{UNITS[quantity]}]"
    return Curve(f"{case.name}: {quantity}", series, "time [s]", up, *thinned(time_s, gap))
