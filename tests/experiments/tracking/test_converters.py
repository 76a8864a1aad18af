"""Converters of parts over their load, held against the switches."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.converter.efficiency import COLUMNS, loads
from pipeline.experiments.tracking.converters import against_switches, efficiency_map, quantities
from pipeline.experiments.tracking.records import CONVERTER_NUMBERS
from tests import making
from tests.converter.test_efficiency import VOLTS, chain, changed

__all__ = ["chain"]


@pytest.mark.parametrize("which", VOLTS)
def test_it_agrees_with_the_switches(chain, which):
    found = against_switches(chain, 17.4, 65.25)
    rows = [row for row, name in enumerate(found["converter"]) if name == which]
    assert len(rows) == 9
    # At a light load the current ends within the period, at a heavy one it does not.
    duties = loads(chain, which, *VOLTS[which], np.array(found["power_w"])[rows]).columns["duty"]
    assert duties[0] < 0.5 * duties[-1]
    for row in rows:
        assert found["averaged"][row] == pytest.approx(found["switched"][row], abs=5e-4)


def test_it_agrees_with_the_switches_where_losses_are_large(chain):
    heavy = changed(chain, "buck", "switched", on_resistance_ohm=0.3, rectifier_resistance_ohm=0.2)
    heavy = changed(heavy, "boost", "switched", on_resistance_ohm=0.3, inductor_resistance_ohm=0.3)
    found = against_switches(heavy, 17.4, 65.25)
    assert min(found["switched"]) < 0.92
    np.testing.assert_allclose(found["averaged"], found["switched"], atol=2e-3)


def test_the_map_is_as_declared_and_adds_up(chain, tmp_path):
    found = efficiency_map(chain, 17.4, 65.25)
    check = against_switches(chain, 17.4, 65.25)
    output = making.output("converters", tmp_path)
    for name, columns in (("efficiency", found), ("check", check)):
        output.write(name, columns)
    lost = sum(found[path] for path in COLUMNS[2:])
    np.testing.assert_allclose(found["efficiency"], 1.0 - lost / found["power_w"], rtol=1e-9)
    assert set(found["converter"]) == {"boost", "buck"}
    assert {one.name for one in quantities(found, check)} == CONVERTER_NUMBERS.names({"converter": VOLTS})
    numbers = {one.name: one.value for one in quantities(found, check)}
    assert 0.9 < numbers["boost_full_efficiency"] < numbers["boost_best_efficiency"] < 1.0
    assert numbers["buck_off_switched"] < 5e-4


def test_a_panel_above_the_bus_has_no_boost_converter(chain):
    assert set(efficiency_map(chain, 30.0, 65.25)["converter"]) == {"buck"}
