"""Many charges at once are the charges one by one."""

import numpy as np
import pytest

from pipeline.charge.records import EngineSettings, Mode
from pipeline.charge.simulate import BENCH, Task, simulate, simulate_many
from pipeline.errors import UserError
from tests.charge.samples import BATTERIES, MODES, SUITED, battery, load, settings, suited_mode


def tasks():
    engine = EngineSettings()
    return [
        Task(battery(cell), suited_mode(mode, cell), BENCH, settings(SUITED[cell][2]), engine)
        for cell in BATTERIES
        for mode in MODES
    ]


def test_they_are_the_same_bit_for_bit():
    for task, found in zip(tasks(), simulate_many(tasks(), threads=4), strict=True):
        expected = simulate(*task)
        assert found.summary == expected.summary
        for name, column in expected.trace.items():
            assert np.array_equal(found.trace[name], column)
        assert np.array_equal(found.energy["energy_j"], expected.energy["energy_j"])


def test_the_order_does_not_matter():
    for task, found in zip(tasks()[::-1], simulate_many(tasks()[::-1]), strict=True):
        assert found.summary == simulate(*task).summary


def test_a_mode_that_does_not_fit_is_named():
    bad = Mode(**(load("modes/cc_cv.yaml") | {"voltage_v": 11.0}))
    one = tasks()[0]
    with pytest.raises(UserError, match="11 V does not charge"):
        simulate_many([one, one._replace(battery=battery("lead_acid_12v7ah"), mode=bad)])
