"""Units of configuration keys, from the records of the shipped studies."""

from __future__ import annotations

from functools import cache
from typing import Any

import pytest
from pydantic import Field

from pipeline.config.compose import compose_tree
from pipeline.config.study import study_from
from pipeline.config.units import unit_of
from pipeline.record import Record


@cache
def study(name: str) -> Any:
    return study_from(compose_tree([f"study={name}"]))


@pytest.mark.parametrize(
    ("of", "path", "unit"),
    [
        ("solar_reflex", "panel.max_power_w", "W"),
        ("solar_reflex", "panel.gamma_pmp_percent_per_k", "%/K"),
        ("solar_reflex", "panel.cells_in_series", "1"),
        ("solar_reflex", "converter.switched.buck.inductance_h", "H"),
        ("solar_reflex", "day.longest_h", "h"),
        ("solar_reflex", "day.load.hours.0.from_h", "h"),
        ("solar_reflex", "tracking.start_w_m2", "W/m2"),
        ("solar_reflex", "tracking.skies.clear.air.wind_m_s", "m/s"),
        ("solar_reflex", "battery.capacity_ah", "Ah"),
        ("solar_reflex", "battery.open_circuit_voltage_v.polynomial.0", "V"),
        ("solar_reflex", "search.variables.frequency_hz.low", "Hz"),
        ("solar_reflex", "modes.cv_reflex.charge_share", "1"),
        ("solar_reflex", "modes.cv_reflex.charge_a", "A"),
        ("solar_reflex", "modes.cv_reflex.voltage_v", "V"),
        ("solar_reflex", "modes.cv_reflex.frequency_hz", "Hz"),
        ("solar_reflex", "modes.cv_reflex.phases.bulk.until.elapsed_s", "s"),
        ("solar_reflex", "modes.cv_reflex.stop.temperature_c", "degC"),
        ("nicd_grnn", "modes.constant_4c.current_c_rate", "C-rate"),
        ("nicd_grnn", "modes.plain_rule.trip_rate_k_s", "K/s"),
        ("nicd_grnn", "modes.constant_4c.stop.temperature_rate_k_s", "K/s"),
        ("lfp_cuckoo", "modes.staged_printed.phases.stages.staged.currents_a", "A"),
        ("lfp_cuckoo", "battery.series_resistance_ohm.scale", "1"),
    ],
)
def test_a_unit_is_the_one_that_the_field_declares(of: str, path: str, unit: str) -> None:
    assert unit_of(study(of), path) == unit


class _Inner(Record):
    bare: float = Field(description="a number without a unit of its own")
    own: float = Field(description="a number with one [K]")
    low: float = Field(description="an end [unit of the variable]")


class _Outer(Record):
    inner: _Inner = Field(description="numbers in ohm [ohm]")
    variables: dict[str, _Inner]


def test_the_innermost_unit_decides_and_a_name_that_users_choose_ends_in_it() -> None:
    inner = _Inner(bare=1, own=2, low=3)
    root = _Outer(inner=inner, variables={"gap_v": inner, "rate_k_s": inner, "plain": inner})
    paths = ("inner.bare", "inner.own", "variables.gap_v.low", "variables.rate_k_s.low", "variables.plain.low")
    assert [unit_of(root, path) for path in paths] == ["ohm", "K", "V", "K/s", "1"]


def test_what_does_not_exist_has_no_unit() -> None:
    assert unit_of(study("solar_reflex"), "nothing.at_all_v") == "1"
