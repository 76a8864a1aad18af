from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from pipeline.converter.efficiency import battery_power, unserved_load_w
from pipeline.converter.records import Converter, Load, PowerChain, check
from pipeline.errors import UserError
from pipeline.kernel import registry, tables

CONF = Path(__file__).parents[2] / "conf"


def _read(group: str, name: str, record: type):
    settings = yaml.safe_load((CONF / group / f"{name}.yaml").read_text())
    settings.pop("sources")
    settings.pop("defaults", None)
    return record(**settings)


CHAIN = _read("converter", "fixed_efficiency", PowerChain)
MASTER_SYSTEM = _read("load", "master_system", Load)


def follow(panel_w, chain=CHAIN, load=MASTER_SYSTEM):
    panel_w = np.atleast_1d(panel_w)
    rows = len(panel_w)
    return battery_power(np.arange(rows), np.full(rows, 1000.0), np.full(rows, 25.0), panel_w, chain, load)


def test_the_defaults_by_hand(tmp_path):
    found = follow([65.25, 39.52, 20.0])
    np.testing.assert_allclose(found["bus_power_w"], np.array([65.25, 39.52, 20.0]) * 0.99 * 0.95, rtol=1e-14)
    np.testing.assert_allclose(found["battery_power_w"], [38.0578, 15.7953, 0.0], atol=5e-4)
    tables.write(registry.steps()["supply"].tables["supply"].table, found, tmp_path / "supply.parquet")


def test_full_sun_carries_the_largest_mean_equivalent_pulse_and_600_w_m2_does_not():
    needed_w = 2.33 * 14.4
    full, dim = follow([65.25, 39.52])["battery_power_w"]
    assert dim < needed_w < full


@given(st.floats(0, 500), st.floats(0, 500), st.floats(0.1, 1), st.floats(0.1, 1), st.floats(0.1, 1))
def test_energy_is_never_made(panel_w, load_w, tracker, boost, buck):
    chain = PowerChain(
        title="any",
        bus_voltage_v=24,
        tracker_efficiency=tracker,
        boost=Converter(efficiency=boost),
        buck=Converter(efficiency=buck),
    )
    found = follow(panel_w, chain, Load(title="any", power_w=load_w))
    battery, unserved = found["battery_power_w"][0], unserved_load_w(found)[0]
    assert battery >= 0
    assert battery == 0 or unserved == 0
    served = load_w - unserved
    np.testing.assert_allclose(served + battery / buck, panel_w * tracker * boost, rtol=1e-9, atol=1e-9)


def test_a_load_above_the_bus_is_reported_as_unserved():
    found = follow([10.0, 65.25])
    np.testing.assert_allclose(unserved_load_w(found), [20.0 - 10.0 * 0.99 * 0.95, 0.0], rtol=1e-12)


def test_a_supply_that_can_never_charge_is_refused():
    check(65.25, 17.4, CHAIN, MASTER_SYSTEM)
    with pytest.raises(UserError, match=r"load.power_w is 20 W, but the bus has at most about 18.8 W"):
        check(20.0, 17.4, CHAIN, MASTER_SYSTEM)
    with pytest.raises(UserError, match=r"bus_voltage_v is 24 V; a boost converter needs a bus above .* 34.8 V"):
        check(130.5, 34.8, CHAIN, MASTER_SYSTEM)


@pytest.mark.parametrize("efficiency", [0.0, 1.01, float("nan")])
def test_an_efficiency_lies_above_0_and_up_to_1(efficiency):
    with pytest.raises(ValidationError):
        Converter(efficiency=efficiency)
