"""A whole day with a charge in it, by the default engine at the charge's own 90 Hz, against the 2 s asked for it.

From the place of the sun to the columns of the trace, as the steps of the shipped study do it one after the other: sky,
panel, tracker in closed loop, bus and load, charge, what came of it. Fit of the panel, imports and compilation come
before. Beside it the charge alone. Errors are those of the default engine against the edge driver on the same light.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from benchmarks.peers import engine as peer
from benchmarks.protocol import Figure, Row, Times, compared, interleaved, once
from pipeline.bus.flows import kept_by_bus_j
from pipeline.bus.load import drawn
from pipeline.charge.records import EngineSettings
from pipeline.charge.simulate import warm_up
from pipeline.config.compose import compose_tree
from pipeline.config.study import study_from
from pipeline.day import columns
from pipeline.day.charge import DayCharge, Surroundings, charge_over_day
from pipeline.day.sunlight import Sunlight, in_closed_loop, sunlight
from pipeline.panel.single_diode import SingleDiode, fit
from pipeline.tracker.loop import Source
from pipeline.weather.clear_sky import Sky, sky_of

PACKAGES = ("numba", "pvlib")
ASKED_S, ASKED = 2.0, Figure(1.0)
ERROR_ASKED = 1e-6
MEANS = "Ah put in, SOC at last light and highest temperature in degC against the edge driver, relative"
MODE, FREQUENCY_HZ = "cv_reflex", 90.0


@dataclass(frozen=True)
class Day:
    """A day of the study; `diode` is the fitted model of its panel."""

    study: Any
    weather: str
    diode: SingleDiode

    def light(self) -> tuple[Sky, Sunlight]:
        """Return the sky, and what the battery could have of it."""
        study = self.study
        assert study.day is not None
        assert study.panel is not None
        assert study.converter is not None
        assert study.converter.switched is not None
        assert study.day.tracker is not None
        sky = sky_of(study.day.weathers[self.weather], study.charge.ambient_c)
        load = drawn(study.day.load, sky.clock_s, sky.clock_s + sky.end_s)
        source = Source(study.panel, self.diode, study.converter.switched.boost, study.converter.bus_voltage_v)
        tracking = in_closed_loop(source, study.day.tracker)
        return sky, sunlight(sky, load, study.panel, self.diode, tracking, study.converter)

    @cached_property
    def given(self) -> tuple[Sky, Sunlight]:
        """Return the same, made once."""
        return self.light()

    def charged(self, light: Sunlight, driver: str = "auto") -> DayCharge:
        """Return the charge in some light."""
        study = self.study
        assert study.day is not None
        assert study.converter is not None
        assert study.converter.switched is not None
        conditions = study.day.conditions()
        farad = study.converter.switched.boost.capacitance_f
        kept_j = kept_by_bus_j(farad, conditions.bus_swing_share, light.could, study.converter)
        end_s = float(light.time_s[-1] + light.interval_s[-1])
        around = Surroundings(light.time_s, light.could.battery_w, light.ambient_c, end_s, kept_j)
        settings = EngineSettings.model_validate({"driver": driver})
        return charge_over_day(study.battery, study.modes[MODE], around, conditions, settings)

    def whole(self) -> object:
        """Return everything from the place of the sun to the stages of the day."""
        assert self.study.converter is not None
        sky, light = self.light()
        charge = self.charged(light)
        return columns.stages(columns.trace(charge, light, self.study.converter, sky.clock_s), charge)

    def error(self) -> tuple[float, str]:
        """Return the largest error of the default engine, and what each is."""
        light = self.given[1]
        found, expected = (self._end(self.charged(light, driver)) for driver in ("auto", "edge"))
        errors = [abs(own / other - 1.0) for own, other in zip(found, expected, strict=True)]
        return max(errors), ", ".join(f"{word} {one:.0e}" for word, one in zip(("Ah", "SOC", "T"), errors, strict=True))

    def _end(self, charge: DayCharge) -> tuple[float, float, float]:
        assert self.study.day is not None
        return charge.charge_in_ah, charge.end_soc, charge.peak_temperature_c


def rows() -> list[Row]:
    """Return the rows of every day of the study, whole and its charge alone."""
    study = study_from(compose_tree([f"modes.{MODE}.frequency_hz={FREQUENCY_HZ:g}"]))
    assert study.panel is not None
    assert study.day is not None
    fit_s, diode = once(lambda: fit(study.panel))  # type: ignore[arg-type]
    compile_s, _ = once(warm_up)
    return [
        row for name in study.day.weathers for row in _rows(Day(study, name, diode), {peer.TITLE: compile_s + fit_s})
    ]


def _rows(day: Day, before_s: dict[str, float]) -> list[Row]:
    light = day.given[1]
    first_s, _ = once(day.whole)
    walls = interleaved({"whole": day.whole, "charge": lambda: day.charged(light)})
    asked = Times([ASKED_S] * len(walls["whole"].wall_s), [ASKED_S] * len(walls["whole"].wall_s))
    found, told = day.error()
    name = f"day, {day.weather}: Reflex at {FREQUENCY_HZ:g} Hz, {light.interval_s.sum() / 3600.0:.1f} h"
    return [
        compared(
            name, f"{ASKED_S:g} s", walls["whole"], asked, ASKED,
            ours_error=found, peer_error=0.0, error_means=MEANS, error_asked=ERROR_ASKED, note=told,
            before_s=before_s | {"first day": first_s},
        ),
        compared(f"{name}, charge alone", f"{ASKED_S:g} s", walls["charge"], asked),
    ]  # fmt: skip
