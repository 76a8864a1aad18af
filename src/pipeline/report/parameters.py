"""The parameters of a study as the report lists them; the unit stands at the end of each key."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from pipeline.report.tables import Parameter

# The longest ending that fits decides.
UNITS = {
    "_a": "A",
    "_a_per_k": "A/K",
    "_ah": "Ah",
    "_c": "degC",
    "_charge_c": "C",
    "_c_rate": "C",
    "_f": "F",
    "_h": "H",
    "_hz": "Hz",
    "_j_k": "J/K",
    "_j_mol": "J/mol",
    "_k": "K",
    "_k_w": "K/W",
    "_ohm": "ohm",
    "_per_ah": "1/Ah",
    "_per_k": "1/K",
    "_percent": "%",
    "_percent_per_k": "%/K",
    "_s": "s",
    "_v": "V",
    "_v_k": "V/K",
    "_v_per_k": "V/K",
    "_w": "W",
    "_w_m2": "W/m2",
    "_w_m2_s": "W/m2/s",
}


def unit_of(key: str) -> str:
    """Return the unit a key ends in; `1` where none of its names has one.

    The innermost name with a unit decides: `series_resistance_ohm.polynomial` is in ohm.
    """
    for name in reversed(key.split(".")):
        fitting = [ending for ending in UNITS if name.endswith(ending)]
        if fitting:
            return UNITS[max(fitting, key=len)]
        if name.endswith(("_share", "efficiency", "soc", "soc_offset", "depth_offset", "_in_series", "_in_parallel")):
            break
    return "1"


def parameters(entries: Iterable[Mapping[str, Any]]) -> list[Parameter]:
    """Return the report's parameters from key path, value and source as the plan holds them."""
    return [
        Parameter(
            key=entry["path"],
            value=_readable(entry["value"]),
            unit=unit_of(entry["path"]),
            kind=entry["kind"],
            reference=entry["ref"],
            low=entry["range"][0] if entry["range"] else None,
            high=entry["range"][1] if entry["range"] else None,
            calibrated_to=entry["to"] or "",
        )
        for entry in entries
    ]


def _readable(value: Any) -> Any:
    if isinstance(value, Mapping):
        if "centres" in value:
            return f"{len(value['centres'])} centres"
        return f"{value['value']} of {value['from']}"
    return value
