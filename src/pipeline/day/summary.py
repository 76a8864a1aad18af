"""What came of a day in single numbers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipeline.bus.switches import ENDED
from pipeline.day.charge import DayCharge
from pipeline.day.columns import Columns, Stage
from pipeline.quantity import Quantity

_JOULE_PER_WH = 3600.0


def quantities(charge: DayCharge, found: Columns, parts: Sequence[Stage]) -> list[Quantity]:
    """Return the named numbers of a day.

    Arguments
    ---------
    charge : the battery's day.
    found : the columns of DAY_TRACE.
    parts : the stages from sun to battery.
    """
    energy = {part.stage: part.energy_j for part in parts}
    whole_j = max(energy["sun"], 1.0)
    ended = [change.time_s for change in charge.changes if change.after == ENDED]
    unserved = float(np.sum((found["load_w"] - found["served_w"]) * found["interval_s"]))
    clock_s = float(found["clock_s"][0] - found["time_s"][0])
    return [
        Quantity("end_soc", charge.end_soc, "1", "state of charge at last light"),
        Quantity(
            "ended_s", ended[0] if ended else np.nan, "s", "when the mode's sheet ended the charge, since first light"
        ),
        Quantity("ended_clock_s", ended[0] + clock_s if ended else np.nan, "s", "the same since midnight"),
        Quantity("charging_s", charge.charging_s, "s", "time in charging parts of the waveforms"),
        Quantity("current_limited_s", charge.current_limited_s, "s", "of it at the full current that is asked for"),
        Quantity("voltage_limited_s", charge.voltage_limited_s, "s", "of it with the voltage held at its limit"),
        Quantity("supply_limited_s", charge.supply_limited_s, "s", "of it with the supply at its limit"),
        Quantity("charge_in_ah", charge.charge_in_ah, "Ah", "charge put in, discharge pulses not subtracted"),
        Quantity("charge_out_ah", charge.charge_out_ah, "Ah", "charge taken out by discharge pulses"),
        Quantity("peak_temperature_c", charge.peak_temperature_c, "degC", "highest battery temperature"),
        Quantity("end_temperature_c", charge.end_temperature_c, "degC", "battery temperature at last light"),
        Quantity("switchings", float(len(charge.changes) - 1), "1", "changes of state over the day"),
        *(Quantity(f"{part.stage}_wh", part.energy_j / _JOULE_PER_WH, "Wh", part.description) for part in parts),
        Quantity("unserved_wh", unserved / _JOULE_PER_WH, "Wh", "what the load asks for and does not get"),
        Quantity(
            "most_above_available_w",
            float(np.max(found["charge_w"] - found["available_w"])),
            "W",
            "most by which a mean into the battery lies above what the bus could bring: rounding, and cut periods",
        ),
        Quantity(
            "energy_balance_residual",
            float(charge.energy["energy_j"][list(charge.energy["path"]).index("residual")]) / whole_j,
            "1",
            "residual of the battery's first law, over the sun's energy",
        ),
        Quantity("steps", float(charge.steps), "1", "steps the engine took"),
    ]
