"""A measurement as people have it: read, put in order, its sign of current judged; what was done to it is said."""

from __future__ import annotations

import re
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import UserError
from pipeline.experiments.own_battery.ordering import Ordered
from pipeline.experiments.own_battery.records import Measured
from pipeline.files import headings
from pipeline.files.cells import Table, Torn, number, plain
from pipeline.files.clock import clock_of
from pipeline.files.content import load
from pipeline.files.quantities import CURRENT, TEMPERATURE, VOLTAGE, Quantity
from pipeline.files.read import of_content
from pipeline.own_files import digest
from pipeline.record import OwnFile

Array = NDArray[np.float64]
VOLTS = Quantity(
    *("voltage_v", "voltage", VOLTAGE, "V", -100.0, 5000.0),
    frozenset(
        (
            *("voltage", "volts", "volt", "v", "u", "cellvoltage", "terminalvoltage", "batteryvoltage", "packvoltage"),
            *(
                "voltagev",
                "voltagevolt",
                "vbat",
                "vcell",
                "ecellv",
                "ecell",
                "ewe",
                "spannung",
                "tension",
                "batvoltage",
            ),
        )
    ),
    "voltage of the battery",
)
AMPERES = Quantity(
    *("current_a", "current", CURRENT, "A", -1e5, 1e5),
    frozenset(
        (
            *("current", "amps", "ampere", "amperes", "i", "cur", "currenta", "currentampere", "batterycurrent"),
            *("cellcurrent", "packcurrent", "ibat", "strom", "courant", "batcurrent", "ia"),
        )
    ),
    "current of the battery",
)
CELSIUS = Quantity(
    *("temperature_c", "temperature", TEMPERATURE, "degC", -80.0, 250.0),
    frozenset(
        (
            *("temperature", "temp", "celltemperature", "batterytemperature", "surfacetemperature", "battemp", "t1"),
            *("celltemp", "batterytemp", "surfacetemp", "casetemperature", "surfacetemperaturet1", "tcell", "tbat"),
            *("surfacetemperaturecelsius", "temperaturec", "tempc", "auxtemperature1", "temperaturt", "temperatur"),
        )
    ),
    "temperature of the battery",
)
AROUND = Quantity(
    *("ambient_c", "ambient", TEMPERATURE, "degC", -80.0, 150.0),
    frozenset(
        (
            *("ambient", "ambienttemperature", "ambienttemp", "chambertemperature", "chambertemp", "roomtemperature"),
            *("tamb", "tambient", "ambienttemperaturecelsius", "environmenttemperature", "umgebungstemperatur"),
        )
    ),
    "temperature of the surroundings",
)
QUANTITIES = (VOLTS, AMPERES, CELSIUS, AROUND)
_TIMES = (
    *("testtime", "testtimesecond", "testtimes", "totaltime", "elapsedtime", "timesecond", "runtime", "time", "times"),
    *("timestamp", "datetime", "dateandtime", "unixtime", "zeit", "datetimeiso", "uhrzeit", "zeitstempel", "t"),
    *("date", "datum", "datetimeutc", "recordtime", "measuredat"),
)
_DATES = ("date", "datum", "day")
_PASSED = re.compile(r"(?:(\d+)\s*d(?:ays?)?[\s,:-]*)?(\d+):(\d{2}):(\d{2}(?:[.,]\d+)?)")
_DAY_S = 86400.0
_MODES = ("mode", "status", "state", "steptype", "md", "stepname", "cyclerstate")
_STEPS = ("stepcount", "stepindex", "step", "stepnumber", "stepid", "ns", "stepcount1")
_CHARGE, _DISCHARGE, _REST = ("ch", "c", "l"), ("d", "e"), ("r", "p", "o", "i")
_NEAR_S, _GAP_S = 10.0, 60.0


class Series(NamedTuple):
    """A measurement in order: current positive when charging, shape (n,) each.

    Arguments
    ---------
    file : where it comes from.
    row : number of each row in the file.
    time_s : since the first row, not falling; equal times are a jump [s].
    voltage_v, current_a : of the battery.
    temperature_c, ambient_c : NaN throughout where not measured.
    step : number of the cycler's step; -1 where there is none.
    jumps : whether a row's current has flowed since the row before, else it is straight from row to row.
    said : what was found and done, in sentences.
    """

    file: str
    row: NDArray[np.int64]
    time_s: Array
    voltage_v: Array
    current_a: Array
    temperature_c: Array
    ambient_c: Array
    step: NDArray[np.int64]
    jumps: bool
    said: tuple[str, ...]


def measured_series(measured: Measured, key: str = "measured.") -> list[Series]:
    """Return the series of every file.

    Arguments
    ---------
    key : key path of the record with a dot behind, for messages.

    Raises
    ------
    UserError : no file, one that cannot be read, or what it does not say and has to be told, with the line to type.
    """
    if not measured.files:
        raise UserError(
            f"{key}file: no file is named; give a CSV, Parquet or Excel file of time, voltage and current, "
            f"{key}file=FILE"
        )
    return [_series(measured.model_dump_json(), file, key, digest(Path(file))) for file in measured.files]


@lru_cache(maxsize=16)
def _series(record: str, file: str, key: str, content: str) -> Series:
    measured = Measured.model_validate_json(record)
    own = measured.one(file)
    path = Path(file)
    table = of_content(load(path, own.sheet), own.sheet, own.decimal, doubled=True)
    said = [*table.said]
    time_s, dated, more = _times(table, own, measured, key)
    said += more
    found = headings.match(table, own, QUANTITIES, key)
    _refuse_missing(table, found, key)
    said += found.said
    rows = np.flatnonzero(~np.isnan(time_s)).tolist()
    lengths = np.ones(len(rows))
    columns: dict[str, Array] = {}
    for quantity in QUANTITIES:
        if quantity.name in found.headings:
            heading = found.headings[quantity.name]
            columns[quantity.name], told = headings.values(table, own, quantity, heading, rows, lengths, key)
            said += told
            unit = headings.unit_of(table, own, quantity, heading, key)[1]
            if unit is None and not table.units.get(heading) and "(" not in heading and "/" not in heading:
                said.append(f"column {heading!r} says no unit: taken in {quantity.unit}")
    places = np.asarray(table.places, dtype=np.int64)[rows]
    modes = _column_of(table, own, "mode", _MODES)
    steps = _column_of(table, own, "step", _STEPS)
    order = Ordered(path, table.place, places, time_s[rows], columns, _step_numbers(table, steps)[rows])
    order.source = np.array(rows, dtype=np.int64)
    if dated:
        order.sort()
    order.turn_round()
    order.join_sensors(said)
    order.drop_blocks()
    order.sort_few()
    order.continue_resets(key)
    order.drop_repeated()
    order.drop_glitches()
    order.drop_wild_currents()
    said += order.said
    current, told = _signed(order, measured, modes, table, key)
    said += told
    if len(order.time_s) < 10:
        raise UserError(f"{path}: {len(order.time_s)} rows with voltage and current; allowed are 10 and more")
    said += _gaps(order, current)
    spacing = float(np.median(np.diff(order.time_s)))
    jumps = measured.between == "step" or (measured.between == "auto" and spacing <= _NEAR_S)
    if measured.between == "auto":
        how = "a row's current has flowed since the row before" if jumps else "current is straight from row to row"
        said.append(
            f"rows are {spacing:.3g} s apart, so {how}; {key}between={'line' if jumps else 'step'} changes that"
        )
    return Series(
        file=file,
        row=order.row,
        time_s=order.time_s - order.time_s[0],
        voltage_v=order.columns["voltage_v"],
        current_a=current,
        temperature_c=order.optional("temperature_c"),
        ambient_c=order.optional("ambient_c"),
        step=order.step,
        jumps=jumps,
        said=tuple(said),
    )


def _refuse_missing(table: Table, found: headings.Found, key: str) -> None:
    asks = [
        f"no column {one.name!r} [{one.unit}], the {one.meaning}; {headings.spelled(key, one.name, 'HEADING')}"
        for one in (VOLTS, AMPERES)
        if one.name not in found.headings and not any(one.meaning in told for told in found.open)
    ]
    asks = [*found.open, *asks]
    if asks:
        raise UserError(f"{table.path}: {'; and '.join(asks)}; its columns are {', '.join(table.columns)}")


def _times(table: Table, own: OwnFile, measured: Measured, key: str) -> tuple[Array, bool, list[str]]:
    """Return the time of every row [s], from a column or from the interval that is given, and whether it has dates.

    NaN where a row has none: by what is written there, or a last row that was cut off.
    """
    named = own.columns.get("time") or own.columns.get("time_s") or own.columns.get("date")
    exact = next((name for name in ("time_s", "time") if name in table.columns), None)
    likely = next((name for word in _TIMES for name in table.columns if plain(name) == word), None)
    heading = named or exact or likely
    if measured.sample_interval_s is not None and named is None:
        told = f"rows {measured.sample_interval_s:g} s apart, as {key}sample_interval_s says"
        told = f"no column of time: {told}" if heading is None else f"{told}; column {heading!r} is not used"
        return measured.sample_interval_s * np.arange(len(table.places), dtype=np.float64), False, [told]
    if heading is None:
        above = " ".join(table.preamble.lines)
        rate = re.search(r"(\d+(?:\.\d+)?)\s*Hz", above)
        guess = f"{1.0 / float(rate[1]):g}" if rate and float(rate[1]) else "1"
        hint = f" (above the table stands {above.strip(', ')!r})" if rate else ""
        raise UserError(
            f"{table.path}: no column of time{hint}; where its rows are equally far apart, "
            f"{key}sample_interval_s={guess}, else {headings.spelled(key, 'time', 'HEADING')}; its columns are "
            f"{', '.join(table.columns)}"
        )
    if heading not in table.columns:
        clock_of(table, own, None, key)  # says what is nearest
    cells = table.columns[heading]
    last = len(cells) - 1 if len(cells) and isinstance(cells[-1], Torn) else -1
    gone = [place == last or str(cell).strip() in own.missing or cell is None for place, cell in enumerate(cells)]
    whole = [place for place, left in enumerate(gone) if not left]
    said = [f"{table.named(last)}, the last, is cut off: left out"] if last >= 0 else []
    if sum(gone) > (last >= 0):
        said.append(f"{sum(gone) - (last >= 0)} rows without a time left out")
    time_s, dated, more = _clock(table, own, heading, whole, named is None and exact is None, key)
    found = np.full(len(cells), np.nan)
    found[whole] = time_s
    return found, dated, [*more, *said]


def _clock(
    table: Table, own: OwnFile, heading: str, rows: list[int], likely: bool, key: str
) -> tuple[Array, bool, list[str]]:
    """Return the time of some rows [s], whether it has dates, and what was found."""
    passed = [_elapsed_s(table.columns[heading][row]) for row in rows]
    elapsed = [one for one in passed if one is not None]
    date = next((name for name in table.columns if plain(name) in _DATES and name != heading), None)
    beside = date is not None and own.columns.get("date") is None and len(elapsed) == len(rows)
    if len(elapsed) == len(rows) and (max(elapsed, default=0.0) >= _DAY_S or not beside):
        return np.array(elapsed), False, [f"time: column {heading!r}, time that has passed"]
    few = table._replace(
        columns={name: [cells[row] for row in rows] for name, cells in table.columns.items()},
        places=[table.places[row] for row in rows],
    )
    if likely or beside:
        seconds = {"time_s": "s"} if plain(heading).endswith(("second", "seconds")) else {}
        named = {"time": heading} | ({"date": str(date)} if beside else {})
        own = own.model_copy(update={"columns": {**own.columns, **named}, "units": {**seconds, **own.units}})
    clock = clock_of(few, own, None, key)
    unread = np.flatnonzero(np.isnan(clock.wall_s))
    if len(unread):
        row = int(unread[0])
        cell = few.columns[heading][row]
        allowed = clock.allowed if clock.dated else "a number of seconds, as in the other rows"
        hint = "" if isinstance(cell, Torn) else f"; '{key}missing=[\"{cell}\"]' leaves such rows out"
        raise few.refused(row, clock.column, clock.told(row), allowed + hint)
    offset = np.where(np.isnan(clock.offset_s), 0.0, clock.offset_s)
    kind = "dates" if clock.dated else "seconds"
    return clock.wall_s - offset, clock.dated, [f"time: column {clock.column!r}, {kind}", *clock.said]


def _elapsed_s(cell: object) -> float | None:
    """Return the time that has passed by a cell as `73:05:10.5`, `3d 01:05:10`; none where it is written otherwise."""
    found = _PASSED.fullmatch(cell.strip()) if isinstance(cell, str) else None
    if found is None:
        return None
    days, hours, minutes, seconds = (float((one or "0").replace(",", ".")) for one in found.groups())
    return _DAY_S * days + 3600.0 * hours + 60.0 * minutes + seconds


def _column_of(table: Table, own: OwnFile, name: str, words: tuple[str, ...]) -> str | None:
    named = own.columns.get(name)
    if named is not None and named not in table.columns:
        raise UserError(f"{table.path}: no column {named!r}, which measured.columns.{name} names")
    return named or next((one for word in words for one in table.columns if plain(one) == word), None)


def _step_numbers(table: Table, heading: str | None) -> NDArray[np.int64]:
    if heading is None:
        return np.full(len(table.places), -1, dtype=np.int64)
    cells = [number(cell, table.decimal) for cell in table.columns[heading]]
    return np.array([-1 if cell is None else int(cell) for cell in cells], dtype=np.int64)


def _signed(
    order: Ordered, measured: Measured, modes: str | None, table: Table, key: str
) -> tuple[Array, tuple[str, ...]]:
    """Return the current positive when charging, and how its sign was found."""
    current = order.columns["current_a"]
    if measured.current == "by_mode" or (measured.current == "auto" and modes is not None):
        told = _by_mode(order, current, modes, table, key, measured.current == "by_mode")
        if told is not None:
            return told
    if measured.current != "auto":
        factor = -1.0 if measured.current == "positive_discharging" else 1.0
        return factor * current, (f"current: {measured.current}, as {key}current says",)
    share, count = _answer(order.time_s, order.columns["voltage_v"], current)
    if count and (share >= 0.8 or share <= 0.2):
        charging = share >= 0.8
        agree = share if charging else 1.0 - share
        word = "positive_charging" if charging else "positive_discharging"
        how = "rises" if charging else "falls"
        return (1.0 if charging else -1.0) * current, (
            f"current: {word}, judged: the voltage {how} where the current rises, by {100 * agree:.0f} % of "
            f"{count} changes, weighed by their size",
        )
    raise UserError(
        f"{order.path}: whether a positive current charges or discharges cannot be seen in the voltage; say it, "
        f"{key}current=positive_charging or {key}current=positive_discharging; or by_mode, where a column says charge, "
        "discharge or rest"
    )


def _by_mode(
    order: Ordered, current: Array, heading: str | None, table: Table, key: str, asked: bool
) -> tuple[Array, tuple[str, ...]] | None:
    """Return the current with the sign that a column of words gives it; none where the current has one of its own."""
    if heading is None:
        raise UserError(
            f"{table.path}: {key}current is by_mode, and no column says charge, discharge or rest; "
            f"{headings.spelled(key, 'mode', 'HEADING')}; its columns are {', '.join(table.columns)}"
        )
    words = [str(table.columns[heading][at]).strip().lower() for at in order.source.tolist()]
    sign = np.array([_sign_of(word) for word in words])
    moved = np.abs(current) > 1e-3 * (np.max(np.abs(current)) + 1e-30)
    unknown = np.isnan(sign) & moved
    if unknown.any():
        if not asked:
            return None
        at = int(np.flatnonzero(unknown)[0])
        raise UserError(
            f"{table.path}: {table.place} {order.row[at]}, column {heading}: {words[at]!r}; allowed is a word that "
            "begins as charge, discharge or rest"
        )
    signed = (current < 0.0).any() and (current[moved] > 0.0).any()
    if signed and not asked:
        return None
    made = np.where(np.isnan(sign), 0.0, sign) * np.abs(current)
    return made, (
        f"current: by_mode, its sign is that of column {heading!r}" + ("" if asked else ", it has none itself"),
    )


def _sign_of(word: str) -> float:
    if word.startswith(_DISCHARGE):
        return -1.0
    if word.startswith(_CHARGE):
        return 1.0
    return 0.0 if word.startswith(_REST) else np.nan


def _answer(time_s: Array, volts: Array, current: Array) -> tuple[float, int]:
    """Return the share of changes of current to which the voltage answers in the same direction, and their number."""
    lengths = np.diff(time_s)
    usual = float(np.median(lengths[lengths > 0.0])) if (lengths > 0.0).any() else 1.0
    # Of a single wild current the largest changes would be those to it and back.
    span = float(np.ptp(np.percentile(current, [0.2, 99.8])))
    large = np.flatnonzero((np.abs(np.diff(current)) > 0.1 * (span + 1e-30)) & (lengths <= 20.0 * usual))
    if not len(large) or span == 0.0:
        return 0.5, 0
    # Some loggers write the new current beside the old voltage: the answer is looked for a row later.
    later = np.minimum(np.searchsorted(time_s, time_s[large + 1] + 0.5 * usual), len(time_s) - 1)
    later = np.where(np.abs(current[later] - current[large + 1]) < 0.2 * span, later, large + 1)
    weight = (volts[later] - volts[large]) * np.sign(current[large + 1] - current[large])
    total = float(np.abs(weight).sum())
    return (float(weight[weight > 0].sum()) / total if total else 0.5), len(large)


def _gaps(order: Ordered, current: Array) -> list[str]:
    lengths = np.diff(order.time_s)
    usual = float(np.median(lengths))
    flowing = np.maximum(np.abs(current[1:]), np.abs(current[:-1])) > 0.02 * np.max(np.abs(current))
    gaps = np.flatnonzero((lengths > max(_GAP_S, 20.0 * usual)) & flowing)
    return [
        f"nothing for {lengths[at]:.0f} s between {order.place} {order.row[at]} and {order.row[at + 1]} while current "
        "flowed: it is taken as going on as in the next row"
        for at in gaps[:5]
    ] + ([f"{len(gaps) - 5} more such gaps"] if len(gaps) > 5 else [])
