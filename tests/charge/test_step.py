"""The collocation step by itself."""

import numpy as np
import pytest

from pipeline.cell.circuit import compile_cell
from pipeline.cell.records import Battery
from pipeline.charge.energy import finish
from pipeline.charge.segment import Demand, choose_control, commit, set_guess, try_step
from pipeline.charge.state import DEPTH, TEMPERATURE, VOLTAGE_CONTROL, new_run
from tests.charge.test_exact import PLAIN


def held(steps, length_s):
    """Hold 1.8 V on a cell whose open-circuit voltage rises with its charge: x relaxes to 0.4 with 360 s."""
    cell, run = compile_cell(Battery(**PLAIN)), new_run()
    run["state"][DEPTH], run["state"][TEMPERATURE] = 0.9, 298.15
    demand = Demand(1e6, 1.8, np.inf, True)
    for _ in range(steps):
        assert choose_control(cell, run, demand)
        assert run["control"] == VOLTAGE_CONTROL
        set_guess(cell, run, length_s / steps)
        assert try_step(cell, run, demand, 298.15, length_s / steps)
        finish(cell, run, run["slot"], False, 298.15)
        commit(run)
    return run["state"][DEPTH] - 0.4


def test_it_is_of_fifth_order():
    exact = 0.5 * np.exp(-720 / 360)
    errors = [abs(held(steps, 720.0) - exact) for steps in (1, 2, 4, 8)]
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert orders[-1] == pytest.approx(5.0, abs=0.3)
    assert np.all(orders > 4.5)


def test_a_step_of_any_length_leaves_something_to_charge():
    for length_s in (1e3, 1e6, 1e9):
        assert held(1, length_s) > -0.4
