"""The card of a fitted battery: its numbers with their intervals, where each is from, and what it holds for."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.cell.records import Battery, Tabulated
from pipeline.experiments.own_battery.numbers import at
from pipeline.experiments.own_battery.segments import charge_ah
from pipeline.experiments.own_battery.unknowns import SOC

if TYPE_CHECKING:
    from pipeline.experiments.own_battery.outcome import Fitted, Record

_UNITS = {
    "_v_k": "V/K", "_ohm": "ohm", "_ah": "Ah", "_s": "s", "_j_k": "J/K", "_k_w": "K/W", "_j_mol": "J/mol",
    "_per_k": "1/K", "_a": "A", "_v": "V", "voltages": "1",
}  # fmt: skip
_KEPT = "keeps its prior: the interval that the measurement gives is wider than that, or ends at a bound"
_GOES_WITH = "goes with the points beside it: the measurement alone does not tell it"
_NO_BETTER = "fitted with the others, and known no better than before: its interval is as wide as its prior"


def unit_of(path: str) -> str:
    """Return the unit of a number of a card."""
    if path.startswith(SOC) or path.endswith(".scale"):
        return "1"
    words = [word for word in path.split(".") if not word.isdigit()]
    for word in reversed(words):
        for end, unit in _UNITS.items():
            if word.endswith(end):
                return unit
    return "1"


def parameters(found: Fitted, start: Battery) -> Iterator[tuple[Any, ...]]:
    """Yield a row for every number that might have been fitted: path, SOC, unit, start, value, interval, how."""
    model, known = found.problem.model, found.certainty
    values = dict(zip(model.paths, model.values(found.result.vector[None])[0].tolist(), strict=True))
    low, high = (model.plain(end[None])[0].tolist() for end in (known.low, known.high))
    intervals = dict(zip(model.paths, zip(low, high, strict=True), strict=True))
    told = dict(zip(model.paths, known.identified.tolist(), strict=True))
    for one in found.model.unknowns:
        soc = _soc_of(found.model.battery, one.path)
        if one.path in values:
            identified = bool(told[one.path])
            how = "fitted" if identified else _NO_BETTER if soc is None else _GOES_WITH
            yield (one.path, soc, unit_of(one.path), one.start, values[one.path], *intervals[one.path], identified, how)
        else:
            yield (one.path, soc, unit_of(one.path), one.start, one.start, None, None, False, _KEPT)


def _soc_of(battery: Battery, path: str) -> float | None:
    key, dot, place = path.rpartition(".value.")
    curve = at(battery, key) if dot else None
    return curve.soc[int(place)] if isinstance(curve, Tabulated) else None


def validity(best: Battery, records: Sequence[Record], socs: Sequence[float]) -> dict[str, list[float]]:
    """Return what the fitted part of a measurement covers: SOC [1], current [C-rate], temperature [degC]."""
    levels, rates, warm = [], [], []
    for place, one in enumerate(records):
        seen = ~one.held_out
        if not seen.any():
            continue
        soc = socs[place] + charge_ah(one.series)[seen] / best.capacity_ah
        levels += [float(soc.min()), float(soc.max())]
        rates += [float(np.max(np.abs(one.series.current_a[seen]))) / best.capacity_ah]
        known = one.series.temperature_c[seen & ~np.isnan(one.series.temperature_c)]
        warm += [float(known.min()), float(known.max())] if len(known) else [one.ambient_c]
    return {
        "soc": [max(0.0, min(levels)), min(1.0, max(levels))],
        "c_rate": [0.0, max(rates)],
        "temperature_c": [min(warm), max(warm)],
    }


def written(
    best: Battery,
    found: Fitted,
    start: Battery,
    sources: Mapping[str, Mapping[str, Any]],
    title: str,
    files: Sequence[str],
    valid: Mapping[str, Sequence[float]],
) -> str:
    """Return the card as YAML, ready for `conf/battery/`.

    Arguments
    ---------
    sources : key path from `battery` on -> source on the start card.
    """
    import yaml

    names = ", ".join(Path(file).name for file in files)
    tree = _rounded(best.model_dump(mode="json", exclude_none=True))
    word = re.sub(r"[^a-z0-9]+", "_", Path(files[0]).stem.lower()).strip("_")
    tree |= {"name": f"own_{word}", "title": f"{title}, fitted to {names}"}
    rows = {row[0]: row for row in parameters(found, start)}
    given: dict[str, Any] = {}
    for path in _leaves(tree):
        _put(given, path, _source(path, tree, rows, sources, names, valid))
    head = (
        f"# {title}: fitted to {names}.\n"
        f"# Holds for a state of charge from {valid['soc'][0]:.2f} to {valid['soc'][1]:.2f}, currents up to "
        f"{valid['c_rate'][1]:.2g}C, {valid['temperature_c'][0]:.0f} to {valid['temperature_c'][1]:.0f} degC. Not "
        "modelled:\n# the hysteresis of the open-circuit voltage, which is that of the branch that was measured.\n"
    )
    return head + yaml.safe_dump({**tree, "sources": given}, sort_keys=False, width=110, default_flow_style=None)


def _source(
    path: str,
    tree: Mapping[str, Any],
    rows: Mapping[str, tuple[Any, ...]],
    sources: Mapping[str, Mapping[str, Any]],
    names: str,
    valid: Mapping[str, Sequence[float]],
) -> dict[str, Any]:
    """Return the source of a value: the measurement where it tells it, else what the start card says of it."""
    own = [row for key, row in rows.items() if key == path or key.startswith(f"{path}.")]
    told = [row for row in own if row[7]]
    covers = {key: [float(f"{end:.4g}") for end in ends] for key, ends in valid.items()}
    if told:
        source: dict[str, Any] = {"kind": "fitted", "file": names, "valid": covers}
        if len(own) == 1 and own[0][0] == path:
            low, high = (float(f"{end:.6g}") for end in (own[0][5], own[0][6]))
            source["ref"] = "95 % interval of the fit"
            if low < own[0][4] < high and low < high:
                source["range"] = [low, high]
        else:
            half = max((row[6] - row[5]) / 2.0 for row in told)
            rest = f"; {len(own) - len(told)} of {len(own)} points go with those beside them" * (len(told) < len(own))
            source["ref"] = f"95 % intervals of at most +-{half:.3g} {told[0][2]}{rest}"
        return source
    kept = _covering(sources, f"battery.{path}")
    why = _KEPT if own else "not fitted"
    if kept is None:
        grid = path.endswith(".soc") or path.endswith((".scale", "reference_temperature_c"))
        return {"kind": "derived", "ref": "the grid of the fit"} if grid else {"kind": "estimate", "ref": why}
    kind = "estimate" if kept["kind"] in ("override", "found") else kept["kind"]
    source = {"kind": kind, "ref": f"{kept['ref']} ({why})" if kept.get("ref") else why}
    if kept.get("to"):
        source["to"] = kept["to"]
    value = _value(tree, path)
    if kept.get("range") and isinstance(value, int | float) and kept["range"][0] <= value <= kept["range"][1]:
        source["range"] = list(kept["range"])
    return source


def _covering(sources: Mapping[str, Mapping[str, Any]], path: str) -> Mapping[str, Any] | None:
    words = path.split(".")
    for depth in range(len(words), 0, -1):
        key = ".".join(words[:depth])
        if key in sources:
            return sources[key]
        below = [one for name, one in sources.items() if name.startswith(key + ".")]
        if below and depth > 1:
            return below[0]
    return None


def _leaves(tree: Any, path: str = "") -> Iterator[str]:
    for key, value in tree.items():
        here = f"{path}.{key}" if path else str(key)
        if isinstance(value, Mapping):
            yield from _leaves(value, here)
        elif not isinstance(value, str):
            yield here


def _put(tree: dict[str, Any], path: str, value: Any) -> None:
    *words, last = path.split(".")
    for word in words:
        tree = tree.setdefault(word, {})
    tree[last] = value


def _value(tree: Any, path: str) -> Any:
    for word in path.split("."):
        tree = tree[word]
    return tree


def _rounded(value: Any) -> Any:
    """Return plain data with numbers to eight digits: more than any fit knows, fewer than a float has."""
    if isinstance(value, Mapping):
        return {key: _rounded(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_rounded(one) for one in value]
    if isinstance(value, float) and math.isfinite(value):
        return float(f"{value:.8g}")
    return value
