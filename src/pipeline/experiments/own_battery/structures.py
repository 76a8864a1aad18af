"""Structures of the card that are compared: how many pairs, with and without a side reaction, and on which grids."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.records import Battery, Curve, Tabulated
from pipeline.experiments.own_battery.fitting import Part, Problem, Spread, rmse_v, solve, spread_of
from pipeline.experiments.own_battery.numbers import baked
from pipeline.experiments.own_battery.records import Fit
from pipeline.experiments.own_battery.segments import CONSTANT_CURRENT, CONSTANT_VOLTAGE, Segment
from pipeline.experiments.own_battery.unknowns import Model, unknowns_of

Array = NDArray[np.float64]
NAMES = ("fast", "slow", "slower")
_TIME_BLOCKS = 12
_ENERGY_J_MOL = 20000.0


class Structure(NamedTuple):
    """A structure: its name for people, pairs, whether it has the side reaction, and the card with it."""

    name: str
    pairs: int
    side: bool
    battery: Battery


class Tried(NamedTuple):
    """A structure after cross-validation.

    Arguments
    ---------
    structure, model, vector : it, its model, and where its fit to all that may be seen ended.
    unknowns : how many numbers are fitted.
    left_out : error of the voltage in each block while it was left out, root of the mean of the squares, (blocks,) [V].
    seen_v : error over what the fit saw [V].
    """

    structure: Structure
    model: Model
    vector: Array
    unknowns: int
    left_out: Array
    seen_v: float

    @property
    def typical_v(self) -> float:
        """Return the geometric mean of the errors of the blocks [V]: one bad block does not decide."""
        return math.exp(float(np.mean(np.log(self.left_out + 1e-9)))) if len(self.left_out) else math.nan

    def worse_than(self, best: Tried) -> bool:
        """Tell whether it errs more than another by more than the noise of their difference, block by block."""
        if not len(self.left_out):
            return self.seen_v > best.seen_v
        more = np.log(self.left_out + 1e-9) - np.log(best.left_out + 1e-9)
        noise = float(np.std(more, ddof=1)) / math.sqrt(len(more)) if len(more) > 1 else 0.0
        return float(np.mean(more)) > noise


def structures(start: Battery, fit: Fit, rows_s: tuple[float, float], warm_span_k: float) -> list[Structure]:
    """Return the structures of a start card that a fit compares, the simplest first.

    Arguments
    ---------
    rows_s : usual time between rows and longest rest or record [s].
    warm_span_k : span of the temperatures measured, for activation energies [K].
    """
    battery = _gridded(baked(start), fit)
    warm = fit.temperature_dependence == "with" or (fit.temperature_dependence == "auto" and warm_span_k >= 8.0)
    sides = [battery.side_reaction is not None]
    if battery.side_reaction is not None and fit.side_reaction != "with":
        sides = [False, True] if fit.side_reaction == "auto" else [False]
    found = []
    for pairs in fit.pairs:
        for side in sides:
            tree = battery.model_dump(mode="json")
            tree["pairs"] = _pairs(battery, pairs, rows_s)
            if not side:
                tree["side_reaction"] = None
            if warm:
                tree = _warmed(tree, battery)
            made = Battery.model_validate(tree)
            words = f"{pairs} pairs" if pairs != 1 else "1 pair"
            both = ", with side reaction" if side else ", without side reaction"
            found.append(Structure(words + (both if battery.side_reaction is not None else ""), pairs, side, made))
    return found


def _pairs(battery: Battery, count: int, rows_s: tuple[float, float]) -> dict[str, Any]:
    """Return so many pairs: the card's own first, others with time constants spread over what can be seen."""
    own = {name: pair.model_dump(mode="json") for name, pair in battery.pairs.items()}
    names = list(own)[-count:] if count else []
    if len(own) >= count:
        return {name: own[name] for name in names}
    taus = np.geomspace(4.0 * rows_s[0], max(0.3 * rows_s[1], 40.0 * rows_s[0]), count)
    shape = next((one["resistance_ohm"] for one in own.values()), _times(battery.series_resistance_ohm, 0.5))
    free = [name for name in NAMES if name not in own]
    made: dict[str, Any] = {}
    used = sorted(own.items(), key=lambda item: item[1]["time_constant_s"])
    # A pair of the card takes the place in the row of time constants that it is nearest to.
    places: dict[int, tuple[str, dict[str, Any]]] = {}
    for name, pair in used:
        nearest = min(
            (place for place in range(count) if place not in places),
            key=lambda place: abs(math.log(taus[place] / pair["time_constant_s"])),
        )
        places[nearest] = (name, pair)
    for place in range(count):
        if place in places:
            made[places[place][0]] = places[place][1]
        else:
            made[free.pop(0)] = {
                "resistance_ohm": shape, "time_constant_s": float(taus[place]), "resistance_temperature": None,
            }  # fmt: skip
    return made


def _times(curve: Curve, factor: float) -> Any:
    if isinstance(curve, Tabulated):
        return {"soc": curve.soc, "value": [factor * one for one in curve.value], "scale": 1.0}
    if isinstance(curve, float | int):
        return factor * curve
    mean = float(np.mean([value for _, value in _samples(curve)]))
    return factor * mean


def _samples(curve: Curve) -> Iterator[tuple[float, float]]:
    from pipeline.cell.records import value_of

    yield from ((soc, value_of(curve, soc)) for soc in (0.1, 0.3, 0.5, 0.7, 0.9))


def _gridded(battery: Battery, fit: Fit) -> Battery:
    """Return a card with its tables on grids of as many points as are asked for."""
    tree = battery.model_dump(mode="json")
    if fit.open_circuit_points:
        tree["open_circuit_voltage_v"] = _on_grid(battery.open_circuit_voltage_v, fit.open_circuit_points)
    if fit.resistance_points:
        tree["series_resistance_ohm"] = _on_grid(battery.series_resistance_ohm, fit.resistance_points)
        for name, pair in battery.pairs.items():
            tree["pairs"][name]["resistance_ohm"] = _on_grid(pair.resistance_ohm, fit.resistance_points)
    return Battery.model_validate(tree)


def _on_grid(curve: Curve, points: int) -> dict[str, Any]:
    from pipeline.cell.records import value_of

    if isinstance(curve, Tabulated):
        from scipy.interpolate import PchipInterpolator

        grid = np.linspace(0.0, 1.0, max(points, 3))
        values = PchipInterpolator(curve.soc, np.array(curve.value) * curve.scale)(grid)
        return {"soc": grid.tolist(), "value": values.tolist(), "scale": 1.0}
    grid = np.linspace(0.0, 1.0, max(points, 3))
    inside = np.clip(grid, 1e-3, 1.0 - 1e-3)
    return {"soc": grid.tolist(), "value": [value_of(curve, float(soc)) for soc in inside], "scale": 1.0}


def warmed(battery: Battery, reference_c: float) -> Battery:
    """Return the same card with a law of its resistances over temperature to be found, where it has none.

    Arguments
    ---------
    reference_c : temperature at which the law leaves them as they are [degC]; its energy is zero until it is found.
    """
    return Battery.model_validate(_warmed(battery.model_dump(by_alias=True), battery, reference_c, 0.0))


def _warmed(
    tree: dict[str, Any], battery: Battery, reference_c: float = 25.0, energy_j_mol: float = _ENERGY_J_MOL
) -> dict[str, Any]:
    law = {"activation_energy_j_mol": energy_j_mol, "reference_temperature_c": reference_c}
    if battery.series_resistance_temperature is None:
        tree["series_resistance_temperature"] = law
    for pair in tree["pairs"].values():
        pair["resistance_temperature"] = pair["resistance_temperature"] or law
    if tree["acceptance"] and not tree["acceptance"]["resistance_temperature"]:
        tree["acceptance"]["resistance_temperature"] = law
    return tree


def folds(found: Sequence[Segment], kept: NDArray[np.int64], seen: NDArray[np.bool_], count: int) -> NDArray[np.int64]:
    """Return the part that each kept row is left out with; -1 for rows that are in every part's fit.

    Pulses and rests between two steady stretches go together; the stretches stay, since they alone tell of the
    open-circuit voltage on the way. A record with fewer than two such blocks a part is cut by time.
    """
    block, blocks, steady = np.full(int(kept[-1]) + 1, -1), 0, True
    for one in found:
        if one.kind in (CONSTANT_CURRENT, CONSTANT_VOLTAGE) or one.length_s == 0.0:
            steady = True
            continue
        blocks += steady
        steady = False
        block[one.first : one.last + 1] = blocks - 1
    fold = block[kept]
    fold = np.where(fold >= 0, fold % count, -1)
    if blocks < 2 * count:
        fold = (np.arange(len(kept)) * _TIME_BLOCKS // max(len(kept), 1)) % count
    return np.where(seen, fold, -1)


def _of_blocks(problem: Problem, vector: Array, fold: int) -> dict[tuple[int, int], float]:
    """Return the error of the voltage of every block of a fold [V]: runs of rows that are left out together."""
    found = {}
    for place, (one, part) in enumerate(zip(problem.replayed(vector[None]), problem.parts, strict=True)):
        rows = np.flatnonzero((part.fold == fold) & np.isnan(part.thinned.drive.held_v))
        missed = one.voltage_v[0, rows] - part.thinned.voltage_v[rows]
        for run in np.split(np.arange(len(rows)), np.flatnonzero(np.diff(rows) > 1) + 1):
            if len(run):
                found[place, int(rows[run[0]])] = math.sqrt(float(np.mean(missed[run] ** 2)))
    return found


def _imposed(part: Part) -> Part:
    """Return a record whose battery has the temperature that was measured.

    The circuit is fitted so first: with a start card's cooling a side reaction may run away with its own heat, and no
    slope leads back from there.
    """
    warm = part.thinned.temperature_k
    return part._replace(thinned=part.thinned._replace(drive=part.thinned.drive._replace(given_k=warm)))


def compare(
    candidates: Sequence[Structure],
    soc: Sequence[float],
    parts: Sequence[Part],
    fit: Fit,
    rows_s: tuple[float, float],
    ranges: dict[str, tuple[float, float]],
    known: Sequence[bool] = (),
) -> tuple[list[Tried], Tried, Spread]:
    """Cross-validate structures inside the fitted part; return all, the chosen one, and the spread of its residuals.

    The chosen one is the simplest whose error over what was left out is within the noise of the best one's.
    """
    warm = any(not np.isnan(part.thinned.temperature_k).all() for part in parts)
    tried = []
    cells = candidates[0].battery.cells
    # Currents at a held voltage count by a fiftieth of what the charger gave.
    largest = max(float(np.max(np.abs(part.thinned.drive.read_a))) for part in parts)
    spread = Spread(0.01 * cells, 0.5, 0.02 * largest)
    for one in candidates:
        model = unknowns_of(one.battery, soc, rows_s, warm, ranges, known)
        whole = Problem(model, parts, spread, ridge=True)
        begin = None
        if warm:
            imposed = Problem(model, [_imposed(part) for part in parts], spread, ridge=True)
            begin = solve(imposed, robust=fit.robust_scale, most=15).vector
        found = solve(whole, begin, fit.robust_scale, 25)
        errors: dict[tuple[int, int], float] = {}
        for fold in range(fit.folds):
            if not any((part.fold == fold).any() for part in parts):
                continue
            left = Problem(model, parts, spread, leave=fold, ridge=True)
            errors |= _of_blocks(left, solve(left, found.vector, fit.robust_scale, 10).vector, fold)
        blocks = np.array([errors[block] for block in sorted(errors)])
        seen_v = rmse_v(whole, found.vector, [part.seen for part in parts])
        tried.append(Tried(one, model, found.vector, len(model.unknowns), blocks, seen_v))
    best = min(tried, key=lambda one: one.typical_v if len(one.left_out) else one.seen_v)
    chosen = next(one for one in sorted(tried, key=lambda one: one.unknowns) if not one.worse_than(best))
    problem = Problem(chosen.model, parts, spread, ridge=True)
    return tried, chosen, spread_of(problem, chosen.vector)
