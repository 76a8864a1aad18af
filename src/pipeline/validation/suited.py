"""A mode of the configuration made to suit a battery: its shape kept, its currents and voltages scaled."""

from __future__ import annotations

from typing import Any

from pipeline.cell.records import Battery
from pipeline.charge.protocol import C_RATE
from pipeline.charge.records import Mode
from pipeline.validation.records import Conditions

_CURRENTS = ("_a", C_RATE)


def suited(mode: Mode, battery: Battery, conditions: Conditions, bulk_s: float, duration_s: float) -> Mode:
    """Return a mode whose largest current and voltage are those of the conditions, shortened.

    Arguments
    ---------
    bulk_s, duration_s : length of phases that end by time, and of the whole charge [s].
    """
    sheet = mode.model_dump(mode="json", by_alias=True)
    capacity_ah = battery.capacity_in_use_ah
    factor = conditions.current_c_rate * capacity_ah / max(_currents(sheet, capacity_ah))
    sheet = _scaled(sheet, factor, conditions.voltage_v)
    for phase in sheet["phases"].values():
        if "elapsed_s" in phase.get("until", {}):
            phase["until"]["elapsed_s"] = bulk_s
    return Mode.model_validate(sheet | {"stop": {"elapsed_s": duration_s}})


def _currents(tree: Any, capacity_ah: float, name: str = "") -> list[float]:
    """Return every current of a sheet [A]."""
    if isinstance(tree, dict):
        return [one for key, value in tree.items() if key != "stop" for one in _currents(value, capacity_ah, key)]
    if isinstance(tree, list):
        return [one for value in tree for one in _currents(value, capacity_ah, name.removesuffix("s_a") + "_a")]
    if not isinstance(tree, float | int) or not name.endswith(_CURRENTS):
        return []
    return [tree * capacity_ah if name.endswith(C_RATE) else tree]


def _scaled(tree: Any, factor: float, voltage_v: float, name: str = "") -> Any:
    if isinstance(tree, dict):
        return {key: _scaled(value, factor, voltage_v, key) for key, value in tree.items()}
    if isinstance(tree, list):
        return [_scaled(value, factor, voltage_v, name) for value in tree]
    if not isinstance(tree, float | int):
        return tree
    if name == "voltage_v":
        return voltage_v
    return factor * tree if name.endswith(_CURRENTS) else tree
