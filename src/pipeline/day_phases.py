"""The nodes of days in the sun: the weather of each, and each mode's charge in it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pipeline import own_series
from pipeline.bus.records import LoadProfile, MeasuredLoad
from pipeline.config.study import Study
from pipeline.converter.records import PowerChain
from pipeline.draft import Draft, plain
from pipeline.weather.records import Weather


def days(study: Study) -> Iterator[Draft]:
    """Yield the nodes of a study's days, if it has any."""
    if study.day is None or study.panel is None:
        return
    for name, weather in study.day.weathers.items():
        yield Draft(
            "weather",
            f"weather/{name}",
            name,
            {
                "weather": own_series.settings(weather, name),
                "ambient_c": study.charge.ambient_c,
                "longest_h": study.day.longest_h,
            },
            sections=(f"day.weathers.{name}",),
            shown={f"{part}.parquet": f"day/{name}/{part}.parquet" for part in ("weather", "gaps", "quantities")},
        )
        yield _daylight(study, name)
    for name in study.day.weathers:
        for mode in study.day.modes or study.run:
            yield _charge(study, name, mode)


def _daylight(study: Study, weather: str) -> Draft:
    """Return the node of what the battery could have, whatever the mode."""
    assert study.day is not None
    assert study.converter is not None
    switched = study.converter.switched
    return Draft(
        "daylight",
        f"daylight/{weather}",
        weather,
        {
            **plain(
                {
                    "panel": study.panel,
                    "converter": chain_of_hours(study.converter),
                    "boost": None if switched is None or study.day.tracker is None else switched.boost,
                    "tracker": study.day.tracker,
                }
            ),
            "load": own_series.settings(study.day.load, "load"),
            "date": _date(study.day.load, study.day.weathers[weather]),
        },
        inputs={"panel": "panel", f"weather/{weather}": f"weather/{weather}"},
        sections=("panel", "converter", "day.load", "day.tracker"),
        shown={"daylight.parquet": f"day/{weather}/daylight.parquet"},
    )


def _date(load: LoadProfile, weather: Weather) -> str | None:
    """Return the day of the weather, which only a load of somebody's own asks for."""
    date = own_series.date_of(weather) if isinstance(load, MeasuredLoad) else None
    return None if date is None else date.isoformat()


def _charge(study: Study, weather: str, mode: str) -> Draft:
    """Return the node of a mode's charge in a day."""
    assert study.day is not None
    assert study.converter is not None
    return Draft(
        "day",
        f"day/{weather}/{mode}",
        f"{weather}.{mode}",
        {
            **plain(
                {
                    "converter": chain_of_hours(study.converter),
                    "conditions": study.day.conditions(),
                    "engine": study.engine,
                }
            ),
            "bus_capacitance_f": _bus_capacitance_f(study),
            "battery": {**plain(study.battery), "title": study.battery.name},
            "mode": {**plain(study.modes[mode]), "title": mode},
        },
        inputs={"engine": "engine", f"daylight/{weather}": f"daylight/{weather}"},
        sections=("converter", "battery", "day", f"modes.{mode}"),
        shown={
            f"{part}.parquet": f"day/{weather}/{mode}.{part}.parquet"
            for part in ("trace", "switching", "stages", "quantities")
        },
    )


def _bus_capacitance_f(study: Study) -> float:
    """Return the capacitance on the bus, that of the boost converter's output; 0 where its parts are not given."""
    switched = None if study.converter is None else study.converter.switched
    return 0.0 if switched is None else switched.boost.capacitance_f


def chain_of_hours(chain: PowerChain) -> PowerChain:
    """Return the converters without the parts that the powers of hours do not depend on."""
    return chain if chain.of_parts else chain.model_copy(update={"switched": None, "losses": None})


def weather_settings(study: Study) -> dict[str, Any] | None:
    """Return the weather of the study's own charges as plain data, with the digest of its file."""
    return None if study.weather is None else own_series.settings(study.weather, study.weather.title)


def labels(study: Study) -> dict[str, Any]:
    """Return what a reader of days needs to name them; nothing where a study has none."""
    if study.day is None:
        return {}
    return {
        "title": study.day.title,
        "weathers": {name: weather.title for name, weather in study.day.weathers.items()},
        "load": study.day.load.title,
        "initial_soc": study.day.initial_soc,
        "bus_capacitance_f": _bus_capacitance_f(study),
        "bus_swing_share": study.day.bus_swing_share,
    }
