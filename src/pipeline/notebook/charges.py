"""Charges in a notebook: one, several modes side by side, a sweep; names of files or records both work."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.cell.records import Battery
from pipeline.charge.checks import check
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.errors import UserError, best_matches
from pipeline.jit import cache_folder
from pipeline.kernel.draft import references
from pipeline.notebook import named
from pipeline.notebook.named import Fed
from pipeline.notebook.outcome import NotebookCharge, Summary

if TYPE_CHECKING:
    import pandas as pd

    from pipeline.charge.task import Supply, Task

SETTINGS = {"initial_soc": 0.2, "ambient_c": 25.0, "soc_marks": [0.5, 0.8, 0.9, 0.95, 0.99]}
"""Conditions of a charge that are not given."""
_ENGINE = EngineSettings()
_OTHER_FORM = {"_a": "_c_rate", "_c_rate": "_a"}
"""End of the name of a current -> that of the same current in its other unit."""


def charge(
    battery: str | Battery,
    mode: str | Mode,
    *,
    supply_power_w: float = math.inf,
    panel: str | Fed | None = None,
    **choices: Any,
) -> NotebookCharge:
    """Charge a battery.

    Arguments
    ---------
    battery : name of a file of `conf/battery`, or a record.
    mode : name of a file of `conf/modes`, or a record.
    supply_power_w : power that the supply gives at the battery's terminals at most [W].
    panel : name of a file of `conf/panel` or of a panel of pvlib's databases, whose supply it is instead; without load,
        at constant 1000 W/m2 and 25 degC.
    choices : knobs of the mode, as `frequency_hz` or `max_current_a`, also with the current as a C-rate; and the
        conditions: `initial_soc` [1], `ambient_c` [degC], `sample_interval_s` [s], `soc_marks`, `windows`.

    Returns
    -------
    The charge: `trace`, `summary`, `phases`, `energy`, `waveform`, and `plot()`.

    Raises
    ------
    UserError : as at the command line: an unknown name, a value out of its range, a mode that does not fit.
    EngineError : the engine found no solution.

    >>> import pipeline as cp
    >>> found = cp.charge(battery="lead_acid_12v7ah", mode="cv_reflex", frequency_hz=90, initial_soc=0.8)
    >>> round(found.summary["end_soc"], 3), found.summary.units["end_soc"]
    (0.99, '1')
    >>> round(float(found.trace["soc"].iloc[-1]), 2)
    0.99
    """
    one = task(battery, mode, _source(supply_power_w, panel), choices)
    simulate, _ = _engine([one])
    return NotebookCharge(one, simulate(*one))


def compare(
    battery: str | Battery,
    modes: Sequence[str | Mode],
    *,
    supply_power_w: float = math.inf,
    panel: str | Fed | None = None,
    **choices: Any,
) -> pd.DataFrame:
    """Charge a battery in several modes.

    Arguments
    ---------
    battery, supply_power_w, panel, choices : as of `charge`; a knob is that of the modes that have it.
    modes : names of files of `conf/modes`, or records.

    Returns
    -------
    A row for each mode with what came of its charge; the units of the columns are its `attrs["units"]`.

    Raises
    ------
    UserError, EngineError : as `charge`; and a knob that no mode has.

    >>> import pipeline as cp
    >>> table = cp.compare("lead_acid_12v7ah", ["cc_cv", "cv_pulse"], frequency_hz=90, initial_soc=0.8)
    >>> list(table.index)
    ['cc_cv', 'cv_pulse']
    >>> table.attrs["units"]["peak_temperature_c"]
    'degC'
    """
    found = side_by_side(battery, modes, supply_power_w=supply_power_w, panel=panel, **choices)
    return _table([{"mode": _name(mode)} for mode in modes], [one.summary for one in found]).set_index("mode")


def side_by_side(
    battery: str | Battery,
    modes: Sequence[str | Mode],
    *,
    supply_power_w: float = math.inf,
    panel: str | Fed | None = None,
    **choices: Any,
) -> list[NotebookCharge]:
    """Do as `compare`, and return the charges themselves; a choice `MODE.KNOB` is that of one mode alone."""
    if isinstance(modes, str | Mode) or not modes:
        raise UserError(f"modes: value {modes!r}; allowed is a list of names or records")
    own = [_own_choices(mode, battery, choices) for mode in modes]
    prefixes = tuple(f"{_name(mode)}." for mode in modes)
    unused = sorted(name for name in choices if not name.startswith(prefixes) and not any(name in one for one in own))
    if unused:
        raise _unknown(unused[0], set().union(*(_known(_knobs(mode, battery)) for mode in modes)))
    source = _source(supply_power_w, panel)
    tasks = [task(battery, mode, source, one) for mode, one in zip(modes, own, strict=True)]
    _, simulate_many = _engine(tasks)
    return [NotebookCharge(*both) for both in zip(tasks, simulate_many(tasks), strict=True)]


def sweep(
    battery: str | Battery | Sequence[str | Battery],
    mode: str | Mode | Sequence[str | Mode],
    *,
    supply_power_w: float | Sequence[float] = math.inf,
    panel: str | Fed | Sequence[str | Fed] | None = None,
    **choices: Any,
) -> pd.DataFrame:
    """Charge with every combination of some values; what is given as a list is swept.

    Arguments
    ---------
    battery, mode, supply_power_w, panel, choices : as of `charge`, each alone or as a list. `soc_marks` and `windows`
        are lists by themselves, and are not swept.

    Returns
    -------
    A row for each combination: the swept values, then what came of the charge; the units of the columns are its
    `attrs["units"]`.

    Raises
    ------
    UserError, EngineError : as `charge`.

    >>> import pipeline as cp
    >>> rates = [0.1, 0.2, 0.3]
    >>> table = cp.sweep("lead_acid_12v7ah", "cc_cv", max_current_c_rate=rates, initial_soc=0.8)
    >>> table["max_current_c_rate"].to_list(), bool(table["end_time_s"].is_monotonic_decreasing)
    ([0.1, 0.2, 0.3], True)
    """
    given = {"battery": battery, "mode": mode, "supply_power_w": supply_power_w, "panel": panel, **choices}
    swept = {name: list(value) for name, value in given.items() if _is_swept(name, value)}
    empty = next((name for name, values in swept.items() if not values), None)
    if empty is not None:
        raise UserError(f"{empty}: value []; a sweep needs a value at least")
    rows, tasks = [], []
    for values in product(*swept.values()):
        row = dict(zip(swept, values, strict=True))
        one = {**given, **row}
        source = _source(one.pop("supply_power_w"), one.pop("panel"))
        tasks.append(task(one.pop("battery"), one.pop("mode"), source, one))
        rows.append({name: _name(value) for name, value in row.items()})
    _, simulate_many = _engine(tasks)
    return _table(rows, [Summary(done.summary) for done in simulate_many(tasks)])


def task(battery: str | Battery, mode: str | Mode, source: Supply, choices: Mapping[str, Any]) -> Task:
    """Return the arguments of the engine for what a person asked for; names, errors as of `charge`."""
    from pipeline.charge.task import Task

    cell = named.battery(battery) if isinstance(battery, str) else battery
    knobs = {name: value for name, value in choices.items() if name not in ChargeSettings.model_fields}
    conditions = {**SETTINGS, **{name: choices[name] for name in choices if name not in knobs}}
    settings = named.validated(ChargeSettings, conditions, "charge", lambda path: _given(path, conditions))
    way, written = _mode(mode, battery, knobs)
    _check(_name(mode), cell, way, settings, knobs)
    if set(references(written)):
        name = _name(mode)
        way = named.validated(Mode, named.with_found(name, written), f"modes.{name}", f"modes.{name}")
    return Task(cell, way, source, settings, _ENGINE)


def _source(supply_power_w: float, panel: str | Fed | None) -> Supply:
    from pipeline.charge.task import BENCH, Supply

    if not supply_power_w > 0:
        raise UserError(f"supply_power_w: value {supply_power_w!r}; allowed is a power above 0 W")
    if panel is None:
        return BENCH if supply_power_w == math.inf else Supply(np.zeros(1), np.array([float(supply_power_w)]))
    if supply_power_w != math.inf:
        raise UserError(f"supply_power_w: value {supply_power_w!r}; with a panel it is the panel that says it")
    return (named.fed(panel) if isinstance(panel, str) else panel).supply


def _mode(mode: str | Mode, battery: str | Battery, knobs: Mapping[str, Any]) -> tuple[Mode, dict[str, Any]]:
    """Return a mode with some of its knobs set, and the same as it is written."""
    name = _name(mode)
    beside = battery if isinstance(battery, str) else None
    read, values = named.written_mode(mode, beside) if isinstance(mode, str) else (None, mode.model_dump(by_alias=True))
    known = _known(_written_knobs(values))
    for knob in knobs:
        if knob not in known:
            raise _unknown(knob, known)
    for follower, leader in (read.followers(name) if read is not None else {}).items():
        # In the unit that the other is given in.
        forms = {leader: follower, _other_form(leader): _other_form(follower)}
        if not set(forms.values()) & set(knobs):
            knobs = {**knobs, **{own: knobs[form] for form, own in forms.items() if form in knobs}}
    if not knobs:
        return (named.mode(mode, beside) if isinstance(mode, str) else mode), values
    replaced = {_other_form(knob) for knob in knobs}
    changed = {key: value for key, value in values.items() if key not in replaced} | dict(knobs)

    def origin(path: str) -> str:
        key = path.removeprefix(f"modes.{name}.")
        return f"{key}={knobs[key]!r}" if key in knobs or read is None else read.origin(path)

    return named.validated(Mode, changed, f"modes.{name}", origin), changed


def _check(name: str, cell: Battery, mode: Mode, settings: ChargeSettings, knobs: Mapping[str, Any]) -> None:
    """Refuse a mode that cannot be run, with the key path as at the command line."""
    try:
        check(cell, mode, settings)
    except (UserError, ValueError) as error:
        given = ", ".join(f"{knob}={value!r}" for knob, value in knobs.items())
        raise UserError(f"{f'{given}: ' if given else ''}modes.{name}.{error}") from None


def _own_choices(mode: str | Mode, battery: str | Battery, choices: Mapping[str, Any]) -> dict[str, Any]:
    known, own = _known(_knobs(mode, battery)), f"{_name(mode)}."
    alone = {name.removeprefix(own): value for name, value in choices.items() if name.startswith(own)}
    return {name: value for name, value in choices.items() if name in known} | alone


def _knobs(mode: str | Mode, battery: str | Battery) -> set[str]:
    if isinstance(mode, Mode):
        return set(mode.knobs)
    return _written_knobs(named.written_mode(mode, battery if isinstance(battery, str) else None)[1])


def _written_knobs(values: Mapping[str, Any]) -> set[str]:
    return set(values) - set(Mode.model_fields)


def _known(knobs: Iterable[str]) -> set[str]:
    """Return every word that a charge takes: knobs, in both units of a current, and conditions."""
    listed = set(knobs)
    return listed | {_other_form(knob) for knob in listed} | set(ChargeSettings.model_fields)


def _other_form(knob: str) -> str:
    """Return the name of a current in its other unit; the same name where it is no current."""
    end = next((end for end in ("_c_rate", "_a") if knob.endswith(end)), None)
    return knob if end is None else knob.removesuffix(end) + _OTHER_FORM[end]


def _unknown(name: str, known: Iterable[str]) -> UserError:
    return UserError(f"{name}: no knob of the mode and no condition of a charge; {best_matches(name, known)}")


def _given(path: str, conditions: Mapping[str, Any]) -> str:
    key = path.removeprefix("charge.").split(".")[0]
    return f"{key}={conditions.get(key)!r}"


def _is_swept(name: str, value: Any) -> bool:
    listed = isinstance(value, list | tuple | np.ndarray | range)
    return listed and name not in ("soc_marks", "windows")


def _name(value: Any) -> Any:
    """Return what a row of a table calls a battery or a mode; anything else is itself."""
    return value.name if isinstance(value, Battery) else value.title if isinstance(value, Mode) else value


def _table(rows: Sequence[Mapping[str, Any]], summaries: Sequence[Summary]) -> pd.DataFrame:
    """Return what came of charges, a row each, behind what tells the rows apart."""
    import pandas as pd

    table = pd.DataFrame([{**row, **found} for row, found in zip(rows, summaries, strict=True)])
    table.attrs["units"] = {name: unit for found in summaries for name, unit in found.units.items()}
    return table


def _engine(tasks: Sequence[Task]) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """Return the functions that charge; say so where what these charges need has to be compiled first."""
    from pipeline.charge.simulate import kernels_of, simulate, simulate_many

    missing = kernels_of(tasks) - _SAID
    if missing:
        _SAID.update(missing)
        long = "about 40 s" if "periods" in missing else "about 20 s"
        folder = cache_folder("pipeline.charge.drive").parent
        print(f"compiling the charge engine: once, {long}; kept in {folder}", file=sys.stderr, flush=True)  # noqa: T201
    return simulate, simulate_many


_SAID: set[str] = set()
"""What of the engine was said to be compiled."""
