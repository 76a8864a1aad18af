"""Measurement: rows in; structures compared, the card fitted, how well it is known, the hold-out looked at once."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import ZERO_CELSIUS_K
from pipeline.cell.records import Battery
from pipeline.experiments.own_battery import card
from pipeline.experiments.own_battery.certainty import certainty_of, draws, settle, untold
from pipeline.experiments.own_battery.fitting import Part, Problem, Spread, many_starts, solve, unrounded
from pipeline.experiments.own_battery.outcome import Fitted, Record
from pipeline.experiments.own_battery.reading import Series
from pipeline.experiments.own_battery.records import Fit
from pipeline.experiments.own_battery.segments import Segment, Thinned, thinned, whole, with_held_voltages
from pipeline.experiments.own_battery.structures import compare, folds, structures, warmed
from pipeline.experiments.own_battery.tables import FITTED_NUMBERS
from pipeline.experiments.own_battery.unknowns import SOC, Model, unknowns_of
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.quantity import Quantity

Array = NDArray[np.float64]
_ROUNDED_TWICE = 2


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Fit the card and write it."""
    battery, fit = Battery.model_validate(settings["battery"]), Fit.model_validate(settings["fit"])
    records = read(inputs, "own_reading", fit.constant_voltage == "voltage")
    ranges = {
        path.removeprefix("battery."): (source["range"][0], source["range"][1])
        for path, source in settings["sources"].items()
        if source.get("range")
    }
    rng = np.random.default_rng(np.random.SeedSequence([int(settings["seed"]), 0]))
    found = fitted(battery, records, fit, ranges, rng)
    best, fitted_socs = found.problem.model.card(found.result.vector)
    starts = iter(fitted_socs)
    # Everything is chosen: only now the rows that were held out are looked at.
    seen = {place: next(starts) for place, one in enumerate(records) if not one.held_out.all()}
    socs = [seen[place] if place in seen else _soc_unseen(one, records, seen) for place, one in enumerate(records)]
    errors = list(_errors(best, records, socs))
    output.rows("structures", _structures(found))
    output.rows("parameters", list(card.parameters(found, battery)))
    output.rows("errors", errors)
    output.rows("limits", list(_limits(best, records, socs, fit.robust_scale)))
    output.write("overlay", _overlay(output, best, records, socs))
    known = found.certainty
    drawn = draws(known.model, known.vector, known.covariance, fit.samples, rng)
    output.rows("samples", list(_samples(known.model, drawn)))
    valid = card.validity(best, records, socs)
    output.numbers(_numbers(found, errors, valid))
    name = records[0].series.file
    text = card.written(
        best, found, battery, settings["sources"], fit.title, [one.series.file for one in records], valid
    )
    (output.folder / "battery.yaml").write_text(text, encoding="utf-8")
    output.found({"card": best.model_dump(mode="json"), "soc": socs, "valid": valid, "file": name})


def fitted(
    battery: Battery,
    records: Sequence[Record],
    fit: Fit,
    ranges: Mapping[str, tuple[float, float]],
    rng: np.random.Generator,
) -> Fitted:
    """Compare the structures of a start card, fit the best one from several starts, and say how well it is known."""
    used = [one for one in records if not one.held_out.all()]
    parts = []
    for one in used:
        seen = ~one.held_out[one.thinned.kept]
        parts.append(Part(one.thinned, seen, folds(one.segments, one.thinned.kept, seen, fit.folds)))
    spacing = min(float(np.median(np.diff(one.series.time_s))) for one in used)
    longest = max(
        [max((s.length_s for s in one.segments if s.kind == "rest"), default=0.0) for one in used]
        + [0.1 * float(one.series.time_s[-1]) for one in used]
    )
    warm = np.concatenate([one.series.temperature_c for one in used])
    span = float(np.nanmax(warm) - np.nanmin(warm)) if not np.isnan(warm).all() else 0.0
    rows_s = (spacing, longest)
    tried, chosen, spread = compare(
        structures(battery, fit, rows_s, span), [one.soc for one in used], parts, fit, rows_s, dict(ranges),
        [one.stated for one in used],
    )  # fmt: skip
    near = Problem(chosen.model, parts, spread, ridge=True)
    vector = chosen.vector
    for _ in range(_ROUNDED_TWICE):
        vector = solve(near, vector, fit.robust_scale, 20).vector
        near = Problem(chosen.model, unrounded(Problem(chosen.model, parts, spread), vector), spread, ridge=True)
    problem, result, kept = settle(Problem(chosen.model, near.parts, spread), vector, fit.robust_scale)
    starts = many_starts(problem, result.vector, fit.starts, rng, fit.robust_scale, 30)
    # Another start may come to a better place where a number lies at its bound: its prior has to hold it too.
    while (left := untold(problem, starts[0].vector, fit.robust_scale)) is not None:
        vector = starts[0].vector[[path != left for path in problem.model.paths]]
        problem = Problem(problem.model.without([left]), problem.parts, spread)
        problem, result, more = settle(problem, vector, fit.robust_scale)
        kept += [left, *more]
        starts = many_starts(problem, result.vector, fit.starts, rng, fit.robust_scale, 30)
    certainty = certainty_of(problem, starts[0], fit.robust_scale, chosen.model)
    return Fitted(tried, chosen, chosen.model, problem, starts[0], starts, kept, certainty)


def read(inputs: Inputs, source: str, held: bool = False) -> list[Record]:
    """Return the files of a reading as the fit takes them.

    Arguments
    ---------
    held : whether the voltage drives the replay where a charger held one.
    """
    rows, listed, files = (inputs.table(source, name) for name in ("series", "segments", "files"))
    found = []
    for place, name in zip(files["file"].tolist(), files["name"].tolist(), strict=True):
        own, segment = rows["file"] == place, listed["file"] == place
        series = Series(
            file=str(name),
            row=rows["row"][own],
            time_s=rows["time_s"][own],
            voltage_v=rows["voltage_v"][own],
            current_a=rows["current_a"][own],
            temperature_c=_numbers_of(rows["temperature_c"][own]),
            ambient_c=_numbers_of(rows["ambient_c"][own]),
            step=rows["step"][own],
            jumps=bool(rows["jumps"][own].all()),
            said=(),
        )
        names = ("kind", "first", "last", "start_s", "length_s", "current_a", "charge_ah", "soc", "start_v", "end_v")
        segments = [Segment(*values) for values in zip(*(listed[key][segment].tolist() for key in names), strict=True)]
        ambient = float(files["ambient_c"][place])
        out = rows["held_out"][own].astype(bool)
        few = thinned(series, ambient)
        few = with_held_voltages(few, segments, series.voltage_v) if held else few
        soc, stated = float(files["initial_soc"][place]), bool(files["stated"][place])
        found.append(Record(series, few, out, segments, soc, stated, ambient, held))
    return found


def _numbers_of(values: NDArray[Any]) -> Array:
    return np.array([np.nan if value is None else value for value in values.tolist()], dtype=np.float64)


def _soc_unseen(one: Record, records: Sequence[Record], seen: Mapping[int, float]) -> float:
    """Return the state of charge at the start of a record that the fit never saw.

    It is stated, or that of the fitted record whose first voltage is nearest to its own: near full a voltage at rest
    tells little, and its records begin alike.
    """
    if one.stated:
        return one.soc
    first = float(one.series.voltage_v[0])
    return seen[min(seen, key=lambda place: abs(float(records[place].series.voltage_v[0]) - first))]


def _replayed(best: Battery, series: Thinned, soc: float) -> tuple[Array, Array, Array, Array]:
    model = Model(best, (), (soc,))
    part = Part(series, np.ones(len(series.kept), dtype=bool), np.full(len(series.kept), -1))
    made = Problem(model, [part], Spread(1.0, 1.0)).replayed(np.zeros((1, 0)))[0]
    return made.voltage_v[0], made.temperature_k[0] - ZERO_CELSIUS_K, 1.0 - made.depth[0], made.current_a[0]


def _errors(best: Battery, records: Sequence[Record], socs: Sequence[float]) -> Iterator[tuple[Any, ...]]:
    """Yield the errors of every file, of the fitted part and of what was held out, over all rows."""
    for place, one in enumerate(records):
        full = whole(one.series, one.ambient_c)
        full = with_held_voltages(full, one.segments, one.series.voltage_v) if one.held else full
        volts, warm, _, amperes = _replayed(best, full, socs[place])
        driven = ~np.isnan(full.drive.held_v)
        kinds = (
            ("voltage", "V", np.where(driven, np.nan, volts - one.series.voltage_v)),
            ("temperature", "K", warm - one.series.temperature_c),
            ("current", "A", np.where(driven, amperes - one.series.current_a, np.nan)),
        )
        for part, rows in (("fit", ~one.held_out), ("held out", one.held_out)):
            for quantity, unit, missed in kinds:
                here = np.flatnonzero(rows & np.isfinite(missed))
                if len(here):
                    size = np.abs(missed[here])
                    at = here[int(np.argmax(size))]
                    yield (
                        part, place, quantity, unit, math.sqrt(float(np.mean(size**2))), float(np.percentile(size, 95)),
                        float(size.max()), float(one.series.time_s[at]), len(here),
                    )  # fmt: skip


_FREED = {
    "the charge at its start": ("initial_soc.",),
    "the open-circuit voltage": ("open_circuit_voltage_v.",),
    "the resistances": ("series_resistance_ohm", "pairs.", "acceptance."),
    "the charge at its start and the open-circuit voltage": ("initial_soc.", "open_circuit_voltage_v."),
}


_ENERGY = (".activation_energy_j_mol",)
_WARMER_K = 3.0
"""Between the seen and the held-out temperatures, from where on a law of the resistances over temperature is told."""


def _limits(
    best: Battery, records: Sequence[Record], socs: Sequence[float], robust: float
) -> Iterator[tuple[int, str, float]]:
    """Yield the error of files that were held out whole with one part of the card found from them.

    Nothing of it goes into the card: it tells which part keeps the prediction from being better.
    """
    seen_c = float(np.mean([_mean_c(one) for one in records if not one.held_out.all()]))
    for place, one in enumerate(records):
        if not one.held_out.all():
            continue
        for name, freed in _FREED.items():
            yield place, name, _error_with(best, one, socs[place], freed, robust)
        if abs(_mean_c(one) - seen_c) >= _WARMER_K:
            law = warmed(best, seen_c)
            yield place, "how the resistances follow temperature", _error_with(law, one, socs[place], _ENERGY, robust)


def _mean_c(one: Record) -> float:
    measured = one.series.temperature_c[~np.isnan(one.series.temperature_c)]
    return float(measured.mean()) if len(measured) else one.ambient_c


def _error_with(battery: Battery, one: Record, soc: float, freed: Sequence[str], robust: float) -> float:
    """Return the error of a record [V] with some numbers of a card found from it: those with such words in the path."""
    seen = np.ones(len(one.thinned.kept), dtype=bool)
    part = Part(one.thinned, seen, np.full(len(seen), -1))
    spacing, length = float(np.median(np.diff(one.series.time_s))), float(one.series.time_s[-1])
    model = unknowns_of(battery, [soc], (spacing, 0.1 * length), False, {}, [False])
    others = [path for path in model.paths if not any(word in path for word in freed)]
    problem = Problem(model.without(others), [part], Spread(0.01 * battery.cells, 1.0))
    card_then, soc_then = problem.model.card(solve(problem, robust=robust, most=30).vector)
    volts = _replayed(card_then, whole(one.series, one.ambient_c), soc_then[0])[0]
    return math.sqrt(float(np.mean((volts - one.series.voltage_v) ** 2)))


def _overlay(output: Output, best: Battery, records: Sequence[Record], socs: Sequence[float]) -> dict[str, list[Any]]:
    rows: dict[str, list[Any]] = output.empty("overlay")
    for place, one in enumerate(records):
        volts, warm, soc, amperes = _replayed(best, one.thinned, socs[place])
        kept = one.thinned.kept
        rows["file"] += [place] * len(kept)
        rows["time_s"] += one.series.time_s[kept].tolist()
        rows["current_a"] += one.series.current_a[kept].tolist()
        rows["simulated_a"] += amperes.tolist()
        rows["measured_v"] += one.series.voltage_v[kept].tolist()
        rows["simulated_v"] += volts.tolist()
        rows["measured_c"] += [None if np.isnan(t) else t for t in one.series.temperature_c[kept].tolist()]
        rows["simulated_c"] += warm.tolist()
        rows["soc"] += soc.tolist()
        rows["held_out"] += one.held_out[kept].tolist()
    return rows


def _structures(found: Fitted) -> list[tuple[Any, ...]]:
    return [
        (one.structure.name, one.unknowns, len(one.left_out), one.typical_v, one.seen_v, one is found.chosen)
        for one in found.tried
    ]


def _samples(model: Model, drawn: Array) -> Iterator[tuple[int, str, float]]:
    for place, values in enumerate(drawn):
        for path, value in zip(model.paths, values.tolist(), strict=True):
            if not path.startswith(SOC):
                yield place, path, value


def _numbers(found: Fitted, errors: Sequence[tuple[Any, ...]], valid: Mapping[str, Any]) -> list[Quantity]:
    def rmse(part: str, quantity: str) -> float:
        rows = [(one[4], one[8]) for one in errors if one[0] == part and one[2] == quantity]
        count = sum(rows for _, rows in rows)
        return math.sqrt(sum(error**2 * number for error, number in rows) / count) if count else math.nan

    best = found.starts[0].cost
    near = np.mean([one.cost <= 1.01 * best for one in found.starts])
    named = {
        "fit_voltage_rmse_v": rmse("fit", "voltage"),
        "held_out_voltage_rmse_v": rmse("held out", "voltage"),
        "fit_temperature_rmse_k": rmse("fit", "temperature"),
        "held_out_temperature_rmse_k": rmse("held out", "temperature"),
        "fit_current_rmse_a": rmse("fit", "current"),
        "held_out_current_rmse_a": rmse("held out", "current"),
        "unknowns": len(found.result.vector),
        "rows": found.certainty.rows,
        "effective_rows": found.certainty.effective,
        "starts_together": float(near),
        "lowest_soc": valid["soc"][0],
        "highest_soc": valid["soc"][1],
        "highest_c_rate": valid["c_rate"][1],
        "lowest_temperature_c": valid["temperature_c"][0],
        "highest_temperature_c": valid["temperature_c"][1],
    }
    return [FITTED_NUMBERS.quantity(name, value) for name, value in named.items()]
