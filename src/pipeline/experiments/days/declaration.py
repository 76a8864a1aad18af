"""Days in the sun: steps, nodes, checks and what others may read of them."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from functools import lru_cache
from typing import Any

from pydantic import Field

from pipeline.bus.records import LoadProfile, MeasuredLoad, ProfileLoad
from pipeline.charge import checks
from pipeline.charge.effort import effort, longest_s
from pipeline.charge.records import ChargeSettings
from pipeline.config.compose import options
from pipeline.config.many import Unrefused
from pipeline.day.records import Day, DayConditions
from pipeline.errors import UserError, best_matches
from pipeline.experiments.days.numbers import DAY_NUMBERS, WEATHER_NUMBERS
from pipeline.files import load as loads
from pipeline.files.content import settings
from pipeline.files.load import check_load, check_weather
from pipeline.files.weather import date_of, told
from pipeline.kernel.draft import untitled
from pipeline.kernel.experiment import FOUND, Effort, Experiment, Label, Node, Step
from pipeline.kernel.footprint import Footprint
from pipeline.kernel.tables import CHAOTIC, NOTES, NUMBERS, Column, Table, TableFile, numbers
from pipeline.record import Record
from pipeline.weather.records import Weather

WEATHER = Table(
    "weather",
    "The weather of a day, constant from each row's time to the next",
    (
        Column("time_s", "s", "start of the interval, since first light"),
        Column("clock_s", "s", "the same in local time, since midnight of the first day"),
        Column("interval_s", "s", "length of the interval"),
        Column("irradiance_w_m2", "W/m2", "irradiance on the panel"),
        Column("ambient_c", "degC", "temperature of the air"),
        Column("cell_temperature_c", "degC", "temperature of the panel's cells"),
    ),
)

WEATHER_GAPS = Table(
    "weather_gaps",
    "Gaps in the file of a measured weather, and what stands in for them; no row where there are none",
    (
        Column("clock_s", "s", "start of the gap in local time, since midnight"),
        Column("length_s", "s", "length of the gap"),
        Column("filled", "", "interpolated between the rows beside it, or dark", "text"),
    ),
)

DAYLIGHT = Table(
    "daylight",
    "What the battery could have over a day if it took everything, constant from each row's time to the next",
    (
        *WEATHER.columns,
        Column("reference_w", "W", "what the panel would give at its efficiency of standard conditions"),
        Column("panel_w", "W", "the panel's maximum power"),
        Column("panel_voltage_v", "V", "the panel's voltage at maximum power"),
        Column("tracked_w", "W", "what the tracker could draw of it"),
        Column("bus_w", "W", "what the boost converter could bring to the bus"),
        Column("load_w", "W", "what the load asks for"),
        Column("served_w", "W", "what the bus gives it"),
        Column("battery_w", "W", "what the buck converter could bring to the battery's terminals"),
    ),
)

_STATE = "off, mode_1, mode_2 or ended"

DAY_TRACE = Table(
    "day_trace",
    "A day, a row per sampling interval, and one where the switches change: means over the interval that ends there",
    (
        Column("time_s", "s", "end of the interval, since first light"),
        Column("clock_s", "s", "the same in local time, since midnight of the first day"),
        Column("interval_s", "s", "length of the interval"),
        Column("state", "", f"state of the switches: {_STATE}", "text"),
        Column("irradiance_w_m2", "W/m2", "irradiance on the panel"),
        Column("cell_temperature_c", "degC", "temperature of the panel's cells"),
        Column("ambient_c", "degC", "temperature of the air"),
        Column("reference_w", "W", "what the panel would give at its efficiency of standard conditions"),
        Column("panel_w", "W", "the panel's maximum power"),
        Column("tracked_w", "W", "what the tracker could draw of it"),
        Column("drawn_w", "W", "what is drawn"),
        Column("curtailed_w", "W", "what the tracker could draw and nothing has a use for"),
        Column("bus_w", "W", "power onto the bus"),
        Column("load_w", "W", "what the load asks for"),
        Column("served_w", "W", "what the bus gives it"),
        Column("buck_w", "W", "power out of the bus into the buck converter"),
        Column("available_w", "W", "what the buck converter could bring to the battery's terminals"),
        Column("charge_w", "W", "power into the battery while it is charged"),
        Column("discharge_w", "W", "power out of the battery into the discharge resistor"),
        Column("current_a", "A", "current into the battery"),
        Column("voltage_v", "V", "terminal voltage"),
        Column("soc", "1", "state of charge at the end of the interval"),
        Column("temperature_c", "degC", "battery temperature at the end of the interval"),
        Column("supply_limited_share", "1", "share of the interval with the supply at its limit"),
        Column("voltage_limited_share", "1", "share of the interval with the voltage held at its limit"),
    ),
)

DAY_SWITCHING = Table(
    "day_switching",
    "Every change of the switches: when, why, and how they stand from then on",
    (
        Column("time_s", "s", "time of the change, since first light"),
        Column("clock_s", "s", "the same in local time, since midnight of the first day"),
        Column("before", "", f"state before: {_STATE}", "text"),
        Column("after", "", f"state from then on: {_STATE}", "text"),
        Column("reason", "", "what changed it", "text"),
        Column("s2_share", "1", "share of the time for which switch 2 is closed"),
        Column("s3_share", "1", "share of the time for which switch 3 is closed"),
        Column("s4_share", "1", "share of the time for which switch 4 is closed"),
        Column("pulses_hz", "Hz", "how often switches 3 and 4 work; 0 without pulses"),
    ),
)

DAY_STAGES = Table(
    "day_stages",
    "Where the sun's energy goes on its way to the battery: parts of the first row, which they add up to",
    (
        Column("stage", "", "where", "text"),
        Column("role", "", "input, loss, use, unused or stored", "text"),
        Column("energy_j", "J", "energy of the day"),
        Column("description", "", "what it is", "text"),
    ),
)

DAY_MISSED = Table(
    "day_missed",
    "What the mode's sheet asked for and the day did not bring; no row where there is nothing to say",
    (Column("missed", "", "goals not reached, phases that never ran or were over as they began", "text"),),
)

SKY = {
    "weather": TableFile("weather.parquet", WEATHER, time="time_s"),
    "gaps": TableFile("gaps.parquet", WEATHER_GAPS),
    **NOTES,
    **NUMBERS,
}
"""What the step `weather` writes."""

LIGHT = {
    "daylight": TableFile("daylight.parquet", DAYLIGHT, time="time_s"),
    **NOTES,
}
"""What the step `daylight` writes."""

DAY = {
    "trace": TableFile("trace.parquet", DAY_TRACE, time="time_s"),
    "switching": TableFile("switching.parquet", DAY_SWITCHING),
    "stages": TableFile("stages.parquet", DAY_STAGES),
    "missed": TableFile("missed.parquet", DAY_MISSED),
    # A rounding error, and a count that follows from where steps of a bounded error end.
    **numbers({"energy_balance_residual": CHAOTIC, "most_above_available_w": CHAOTIC, "steps": 0.05}),
}
"""What the step `day` writes."""


class DaysPart(Record):
    """Days in the sun."""

    day: Day | None = Field(default=None, description="days in the sun, held against each other")


def _weather_settings(config: Any, weather: str) -> dict[str, Any]:
    return {
        "weather": settings(config.day.weathers[weather], weather),
        "ambient_c": config.charge.ambient_c,
        "longest_h": config.day.longest_h,
    }


def _daylight_settings(config: Any, weather: str) -> dict[str, Any]:
    """Return what decides what the battery could have, whatever the mode."""
    switched, tracker = config.converter.switched, config.day.tracker
    return {
        "panel": config.panel,
        "converter": config.converter.averaged(),
        "boost": None if switched is None or tracker is None else switched.boost,
        "tracker": tracker,
        "load": settings(config.day.load, "load"),
        "date": _date(config.day.load, config.day.weathers[weather]),
    }


def _date(load: LoadProfile, weather: Weather) -> str | None:
    """Return the day of the weather, which only a load of somebody's own asks for."""
    date = date_of(weather) if isinstance(load, MeasuredLoad | ProfileLoad) else None
    return None if date is None else date.isoformat()


def _day_settings(config: Any, weather: str, mode: str) -> dict[str, Any]:
    return {
        "converter": config.converter.averaged(),
        "conditions": config.day.conditions(),
        "engine": config.engine,
        "bus_capacitance_f": _bus_capacitance_f(config),
        # Titles are for readers, and changing one must compute nothing.
        "battery": untitled(config.battery, config.battery.name),
        "mode": untitled(config.modes[mode], mode),
    }


def _bus_capacitance_f(config: Any) -> float:
    """Return the capacitance on the bus, that of the boost converter's output; 0 where its parts are not given."""
    switched = None if config.converter is None else config.converter.switched
    return 0.0 if switched is None else float(switched.boost.capacitance_f)


def _day_effort(config: Any, weather: str, mode: str) -> Effort:
    length_s, conditions = 3600.0 * config.day.longest_h, config.day.conditions()
    charge = config.charge.model_copy(update={"sample_interval_s": conditions.sample_interval_s, "windows": []})
    share = length_s / max(longest_s(config.modes[mode]), 1.0)
    memory_b, time_s = effort(config.modes[mode], charge, config.engine)
    paths = ("day.sample_interval_s", "day.ambient_step_s", "day.longest_h", "engine.maximum_step_s")
    return Effort(share * memory_b, share * time_s + 1e-5 * length_s / conditions.ambient_step_s, paths)


def _sky_effort(config: Any, weather: str) -> Effort:
    # A weather of constant light has no interval, one from a file that of its rows.
    rows = 3600.0 * config.day.longest_h / (getattr(config.day.weathers[weather], "interval_s", None) or 1.0)
    paths = ("day.longest_h", f"day.weathers.{weather}")
    return Effort(1000.0 * rows, 1e-4 * rows, paths)


WEATHER_STEP = Step(
    "weather",
    rule="make_weather",
    message="Weather of a day: {chunk}",
    settings=_weather_settings,
    effort=_sky_effort,
    reads=("day.weathers.{weather}", "charge.ambient_c", "day.longest_h"),
    tables=SKY,
    quantities=WEATHER_NUMBERS,
    usual_table="quantities",
    target="day",
    chunk=(8, 32),
)
DAYLIGHT_STEP = Step(
    "daylight",
    rule="follow_daylight",
    message="Daylight, from panel to battery: {chunk}",
    settings=_daylight_settings,
    effort=_sky_effort,
    reads=("panel", "converter", "day.load", "day.tracker", "day.weathers.{weather}"),
    takes=("panel", "weather"),
    tables=LIGHT,
    target="day",
    chunk=(8, 32),
)
DAY_STEP = Step(
    "day",
    rule="charge_over_day",
    message="Day in the sun: {chunk}",
    settings=_day_settings,
    effort=Footprint(_day_effort, memory_mb=480.0, node_s=2.0),
    reads=("converter", "battery", "engine", "modes.{mode}", *(f"day.{name}" for name in DayConditions.model_fields)),
    takes=("engine", "daylight", FOUND),
    tables=DAY,
    quantities=DAY_NUMBERS,
    usual_table="quantities",
    target="day",
    chunk=(12, 24),
    needed_by_figures=True,
)


def nodes(study: Any) -> Iterator[Node]:
    """Yield the weather and the light of each day, and each mode's charge in it."""
    if not _has_days(study):
        return
    for name in study.day.weathers:
        sky, light = f"weather/{name}", f"daylight/{name}"
        which, room = {"weather": name}, f"day/{name}"
        yield Node(WEATHER_STEP, sky, name, which, shown=WEATHER_STEP.places(room))
        inputs = {"panel": "panel", sky: sky}
        yield Node(DAYLIGHT_STEP, light, name, which, inputs, shown=DAYLIGHT_STEP.places(room))
    for name in study.day.weathers:
        light = f"daylight/{name}"
        for mode in study.day.modes or study.run:
            yield Node(
                DAY_STEP,
                f"day/{name}/{mode}",
                f"{name}.{mode}",
                {"weather": name, "mode": mode},
                inputs={"engine": "engine", light: light},
                shown={one.file: f"day/{name}/{mode}.{one.file}" for one in DAY.values()},
            )


def _has_days(study: Any) -> bool:
    """Tell whether a study has days; one without a panel has none in the sun."""
    return study.day is not None and study.panel is not None


def check(study: Any) -> None:
    """Refuse files that cannot be used, modes that do not run, and a day that no mode can begin.

    Raises
    ------
    UserError : with the key path, and below it what the file says.
    """
    day = study.day
    if day is None:
        return
    if study.panel is None:
        raise UserError("day: a study without a panel has no day in the sun; leave it out with ~day")
    for name, weather in day.weathers.items():
        check_weather(f"day.weathers.{name}", weather)
    for weather in day.weathers.values():
        check_load("day.load", day.load, weather)
    for mode in day.modes:
        if mode not in study.run:
            raise UserError(f"day.modes: no mode {mode!r} among those that are run; {best_matches(mode, study.run)}")
    begins = _begins(day.initial_soc, study.charge.ambient_c)
    for mode in day.modes or study.run:
        try:
            _CHECK(study.battery, study.modes[mode], begins)
        except UserError as error:
            raise UserError(f"day.initial_soc: {day.initial_soc:g} does not go with modes.{mode}.{error}") from None


_CHECK = Unrefused(checks.check)


@lru_cache(maxsize=64)
def _begins(initial_soc: float, ambient_c: float) -> ChargeSettings:
    """Return the conditions under which a day begins; the same ones for the same numbers."""
    return ChargeSettings(initial_soc=initial_soc, ambient_c=ambient_c)


def _remarks(study: Any, kinds: Collection[str]) -> Iterator[str]:
    """Yield what the files of weathers and load were taken for."""
    for name, weather in study.day.weathers.items() if study.day is not None else ():
        yield from (f"day.weathers.{name}: {note}" for note in told(weather, f"day.weathers.{name}"))
    if study.day is not None and isinstance(study.day.load, MeasuredLoad):
        dates = dict.fromkeys(date_of(weather) for weather in study.day.weathers.values())
        notes = dict.fromkeys(note for date in dates for note in loads.told(study.day.load, date))
        yield from (f"day.load: {note}" for note in notes)


def _readable(study: Any) -> Iterable[str]:
    if not _has_days(study):
        return ()
    names = list(study.day.weathers)
    charges = [f"day/{name}/{mode}" for name in names for mode in options("modes")]
    return [f"{kind}/{name}" for kind in ("weather", "daylight") for name in names] + charges


def _titles(config: Any) -> dict[str, Any]:
    """Return what a reader of days needs to name them; nothing where a study has none."""
    if config.day is None:
        return {}
    return {
        "title": config.day.title,
        "weathers": {name: weather.title for name, weather in config.day.weathers.items()},
        "load": config.day.load.title,
        "initial_soc": config.day.initial_soc,
        "bus_capacitance_f": _bus_capacitance_f(config),
        "bus_swing_share": config.day.bus_swing_share,
    }


EXPERIMENT = Experiment(
    title="days in the sun, each mode's charge from first to last light",
    steps=(WEATHER_STEP, DAYLIGHT_STEP, DAY_STEP),
    nodes=nodes,
    part=DaysPart,
    parameters=("day",),
    checks=(check,),
    remarks=_remarks,
    inputs=_readable,
    fields=lambda study: {"weather": {}, "day": {}},
    labels={
        "day": Label(
            _titles,
            (
                *("day.title", "day.weathers", "day.load.title", "day.initial_soc", "day.bus_swing_share"),
                "converter.switched.boost.capacitance_f",
            ),
        )
    },
    tells="telling",
)
