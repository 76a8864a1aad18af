"""Does a mode fit the battery and the conditions? What needs several records is checked here, before anything runs."""

from __future__ import annotations

from pipeline.cell.records import Battery
from pipeline.charge.records import ChargeSettings, Mode


def check(battery: Battery, mode: Mode, settings: ChargeSettings) -> None:
    """Raise `UserError` where a mode cannot be run as it stands; a knob that is still a reference is left out."""
