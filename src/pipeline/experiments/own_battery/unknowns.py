"""What of a card is fitted: its numbers as a vector with bounds and priors, the cells that many vectors stand for."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import (
    CELL,
    ENTROPIC,
    EXCHANGE,
    FIRST_PAIR,
    GAS_CONSTANT,
    OPEN_CIRCUIT,
    SERIES,
    THERMAL_V_PER_K,
    compile_cell,
)
from pipeline.cell.records import Arrhenius, Battery, Tabulated
from pipeline.experiments.own_battery.numbers import at, baked, of_curve, place_of, with_values

Array = NDArray[np.float64]
SOC = "initial_soc"
_OPEN = "open_circuit_voltage_v"


class Unknown(NamedTuple):
    """A number that is fitted.

    Arguments
    ---------
    path : its key path in the card; `initial_soc.N` is the state of charge at the start of record N.
    start : its value on the start card.
    low, high : bounds.
    log : whether its logarithm is fitted.
    prior : half-width of the interval that is plausible without the measurement, of the logarithm where that is fitted.
    """

    path: str
    start: float
    low: float
    high: float
    log: bool
    prior: float


_LEVEL_V, _LEVEL = 0.03, math.log(1.5)
"""How far two points of a table 10 % of charge apart may move from each other: voltage [V], resistance (log)."""


_LEAST_RISE_V, _MOST_RISE_V = 1e-5, 1.5


class Neighbours(NamedTuple):
    """Places of neighbours in a vector, and the half-width of what they may move apart, shape (k,) each.

    A rise of the open-circuit voltage stands for both its points: its first is -1.

    A table is one curve: where the measurement says nothing of a point, it goes with the points beside it.
    """

    first: NDArray[np.int64]
    second: NDArray[np.int64]
    width: Array


class Model(NamedTuple):
    """A card, the numbers of it that are fitted, and the rest as it stands.

    Arguments
    ---------
    battery : the card, at the start of the fit.
    unknowns : the numbers, d of them.
    soc : state of charge at the start of each record, where it is not among them.
    """

    battery: Battery
    unknowns: tuple[Unknown, ...]
    soc: tuple[float, ...]

    @property
    def paths(self) -> list[str]:
        """Return the key paths in order."""
        return [one.path for one in self.unknowns]

    def mixing(self) -> Array:
        """Return the matrix that makes numbers of a vector, shape (d, d).

        A table of the open-circuit voltage stands in a vector as its first point and its rises from point to point,
        which have a bound at zero: what a cell rests at does not fall while it is charged. Everything else is itself.
        """
        found = np.eye(len(self.unknowns))
        rises = self.rises()
        for place, before in enumerate(rises[:-1]):
            found[rises[place + 1 :], before] = 1.0
        return found

    def rises(self) -> list[int]:
        """Return the places of the points of a table of the open-circuit voltage, in order; none of another curve."""
        return [place for place, path in enumerate(self.paths) if path.startswith(f"{_OPEN}.value.")]

    def start(self) -> Array:
        """Return the vector at the start, shape (d,)."""
        found = np.array([math.log(one.start) if one.log else one.start for one in self.unknowns])
        rises = self.rises()
        found[rises[1:]] = np.maximum(np.diff(found[rises]), _LEAST_RISE_V)
        return found

    def bounds(self) -> tuple[Array, Array]:
        """Return lowest and highest vectors, shape (d,) each."""
        pairs = [(math.log(one.low), math.log(one.high)) if one.log else (one.low, one.high) for one in self.unknowns]
        found = np.array(pairs).reshape(-1, 2)
        found[self.rises()[1:]] = 0.0, _MOST_RISE_V
        return found[:, 0].copy(), found[:, 1].copy()

    def widths(self) -> Array:
        """Return half-widths of the plausible intervals of a vector, shape (d,): its scales."""
        found, near = self.priors(), self.neighbours()
        alone = near.first < 0
        found[near.second[alone]] = near.width[alone]
        return found

    def priors(self) -> Array:
        """Return half-widths of the plausible intervals of the numbers, of logarithms where these count, shape (d,)."""
        return np.array([one.prior for one in self.unknowns])

    def values(self, vectors: Array) -> Array:
        """Return the numbers of vectors in their own units, shape (n, d)."""
        return self.plain(vectors @ self.mixing().T)

    def plain(self, numbers: Array) -> Array:
        """Return numbers, some of them logarithms, in their own units, shape (n, d)."""
        log = np.array([one.log for one in self.unknowns], dtype=bool)
        return np.where(log, np.exp(np.where(log, numbers, 0.0)), numbers)

    def neighbours(self) -> Neighbours:
        """Return the neighbours in tables of which both are fitted, and how far apart they may move from the start."""
        places = {path: place for place, path in enumerate(self.paths)}
        found = []
        for path, place in places.items():
            key, dot, number = path.rpartition(".value.")
            other = places.get(f"{key}.value.{int(number) + 1}") if dot else None
            if other is not None:
                grid = at(self.battery, key).soc
                step = math.sqrt((grid[int(number) + 1] - grid[int(number)]) / 0.1)
                is_open = key == _OPEN
                found.append((-1 if is_open else place, other, (_LEVEL_V if is_open else _LEVEL) * step))
        columns = list(zip(*found, strict=True)) or [(), (), ()]
        return Neighbours(np.array(columns[0], dtype=int), np.array(columns[1], dtype=int), np.array(columns[2]))

    def without(self, paths: Iterable[str], values: Mapping[str, float] | None = None) -> Model:
        """Return the model with some numbers no longer fitted: at their start, or at a given value."""
        left = set(paths)
        given = {one.path: one.start for one in self.unknowns if one.path in left}
        given |= {path: value for path, value in (values or {}).items() if path in left}
        battery = with_values(self.battery, {path: value for path, value in given.items() if not path.startswith(SOC)})
        soc = tuple(given.get(f"{SOC}.{place}", value) for place, value in enumerate(self.soc))
        return Model(battery, tuple(one for one in self.unknowns if one.path not in left), soc)

    def begun(self, vector: Array) -> Model:
        """Return the model with a vector as its start."""
        values = self.values(vector[None])[0]
        unknowns = tuple(one._replace(start=float(value)) for one, value in zip(self.unknowns, values, strict=True))
        return self._replace(unknowns=unknowns)

    def card(self, vector: Array) -> tuple[Battery, list[float]]:
        """Return the card that a vector stands for, and the state of charge at the start of each record."""
        values = dict(zip(self.paths, self.values(vector[None])[0].tolist(), strict=True))
        soc = [values.pop(f"{SOC}.{place}", value) for place, value in enumerate(self.soc)]
        return with_values(self.battery, values), soc


class Population:
    """The cells of many vectors of a model, in the kernel's form; the same arrays are filled each time."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self._template = compile_cell(model.battery)
        self._cells = np.zeros(0, dtype=np.dtype((np.record, CELL)))
        pairs = list(model.battery.pairs)
        self._rows = {"open_circuit_voltage_v": OPEN_CIRCUIT, "entropic_coefficient_v_k": ENTROPIC}
        self._rows |= {"series_resistance_ohm": SERIES, "charge_transfer.exchange_current_a": EXCHANGE}
        self._rows |= {f"pairs.{name}.resistance_ohm": FIRST_PAIR + place for place, name in enumerate(pairs)}
        self._factors = {"series_resistance_temperature": 0}
        self._factors |= {f"pairs.{name}.resistance_temperature": 1 + place for place, name in enumerate(pairs)}
        self._factors |= {"acceptance.resistance_temperature": 1 + len(pairs)}
        self._places = {path: place for place, path in enumerate(model.paths)}
        self._scalars = [path for path in model.paths if self._curve_of(path) is None and not path.startswith(SOC)]

    def cells(self, vectors: Array) -> tuple[NDArray[Any], Array]:
        """Return the cells, shape (n,), and the states of charge at the start of each record, (n, records)."""
        count = len(vectors)
        if len(self._cells) < count:
            self._cells = np.zeros(count, dtype=np.dtype((np.record, CELL)))
            self._cells[:] = self._template
        cells = self._cells[:count]
        values = self.model.values(vectors)
        for key in {found for path in self.model.paths if (found := self._curve_of(path)) is not None}:
            self._write_curve(cells, key, values)
        for path in self._scalars:
            self._write_scalar(cells, path, values[:, self._places[path]])
        soc = np.empty((count, len(self.model.soc)))
        for place, value in enumerate(self.model.soc):
            at = self._places.get(f"{SOC}.{place}")
            soc[:, place] = value if at is None else values[:, at]
        return cells, soc

    def _curve_of(self, path: str) -> str | None:
        return next((key for key in self._rows if path == key or path.startswith(key + ".")), None)

    def _write_curve(self, cells: NDArray[Any], key: str, values: Array) -> None:
        row, curve = self._rows[key], at(self.model.battery, key)
        if isinstance(curve, Tabulated):
            self._write_table(cells, row, key, curve, values)
            return
        names = [name.removeprefix(key).lstrip(".") for name in self._places if self._curve_of(name) == key]
        for name in names:
            column = values[:, self._places[f"{key}.{name}" if name else key]]
            cells["parameters"][:, row, place_of(curve, name)] = column

    def _write_table(self, cells: NDArray[Any], row: int, key: str, curve: Tabulated, values: Array) -> None:
        from scipy.interpolate import PchipInterpolator

        whole = np.tile(np.array(curve.value), (len(cells), 1))
        for name, place in self._places.items():
            if name.startswith(f"{key}.value."):
                whole[:, int(name.rsplit(".", 1)[1])] = values[:, place]
        scale = self._places.get(f"{key}.scale")
        whole = whole * (curve.scale if scale is None else values[:, scale, None])
        depth = 1.0 - np.array(curve.soc[::-1])
        cubic = PchipInterpolator(depth, whole[:, ::-1], axis=1)
        pieces = len(depth) - 1
        # c: power, piece, vector
        cells["coefficients"][:, row, :pieces, :4] = cubic.c[::-1].transpose(2, 1, 0)

    def _write_scalar(self, cells: NDArray[Any], path: str, values: Array) -> None:
        tau = cells["tau_s"]
        battery = self.model.battery
        factor = next((key for key in self._factors if path.startswith(key + ".")), None)
        if factor is not None:
            cells["factor_energy_k"][:, self._factors[factor]] = values / GAS_CONSTANT
        elif path == "capacity_ah":
            cells["charge_as"], cells["per_as"] = 3600.0 * values, 1.0 / (3600.0 * values)
            if battery.hysteresis is not None:
                cells["hysteresis_per_depth"] = battery.hysteresis.rate_per_ah * values
        elif path.startswith("pairs."):
            tau[:, list(battery.pairs).index(path.split(".")[1])] = values
        elif path == "acceptance.time_constant_s":
            tau[:, len(battery.pairs)] = values
        elif path == "side_reaction.recombination_time_constant_s":
            tau[:, len(battery.pairs) + (battery.acceptance is not None)] = values
        elif path == "side_reaction.thermal_voltages":
            cells["side_scale_v_per_k"] = THERMAL_V_PER_K * values
        elif path == "side_reaction.activation_energy_j_mol":
            cells["side_arrhenius_k"] = values / GAS_CONSTANT
        else:
            cells[_NAMES[path]] = values


_NAMES = {
    "acceptance.resistance_ohm": "acceptance_ohm",
    "side_reaction.current_a": "side_a",
    "side_reaction.voltage_scale_v": "side_scale_v",
    "side_reaction.temperature_coefficient_per_k": "side_linear_per_k",
    "side_reaction.gas_voltage_v": "gas_v",
    "thermoneutral_voltage_v": "thermoneutral_v",
    "thermal.heat_capacity_j_k": "heat_capacity_j_k",
    "thermal.resistance_k_w": "thermal_resistance_k_w",
}


_VOLTS, _SHARE, _FACTOR = 0.1, 0.05, math.log(3.0)


def unknowns_of(
    battery: Battery,
    soc: Sequence[float],
    rows_s: tuple[float, float],
    warm: bool,
    ranges: Mapping[str, tuple[float, float]],
    known: Sequence[bool] = (),
) -> Model:
    """Return the model of a card: every number of it that a measurement might tell.

    Arguments
    ---------
    soc : state of charge at the start of each record; `known` : whether it is stated, and not fitted.
    rows_s : shortest time between rows and length of the longest record [s].
    warm : whether the battery's temperature was measured.
    ranges : key path -> range that the start card's source gives.
    """
    battery = baked(battery)
    found: list[Unknown] = []

    def positive(path: str, value: float, factor: float = 30.0, prior: float = _FACTOR) -> None:
        found.append(Unknown(path, value, value / factor, value * factor, True, prior))

    def linear(path: str, value: float, reach: float, prior: float) -> None:
        found.append(Unknown(path, value, value - reach, value + reach, False, prior))

    positive("capacity_ah", battery.capacity_ah, 3.0, math.log(1.25))
    for place, value in enumerate(soc):
        if place < len(known) and known[place]:
            continue
        found.append(Unknown(f"{SOC}.{place}", value, -0.2, 1.0 if battery.acceptance else 1.2, False, _SHARE))
    for path, value in of_curve("open_circuit_voltage_v", battery.open_circuit_voltage_v):
        if path.endswith((".factor", ".polarisation_v")):
            positive(path, value)
        else:
            linear(path, value, 1.0, _VOLTS)
    resistances = {"series_resistance_ohm": battery.series_resistance_ohm}
    resistances |= {f"pairs.{name}.resistance_ohm": pair.resistance_ohm for name, pair in battery.pairs.items()}
    for key, curve in resistances.items():
        for path, value in of_curve(key, curve):
            if value > 0.0 and not path.endswith((".polynomial.1", ".polynomial.2", ".polynomial.3")):
                positive(path, value)
            else:
                linear(path, value, 50.0 * abs(value) + 1e-3, abs(value) + 1e-4)
    for name, pair in battery.pairs.items():
        tau = pair.time_constant_s
        low, high = min(0.2 * rows_s[0], 0.5 * tau), max(3.0 * rows_s[1], 2.0 * tau)
        found.append(Unknown(f"pairs.{name}.time_constant_s", tau, low, high, True, _FACTOR))
    if battery.acceptance is not None:
        positive("acceptance.resistance_ohm", battery.acceptance.resistance_ohm)
        positive("acceptance.time_constant_s", battery.acceptance.time_constant_s)
    if battery.charge_transfer is not None:
        for path, value in of_curve("charge_transfer.exchange_current_a", battery.charge_transfer.exchange_current_a):
            positive(path, value)
    side = battery.side_reaction
    if side is not None:
        positive("side_reaction.current_a", side.current_a, 1e3)
        for name in ("voltage_scale_v", "thermal_voltages"):
            if getattr(side, name) is not None:
                positive(f"side_reaction.{name}", getattr(side, name), 5.0, math.log(1.5))
        if side.recombination_time_constant_s > 0.0 and warm:
            positive("side_reaction.recombination_time_constant_s", side.recombination_time_constant_s)
    if warm:
        positive("thermal.heat_capacity_j_k", battery.thermal.heat_capacity_j_k, 10.0, math.log(2.0))
        positive("thermal.resistance_k_w", battery.thermal.resistance_k_w, 20.0, math.log(3.0))
        if battery.thermoneutral_voltage_v is not None:
            linear("thermoneutral_voltage_v", battery.thermoneutral_voltage_v, 0.3, 0.04)
        entropic = battery.entropic_coefficient_v_k
        if isinstance(entropic, Tabulated):
            linear("entropic_coefficient_v_k.scale", entropic.scale, 3.0, 0.5)
        elif isinstance(entropic, float | int):
            linear("entropic_coefficient_v_k", float(entropic), 2e-3, 2e-4)
    for path, warmth in _warmths(battery):
        linear(f"{path}.activation_energy_j_mol", warmth.activation_energy_j_mol, 1e5, 3e4)
    return Model(battery, tuple(_ranged(one, ranges) for one in found), tuple(soc))


def _warmths(battery: Battery) -> Iterator[tuple[str, Arrhenius]]:
    named = {"series_resistance_temperature": battery.series_resistance_temperature}
    named |= {
        f"pairs.{name}.resistance_temperature": pair.resistance_temperature for name, pair in battery.pairs.items()
    }
    if battery.acceptance is not None:
        named["acceptance.resistance_temperature"] = battery.acceptance.resistance_temperature
    yield from ((path, one) for path, one in named.items() if isinstance(one, Arrhenius))


def _ranged(one: Unknown, ranges: Mapping[str, tuple[float, float]]) -> Unknown:
    """Return an unknown with the prior that its source gives, if it gives one."""
    given = ranges.get(one.path)
    if given is None:
        return one
    low, high = given
    return one._replace(prior=0.5 * (math.log(high / low) if one.log and low > 0.0 else high - low))
