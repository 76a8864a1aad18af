"""Days for tests: a battery, a mode of the configuration, made-up sun."""

import numpy as np

from pipeline.bus.records import Switching
from pipeline.charge.records import EngineSettings, Mode
from pipeline.day.charge import Surroundings, charge_over_day
from pipeline.day.records import DayConditions
from tests.charge.samples import battery, load

BATTERY = battery("lead_acid_12v7ah")
CONDITIONS = DayConditions(initial_soc=0.6, switching=Switching(start_power_w=2.0, stop_power_w=1.0))
HOUR = 3600.0


def mode(name, **knobs):
    return Mode(**(load(f"modes/{name}.yaml") | knobs))


def sun(powers, interval_s=600.0, ambient_c=25.0):
    """Return surroundings with a power for each interval."""
    rows = len(powers)
    air = np.broadcast_to(np.asarray(ambient_c, dtype=float), rows).copy()
    return Surroundings(interval_s * np.arange(rows), np.array(powers, dtype=float), air, interval_s * rows)


def day(name, surroundings, cell=BATTERY, engine=None, conditions=CONDITIONS, **knobs):
    return charge_over_day(cell, mode(name, **knobs), surroundings, conditions, engine or EngineSettings())
