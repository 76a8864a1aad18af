"""Whether a measurement can be one of the battery of the start card, and what it starts from."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.records import Battery, resting_voltage_v
from pipeline.errors import UserError
from pipeline.experiments.own_battery.reading import Series, measured_series
from pipeline.experiments.own_battery.records import Fit, Measured
from pipeline.experiments.own_battery.segments import PULSE, REST, held_out, segments

Array = NDArray[np.float64]
_GRID = np.linspace(0.0, 1.0, 2001)
_WIDE = 0.35
_MOST_C_RATE = 50.0
_ROOM_C = 25.0


def check_series(measured: Measured, battery: Battery) -> None:
    """Refuse files that cannot be read, or that are of another battery than the start card's.

    Raises
    ------
    UserError : voltages or currents far from those of the card, with what may be meant.
    """
    low, high = (resting_voltage_v(battery, soc, _ROOM_C) for soc in (0.02, 0.98))
    for series in measured_series(measured):
        middle = float(np.median(series.voltage_v))
        if not (1.0 - _WIDE) * low <= middle <= (1.0 + _WIDE) * high:
            ratio = middle / (0.5 * (low + high))
            unit = "; is it in mV? 'measured.units={voltage_v: mV}'" if 500.0 < ratio < 2000.0 else ""
            cells = max(1, round(ratio * battery.cells_in_series))
            other = f"; or {cells} cells of this kind, battery.cells_in_series={cells}" if 0.1 < ratio < 1000.0 else ""
            raise UserError(
                f"{series.file}: the voltage is {middle:.4g} V in the middle, and battery {battery.name} rests between "
                f"{low:.4g} and {high:.4g} V; start from a card of its kind, battery=NAME{other}{unit}"
            )
        largest = float(np.max(np.abs(series.current_a)))
        if largest == 0.0:
            raise UserError(
                f"{series.file}: no current flows in any row, so nothing but the voltage at rest can be told"
            )
        if largest > _MOST_C_RATE * battery.capacity_in_use_ah:
            raise UserError(
                f"{series.file}: a current of {largest:.4g} A into {battery.capacity_in_use_ah:.4g} Ah; is it in mA? "
                "'measured.units={current_a: mA}'; or another capacity, +battery.scaled_to_capacity_ah=VALUE"
            )


def check_held_out(measured: Measured, battery: Battery, chosen: Fit) -> None:
    """Refuse a hold-out that holds nothing, or everything.

    Raises
    ------
    UserError : with what lies nearest to the levels that were asked for.
    """
    wanted = chosen.held_out
    if not (wanted.around_soc or wanted.windows_s):
        return
    series = measured_series(measured)
    levels: list[float] = []
    rows = out = 0
    for place, one in enumerate(series):
        soc = chosen.initial_soc[place] if chosen.initial_soc else soc_at_start(one, battery)
        found = segments(one, soc, battery.capacity_in_use_ah)
        levels += [part.soc for part in found if part.kind in (PULSE, REST)]
        rows += len(one.time_s)
        out += int(held_out(one, found, wanted, place + 1).sum())
    if out == 0:
        near = [min(levels, key=lambda level: abs(level - soc)) for soc in wanted.around_soc] if levels else []
        told = f"; the nearest begin at {', '.join(f'{level:.3f}' for level in near)}" if near else ""
        raise UserError(
            f"own_battery.held_out: no pulse and no rest lies there{told}; own_battery.initial_soc counts too"
        )
    if out == rows:
        raise UserError("own_battery.held_out: every row is held out; leave some for the fit")


def soc_at_start(series: Series, battery: Battery) -> float:
    """Return the state of charge at which the card rests at the first voltage of a measurement [1]."""
    temperature = float(series.temperature_c[0]) if not np.isnan(series.temperature_c[0]) else _ROOM_C
    rests = np.array([resting_voltage_v(battery, float(soc), temperature) for soc in _GRID[1:-1]])
    return float(_GRID[1:-1][int(np.argmin(np.abs(rests - series.voltage_v[0])))])


def ambient_of(series: Series, measured: Measured) -> tuple[float, str]:
    """Return the temperature of the surroundings for a file without it [degC], and where it is from."""
    if not np.isnan(series.ambient_c).all():
        return float(np.nanmean(series.ambient_c)), "surroundings: as measured, row by row"
    if measured.ambient_c is not None:
        return measured.ambient_c, f"surroundings: {measured.ambient_c:g} degC, as measured.ambient_c says"
    known = series.temperature_c[~np.isnan(series.temperature_c)]
    if len(known):
        first = float(known[0])
        return (
            first,
            f"surroundings: taken at {first:.1f} degC, the battery's first temperature; measured.ambient_c says it",
        )
    return _ROOM_C, f"surroundings: no temperature is measured, taken at {_ROOM_C:g} degC; measured.ambient_c says it"


def doubtful_voltage(battery: Battery, chosen: Fit) -> str | None:
    """Return that the voltage of the charges that follow is none for the start card's cells; none where it may be."""
    cells = battery.cells
    half, full = (resting_voltage_v(battery, soc, _ROOM_C) / cells for soc in (0.5, 0.98))
    # Cells with a side reaction are charged by a tenth more than they rest at, others hardly.
    usual = full * (1.12 if battery.side_reaction is not None else 1.012)
    if half < chosen.charge_voltage_v_cell <= 1.25 * full:
        return None
    return (
        f"own_battery.charge_voltage_v_cell: {chosen.charge_voltage_v_cell:g} V a cell is no charging voltage of "
        f"{battery.name}, which rests at {half:.3g} V half full and {full:.3g} V full: the charges that follow the fit "
        f"mean nothing with it; own_battery.charge_voltage_v_cell={usual:.3g}, say"
    )
