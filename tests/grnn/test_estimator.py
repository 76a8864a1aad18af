"""The network under scikit-learn's conventions."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.grnn.estimator import GeneralizedRegression
from pipeline.grnn.kernels import KERNELS
from pipeline.grnn.network import make_network, predict_many


@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.filterwarnings("ignore:Estimator GeneralizedRegression does not inherit")
def test_it_passes_scikit_learns_own_checks(kernel):
    checks = pytest.importorskip("sklearn.utils.estimator_checks")
    found = checks.check_estimator(GeneralizedRegression(kernel=kernel), on_skip=None, on_fail=None)
    assert len(found) > 40
    assert [(one["check_name"], one["exception"]) for one in found if one["status"] == "failed"] == []


def test_it_is_tuned_by_a_grid_search_and_cloned():
    selection = pytest.importorskip("sklearn.model_selection")
    rng = np.random.default_rng(1)
    inputs = rng.uniform(size=(80, 2))
    search = selection.GridSearchCV(GeneralizedRegression(), {"widths": [0.001, 0.05, 5.0]}, cv=4)
    search.fit(inputs, np.sin(4.0 * inputs[:, 0]))
    assert search.best_params_ == {"widths": 0.05}


def test_it_is_the_network_of_its_rows(surfaces):
    data, rows = surfaces["plateau_ramp"], [4, 300, 440, 477, 560]
    fitted = GeneralizedRegression(widths=(0.05, 1.0), rows=rows).fit(data.inputs, data.rate)
    same = make_network(data.inputs[rows], data.rate[rows], widths=(0.05, 1.0), scales=data.scales)
    expected = predict_many(same, data.inputs[:, 0], data.inputs[:, 1])
    np.testing.assert_array_equal(fitted.predict(data.inputs), expected)
    explained = 1.0 - np.mean((expected - data.rate) ** 2) / np.var(data.rate)
    assert fitted.score(data.inputs, data.rate) == pytest.approx(explained)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"rows": [0, 9]}, "rows go from 0 to 9; allowed are 0 to 4"),
        ({"rows": [0.5]}, "allowed are whole numbers"),
        ({"scales": "larges"}, "allowed are 'largest'"),
        ({"kernel": "gausian"}, "gaussian"),
    ],
)
def test_a_mistake_is_named(arguments, message):
    with pytest.raises(ValueError, match=message):
        GeneralizedRegression(**arguments).fit(np.arange(10.0).reshape(5, 2), np.arange(5.0))


def test_before_it_is_fitted_it_says_so():
    with pytest.raises(ValueError, match="not fitted"):
        GeneralizedRegression().predict([[1.0, 2.0]])
    with pytest.raises(ValueError, match=r"no parameter 'width'.*widths"):
        GeneralizedRegression().set_params(width=3.0)
