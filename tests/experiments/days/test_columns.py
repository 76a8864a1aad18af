"""The bus and the battery together: every watt of a day has its place."""

import numpy as np
import pytest

from pipeline.bus.flows import ENDED, available
from pipeline.day.charge import Surroundings
from pipeline.day.sunlight import Sunlight
from pipeline.experiments.days import summary
from pipeline.experiments.days.numbers import DAY_NUMBERS
from tests.bus.test_bus import CHAIN
from tests.day.samples import day

DAY_S = 28800.0


# The second sun changes between the samples.
@pytest.fixture(scope="module", params=[("cc_cv", 300.0), ("cv_reflex", 300.0), ("cc_cv", 45.0)])
def found(request):
    """A bright morning with a cloud in it; full before noon."""
    mode, interval_s = request.param
    count = round(DAY_S / interval_s)
    time_s, rows = interval_s * np.arange(count), np.ones(count)
    panel_w = 60.0 * np.sin(np.pi * time_s / DAY_S) * np.where(time_s // 300.0 % 7 == 3, 0.3, 1.0)
    could = available(panel_w, 0.98 * panel_w, 5.0, CHAIN)
    light = Sunlight(time_s, interval_s * rows, 10 * panel_w, 20 * rows, 30 * rows, 1.1 * panel_w, 17 * rows, could)
    charge = day(mode, Surroundings(time_s, could.battery_w, 20.0 * rows, DAY_S))
    trace = summary.trace(charge, light, CHAIN, 6 * 3600.0)
    return charge, light, trace, summary.stages(trace, charge)


def test_the_bus_closes_in_every_interval(found):
    _, _, trace, _ = found
    np.testing.assert_allclose(trace["bus_w"], trace["served_w"] + trace["buck_w"], rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(trace["drawn_w"] + trace["curtailed_w"], trace["tracked_w"], rtol=1e-12, atol=1e-12)
    assert trace["curtailed_w"].min() > -1e-4
    assert (trace["charge_w"] <= trace["available_w"] + 1e-4).all()


def test_what_the_supply_limits_takes_all_there_is(found):
    """The engine's own word for it, held against the bus: nothing is curtailed while the supply is the limit."""
    _, _, trace, _ = found
    limited = (trace["supply_limited_share"] > 1.0 - 1e-9) & (trace["discharge_w"] == 0.0)
    assert np.count_nonzero(limited) > 5
    np.testing.assert_allclose(trace["charge_w"][limited], trace["available_w"][limited], rtol=1e-5)
    assert np.abs(trace["curtailed_w"][limited]).max() < 1e-3


def test_when_full_all_but_the_load_is_curtailed(found):
    charge, _, trace, _ = found
    assert charge.changes[-1].after == ENDED
    after = np.array(trace["state"]) == ENDED
    assert np.count_nonzero(after) > 10
    unused = trace["tracked_w"][after] - trace["served_w"][after] / CHAIN.boost.efficiency
    np.testing.assert_allclose(trace["curtailed_w"][after], unused, atol=1e-9)
    assert trace["charge_w"][after].max() < 1e-9


def test_the_stages_add_up_and_agree_with_the_sun_and_the_battery(found):
    charge, light, _, parts = found
    energy = {part.stage: part.energy_j for part in parts}
    assert energy["sun"] == pytest.approx(float(np.sum(light.reference_w * light.interval_s)), rel=1e-12)
    assert sum(part.energy_j for part in parts[1:]) == pytest.approx(energy["sun"], rel=1e-12)
    of_path = dict(zip(charge.energy["path"], charge.energy["energy_j"], strict=True))
    heat = sum(
        joule
        for path, role, joule in zip(*(charge.energy[name] for name in ("path", "role", "energy_j")), strict=True)
        if role == "heat" or (role == "stored" and path != "chemical")
    )
    # Heat that warmed the battery or left it, and what pairs and gas hold: found by the first law, not by subtraction.
    assert energy["battery"] == pytest.approx(heat, abs=1e-6 * energy["sun"])
    assert energy["stored"] == of_path["chemical"]
    assert all(part.energy_j >= -1e-6 for part in parts if part.stage != "battery")


def test_the_numbers_are_those_of_the_trace(found):
    charge, _, trace, parts = found
    assert {one.name for one in summary.quantities(charge, trace, parts)} == DAY_NUMBERS.names({})
    numbers = {one.name: one.value for one in summary.quantities(charge, trace, parts)}
    assert numbers["most_above_available_w"] < 1e-4
    assert abs(numbers["energy_balance_residual"]) < 1e-9
    # Each is what the engine spent in a control, the whole is the sheet's; a period that a change cuts is not whole.
    spent = numbers["current_limited_s"] + numbers["voltage_limited_s"] + numbers["supply_limited_s"]
    assert spent == pytest.approx(numbers["charging_s"], rel=1e-6)
    assert min(numbers[f"{limit}_limited_s"] for limit in ("current", "voltage", "supply")) > 10.0
    assert numbers["ended_clock_s"] == numbers["ended_s"] + 6 * 3600
    dark = trace["load_w"] - trace["served_w"]
    assert numbers["unserved_wh"] == pytest.approx(float(np.sum(dark * trace["interval_s"])) / 3600.0)
