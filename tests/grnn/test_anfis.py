"""The neuro-fuzzy system: its gradient by differences, its planes by optimality, its learning by what it can learn."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.grnn.anfis import Anfis, error_and_slopes, fit_planes, learn, nodes, predict
from pipeline.grnn.records import AnfisSettings, data_of

SETTINGS = AnfisSettings(temperature_sets=3, gradient_sets=2, epochs=30, step=0.1)


def system(seed: int = 1) -> Anfis:
    rng = np.random.default_rng(seed)
    bells = tuple(
        np.column_stack([rng.uniform(0.2, 0.6, sets), rng.uniform(1.0, 3.0, sets), np.linspace(0.0, 1.0, sets)])
        for sets in (3, 2)
    )
    return Anfis((bells[0], bells[1]), rng.normal(size=(6, 3)), np.ones(2))


def test_its_slopes_are_those_of_finite_differences():
    rng = np.random.default_rng(2)
    inputs, wanted, one = rng.uniform(size=(40, 2)), rng.normal(size=40), system()
    _, slopes = error_and_slopes(one, inputs, wanted)
    for side in (0, 1):
        for place in np.ndindex(one.bells[side].shape):
            ends = []
            for change in (1e-6, -1e-6):
                bells = [bell.copy() for bell in one.bells]
                bells[side][place] += change
                ends.append(error_and_slopes(one._replace(bells=tuple(bells)), inputs, wanted)[0])
            assert slopes[side][place] == pytest.approx((ends[0] - ends[1]) / 2e-6, rel=1e-5, abs=1e-8)


def test_a_slope_at_a_bells_centre_is_finite():
    one = system()
    inputs = np.column_stack([one.bells[0][:, 2], np.zeros(3)])
    _, slopes = error_and_slopes(one, inputs, np.zeros(3))
    assert all(np.all(np.isfinite(slope)) for slope in slopes)


def test_no_other_planes_fit_better():
    rng = np.random.default_rng(3)
    inputs, wanted, one = rng.uniform(size=(60, 2)), rng.normal(size=60), system()
    best = one._replace(planes=fit_planes(one.bells, inputs, wanted))
    least, _ = error_and_slopes(best, inputs, wanted)
    for _ in range(20):
        other = best._replace(planes=best.planes + 0.01 * rng.normal(size=(6, 3)))
        assert error_and_slopes(other, inputs, wanted)[0] > least


def test_a_plane_is_learnt_at_once():
    grid = np.stack(np.meshgrid(np.linspace(0.0, 50.0, 11), np.linspace(0.0, 1.0, 6)), axis=-1).reshape(-1, 2)
    rate = 8.0 - 0.1 * grid[:, 0] + 0.5 * grid[:, 1]
    found = learn(data_of(grid[:, 0], grid[:, 1], rate, 60.0), SETTINGS)
    assert found.error[0] < 1e-20
    np.testing.assert_allclose(predict(found.system, grid), rate, atol=1e-9)


def test_learning_lowers_the_error_and_keeps_the_best_system(surfaces):
    data = surfaces["plateau_ramp"]
    found = learn(data, SETTINGS)
    assert found.error.min() < 0.5 * found.error[0]
    assert np.mean((predict(found.system, data.inputs) - data.rate) ** 2) == pytest.approx(found.error.min())


def test_six_rules_make_the_printed_number_of_nodes():
    assert nodes((3, 2)) == 27
    # What MATLAB's documentation shows for one input with two sets, and for two with two each.
    assert nodes((2, 2)) == 21
