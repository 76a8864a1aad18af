"""The numbers of a card by their key paths, and a card with other numbers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from pipeline.cell.records import Battery, Curve, Inverse, Logarithm, Polynomial, Root, Shepherd, Tabulated

_FIELDS = {
    Polynomial: ("polynomial",),
    Logarithm: ("constant", "factor", "soc_offset", "depth_offset"),
    Root: ("factor", "soc_offset"),
    Shepherd: ("full_v", "polarisation_v"),
    Inverse: ("factor", "depth_offset"),
}
"""Numbers of each form of a curve in the order in which the kernels take them."""
_SHAPE = ("soc_offset", "depth_offset")
"""Numbers of a curve that keep their value."""


def place_of(curve: Curve, name: str) -> int:
    """Return the place of a number of a curve among those that the kernels take."""
    if isinstance(curve, float | int):
        return 0
    if isinstance(curve, Polynomial):
        return int(name.rsplit(".", 1)[1])
    return _FIELDS[type(curve)].index(name)


def at(battery: Battery, key: str) -> Any:
    """Return what stands at a key path of a battery."""
    here: Any = battery
    for word in key.split("."):
        here = (
            here[word] if isinstance(here, dict) else here[int(word)] if isinstance(here, list) else getattr(here, word)
        )
    return here


def with_values(battery: Battery, values: Mapping[str, float]) -> Battery:
    """Return a battery with other numbers at some key paths."""
    tree = battery.model_dump(mode="json")
    for path, value in values.items():
        here: Any = tree
        *words, last = path.split(".")
        for word in words:
            here = here[int(word)] if isinstance(here, list) else here[word]
        here[int(last) if isinstance(here, list) else last] = float(value)
    return Battery.model_validate(tree)


def of_curve(key: str, curve: Curve) -> Iterator[tuple[str, float]]:
    """Yield key path and value of every number of a curve that may be fitted."""
    if isinstance(curve, float | int):
        yield key, float(curve)
    elif isinstance(curve, Tabulated):
        yield from ((f"{key}.value.{place}", value) for place, value in enumerate(curve.value))
    elif isinstance(curve, Polynomial):
        yield from ((f"{key}.polynomial.{place}", value) for place, value in enumerate(curve.polynomial))
    else:
        yield from ((f"{key}.{name}", getattr(curve, name)) for name in _FIELDS[type(curve)] if name not in _SHAPE)


def baked(battery: Battery) -> Battery:
    """Return the same battery with its scales multiplied out: that of its capacity, and those of its tables."""
    k = battery.scale
    tree = battery.model_dump(mode="json")

    def curve(value: Any, factor: float) -> Any:
        if isinstance(value, int | float):
            return factor * value
        if "soc" in value:
            made = Tabulated.model_validate(value)
            grid, values = made.inside
            return {"soc": grid, "value": [factor * made.scale * one for one in values], "scale": 1.0}
        if "polynomial" in value:
            return {"polynomial": [factor * one for one in value["polynomial"]]}
        return value | {name: factor * value[name] for name in value if name not in _SHAPE}

    tree["open_circuit_voltage_v"] = curve(tree["open_circuit_voltage_v"], 1.0)
    tree["entropic_coefficient_v_k"] = curve(tree["entropic_coefficient_v_k"], 1.0)
    tree["series_resistance_ohm"] = curve(tree["series_resistance_ohm"], 1.0 / k)
    for pair in tree["pairs"].values():
        pair["resistance_ohm"] = curve(pair["resistance_ohm"], 1.0 / k)
    if tree["charge_transfer"]:
        tree["charge_transfer"]["exchange_current_a"] = curve(tree["charge_transfer"]["exchange_current_a"], k)
    if tree["acceptance"]:
        tree["acceptance"]["resistance_ohm"] /= k
    if tree["side_reaction"]:
        tree["side_reaction"]["current_a"] *= k
    if tree["hysteresis"]:
        tree["hysteresis"]["rate_per_ah"] /= k
    tree["thermal"] = {
        "heat_capacity_j_k": k * battery.thermal.heat_capacity_j_k,
        "resistance_k_w": battery.thermal.resistance_k_w / k,
    }
    return Battery.model_validate(tree | {"capacity_ah": k * battery.capacity_ah, "scaled_to_capacity_ah": None})
