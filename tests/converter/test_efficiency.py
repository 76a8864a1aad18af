"""Converters of parts: lossless ones, energy, the boundary of continuous conduction, and the chain."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

from pipeline.converter.efficiency import battery_power, boost_efficiency, buck_efficiency, loads
from pipeline.converter.records import Load, PowerChain

CONF = Path(__file__).parents[2] / "conf"
POWER = np.geomspace(0.1, 65.0, 60)
VOLTS = {"boost": (17.4, 24.0), "buck": (24.0, 13.5)}
RESISTANCES = ("on_resistance_ohm", "rectifier_resistance_ohm", "inductor_resistance_ohm", "rectifier_voltage_v")
LOSSES = ("transition_time_s", "node_capacitance_f", "gate_charge_c", "core_loss_w", "control_power_w")


def read(path: str) -> dict:
    found = yaml.safe_load((CONF / path).read_text())
    for part in (found, *found.values()):
        if isinstance(part, dict):
            part.pop("sources", None)
    found.pop("defaults", None)
    return found


@pytest.fixture(scope="module")
def chain() -> PowerChain:
    parts = read("converter_parts/usual.yaml")
    return PowerChain(**read("converter/parts.yaml"), **parts)


def changed(chain: PowerChain, which: str, of: str, **values: float | str) -> PowerChain:
    part = getattr(chain, of)
    return chain.model_copy(
        update={of: part.model_copy(update={which: getattr(part, which).model_copy(update=values)})}
    )


def lossless(chain: PowerChain, which: str) -> PowerChain:
    without = changed(chain, which, "switched", **dict.fromkeys(RESISTANCES, 0.0), capacitor_resistance_ohm=1e-12)
    return changed(without, which, "losses", **dict.fromkeys(LOSSES, 0.0))


@pytest.mark.parametrize("which", VOLTS)
def test_without_losses_it_is_ideal(chain, which):
    source, sink = VOLTS[which]
    found = loads(lossless(chain, which), which, source, sink, POWER)
    np.testing.assert_allclose(found.efficiency(), 1.0, rtol=1e-9)
    ratio = 1.0 - source / sink if which == "boost" else sink / source
    assert found.columns["duty"][-1] == pytest.approx(ratio, rel=1e-9)
    assert found.columns["duty"][0] < 0.5 * ratio  # discontinuous


@pytest.mark.parametrize("which", VOLTS)
def test_the_two_laws_meet_at_the_boundary(chain, which):
    """Where the least current comes to zero, duty, ripple and losses go on without a jump."""
    power = np.linspace(1.0, 12.0, 20001)
    found = loads(chain, which, *VOLTS[which], power)
    for name in ("duty", "ripple_a", "switch_w", "winding_w", "switching_w"):
        assert np.max(np.abs(np.diff(found.columns[name]))) < 3e-3 * np.ptp(found.columns[name]) + 1e-5, name
    # A little off: with discontinuous current the resistances are left out of the volt-seconds.
    assert np.all(np.diff(found.columns["duty"]) > -2e-3)


@pytest.mark.parametrize("which", VOLTS)
@pytest.mark.parametrize("loss", [*RESISTANCES, *LOSSES, "capacitor_resistance_ohm"])
def test_every_loss_costs(chain, which, loss):
    of = "losses" if loss in LOSSES else "switched"
    part = getattr(getattr(chain, of), which)
    worse = changed(chain, which, of, **{loss: 2.0 * getattr(part, loss)})
    before, after = (loads(one, which, *VOLTS[which], POWER).efficiency() for one in (chain, worse))
    assert np.all(after <= before + 1e-12)
    assert after[-1] < before[-1]


def test_efficiency_by_output_is_that_by_input(chain):
    drawn = np.linspace(0.5, 60.0, 30)
    by_input = buck_efficiency(chain, 13.5, drawn)
    by_output = buck_efficiency(chain, 13.5, drawn * by_input, of_output=True)
    np.testing.assert_allclose(by_output, by_input, rtol=1e-9)


def test_power_that_does_not_cover_the_losses_is_lost(chain):
    found = loads(chain, "buck", 24.0, 13.5, np.array([0.0, 0.01, 0.05]))
    np.testing.assert_allclose(found.losses_w(), found.power_w, rtol=1e-9, atol=1e-15)
    np.testing.assert_allclose(found.efficiency(), 0.0, atol=1e-15)


def test_a_fixed_efficiency_is_the_same_at_every_load():
    fixed = PowerChain(**read("converter/fixed_efficiency.yaml"))
    np.testing.assert_array_equal(boost_efficiency(fixed, 17.4, POWER), 0.95)
    np.testing.assert_array_equal(buck_efficiency(fixed, 13.5, POWER, of_output=True), 0.92)


def test_a_synchronous_rectifier_has_no_forward_voltage_and_stays_continuous(chain):
    both = changed(chain, "boost", "switched", rectifier="synchronous")
    diode, synchronous = (loads(one, "boost", 17.4, 24.0, POWER) for one in (chain, both))
    assert synchronous.efficiency()[-1] > diode.efficiency()[-1]
    assert synchronous.columns["ripple_a"][0] > 5 * diode.columns["ripple_a"][0]


def test_the_chain_takes_the_efficiency_of_its_load(chain):
    panel, load = np.array([5.0, 30.0, 65.25]), Load(title="none", power_w=0.0)
    found = battery_power(np.arange(3), np.full(3, 1e3), np.full(3, 25.0), panel, chain, load, np.full(3, 17.4))
    tracked = 0.99 * panel
    np.testing.assert_allclose(found["boost_efficiency"], boost_efficiency(chain, 17.4, tracked))
    np.testing.assert_allclose(
        found["battery_power_w"],
        tracked * found["boost_efficiency"] * buck_efficiency(chain, 13.5, found["bus_power_w"]),
    )
    assert len(set(found["buck_efficiency"])) == 3
