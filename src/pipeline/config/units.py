"""The units of configuration keys, as the records declare them at the end of each field's description."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from pydantic import BaseModel

_UNIT = re.compile(r"\[([^\[\]]+)\]$")
# For names that the user chooses: knobs that feed no parameter of a phase, variables of a search. The longest decides.
_ENDINGS = {
    "_a": "A", "_c": "degC", "_c_rate": "C-rate", "_h": "h", "_hz": "Hz", "_k": "K", "_k_s": "K/s", "_ohm": "ohm",
    "_s": "s", "_v": "V", "_v_cell": "V", "_w": "W", "_w_cell": "W",
}  # fmt: skip


def unit_of(root: BaseModel, path: str) -> str:
    """Return the unit of a number of the configuration.

    Arguments
    ---------
    root : the record that the path starts from.
    path : key path of the number.

    Returns
    -------
    The unit of the innermost field on the path that declares one; `1` where none does.
    """
    found, here, keys = "1", [root], path.split(".")
    for place, key in enumerate(keys):
        declared = [unit for unit in (_declared(one, key) for one in here if isinstance(one, BaseModel)) if unit]
        found = declared[0] if declared else found
        if found.startswith("unit of "):
            found = _ending(keys[place - 1]) or "1"
        here = [part for one in here for part in _below(one, key)]
    return found


def _declared(record: BaseModel, key: str) -> str | None:
    """Return the unit that a record declares for a key; for a knob, that of the parameter which it feeds."""
    field = type(record).model_fields.get(_name(record, key))
    if field is not None:
        unit = _UNIT.search(field.description or "")
        return unit[1] if unit else None
    if key not in (record.model_extra or {}):
        return None
    return next((unit for unit in (_fed(part, key) for part in dict(record).values()) if unit), None) or _ending(key)


def _ending(name: str) -> str | None:
    fitting = [ending for ending in _ENDINGS if name.endswith(ending)]
    return _ENDINGS[max(fitting, key=len)] if fitting else None


def _fed(part: Any, knob: str) -> str | None:
    """Return the unit of the parameter that takes a knob: by its name as value, or without a value by its own."""
    if isinstance(part, BaseModel):
        for name, value in dict(part).items():
            if value == knob or (value is None and name == knob):
                return _declared(part, name)
        part = dict(part)
    inner = part.values() if isinstance(part, Mapping) else part if isinstance(part, (list, tuple)) else ()
    return next((unit for unit in (_fed(one, knob) for one in inner) if unit), None)


def _below(here: Any, key: str) -> Sequence[Any]:
    """Return what stands under a key; a key that a record writes in place of a field's name stands for every part."""
    if isinstance(here, BaseModel):
        name = _name(here, key)
        if name in type(here).model_fields:
            return [getattr(here, name)]
        return [part for part in dict(here).values() if isinstance(part, BaseModel)]
    if isinstance(here, Mapping):
        return [here[key]] if key in here else []
    if isinstance(here, (list, tuple)) and key.isdigit() and int(key) < len(here):
        return [here[int(key)]]
    return []


def _name(record: BaseModel, key: str) -> str:
    """Return the field that a key of the configuration stands for."""
    return next((name for name, field in type(record).model_fields.items() if field.alias == key), key)
