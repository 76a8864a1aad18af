"""The network: its exact limits, an independent reference, and that it always has an answer."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.grnn.network import (
    KERNELS,
    command,
    make_network,
    network_fields,
    predict,
    predict_many,
    responses,
    write_network,
)
from pipeline.jit import kernel

CENTRES = np.array([[4.0, 0.2], [23.0, 0.9], [38.0, 0.9], [40.0, 0.5], [43.0, 0.4], [50.0, 0.7]])
RATES = np.array([8.0, 7.0, 6.0, 4.0, 2.0, 0.1])
SHAPE = {"scales": [50.0, 1.0], "low": [0.0, 0.0], "high": [50.0, 1.0]}


def network(kernel: str = "gaussian", widths=(0.1, 0.3), **changes):
    return make_network(CENTRES, RATES, widths=widths, kernel=kernel, **{**SHAPE, **changes})


def reference(kernel: str, queries: np.ndarray, widths, extension: float = 2.0) -> np.ndarray:
    """Eq. (1) written out once more, with nothing done about 0/0."""
    apart = (queries[:, None] - CENTRES[None]) / np.array([50.0, 1.0]) / np.array(widths)
    distance = np.linalg.norm(apart, axis=2)
    if kernel == "gaussian":
        weights = np.exp(-(distance**2) / 2.0)
    else:
        radius = np.ones(len(queries))
        if kernel == "extendable":
            radius = np.maximum(1.0, extension * np.min(distance, axis=1))
        share = distance / radius[:, None]
        weights = np.where(share < 1.0, (1.0 - share) ** 4 * (4.0 * share + 1.0), 0.0)
    return weights @ RATES / np.sum(weights, axis=1)


@pytest.mark.parametrize("name", KERNELS)
def test_it_is_the_equation_written_out(name):
    # So wide that the plain equation nowhere divides by zero.
    queries = np.random.default_rng(1).uniform([0.0, 0.0], [50.0, 1.0], size=(200, 2))
    widths = (1.2, 1.5)
    found = predict_many(network(name, widths), queries[:, 0], queries[:, 1])
    np.testing.assert_allclose(found, reference(name, queries, widths), rtol=1e-12)


@pytest.mark.parametrize("name", KERNELS)
def test_it_reproduces_its_centres_as_the_width_goes_to_zero(name):
    missed = [
        np.max(np.abs(responses(network(name, (width, width)), CENTRES) - RATES)) for width in (0.3, 0.1, 0.03, 1e-4)
    ]
    assert missed[-1] == 0.0
    assert missed == sorted(missed, reverse=True)


def test_a_wide_gaussian_gives_the_mean():
    assert predict(network(widths=(1e6, 1e6)), 20.0, 0.5) == pytest.approx(np.mean(RATES))


def test_far_away_a_gaussian_follows_the_nearest_centre_where_the_plain_equation_is_zero_over_zero():
    narrow = network(widths=(0.01, 0.01))
    query = np.array([[-30.0, 0.2]])
    with np.errstate(invalid="ignore"):
        assert np.isnan(reference("gaussian", query, (0.01, 0.01))[0])
    assert predict(narrow, *query[0]) == 8.0


def test_outside_every_compact_support_the_nearest_centres_answer_and_the_extendable_one_blends():
    narrow = network("wendland", (0.01, 0.01))
    assert predict(narrow, 45.0, 0.45) == 2.0
    # Half way between two centres both are nearest.
    two = make_network([[0.0, 0.0], [10.0, 0.0]], [8.0, 2.0], widths=0.01, scales=[50.0, 1.0], kernel="wendland")
    assert predict(two, 5.0, 0.0) == 5.0
    assert 2.0 < predict(two._replace(kernel=KERNELS.index("extendable")), 4.0, 0.0) < 8.0


def test_an_extendable_kernel_is_continuous_where_its_support_begins_to_extend():
    extended = network("extendable", (0.05, 0.3))
    temperature = np.linspace(0.0, 60.0, 60001)
    assert np.max(np.abs(np.diff(predict_many(extended, temperature, 0.5)))) < 0.01


ANYWHERE = st.floats(allow_nan=False, allow_infinity=False)
WIDTH = st.floats(1e-8, 1e8)


@settings(max_examples=300, deadline=None)
@given(st.sampled_from(KERNELS), ANYWHERE, ANYWHERE, WIDTH, WIDTH, st.floats(1.0 + 1e-6, 100.0))
def test_it_has_an_answer_everywhere_and_it_lies_among_its_outputs(name, temperature, gradient, first, second, reach):
    for answer in (predict, command):
        found = answer(network(name, (first, second), extension=reach), temperature, gradient)
        assert RATES.min() * (1.0 - 1e-9) <= found <= RATES.max() * (1.0 + 1e-9)


def test_a_command_converts_the_rate_in_one_place_and_stays_within_the_data():
    one = network()
    assert one.gradient_seconds == 60.0
    assert command(one, 41.0, 0.01) == predict(one, 41.0, 0.6)
    assert command(one._replace(gradient_seconds=1.0), 41.0, 0.6) == predict(one, 41.0, 0.6)
    assert command(one, 70.0, -1.0) == predict(one, 50.0, 0.0)
    assert command(one, -5.0, 5.0) == predict(one, 0.0, 1.0)


@kernel
def _commanded(bank, temperature, rate):
    return command(bank, temperature, rate)


def test_in_a_kernel_a_record_answers_as_the_network_does():
    one = network("extendable")
    bank = np.zeros(1, dtype=np.dtype(network_fields(8), align=True)).view(np.recarray)[0]
    write_network(bank, one)
    assert _commanded(bank, 41.0, 0.01) == _commanded(one, 41.0, 0.01) == command(one, 41.0, 0.01)
    small = np.zeros(1, dtype=np.dtype(network_fields(5), align=True)).view(np.recarray)[0]
    with pytest.raises(ValueError, match="6 centres; this kernel takes 5"):
        write_network(small, one)


def test_it_goes_through_a_pickle():
    one = network()
    again = pickle.loads(pickle.dumps(one))
    assert predict(again, 41.0, 0.3) == predict(one, 41.0, 0.3)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"widths": [0.1, 0.0]}, "widths is .* above 0"),
        ({"widths": np.nan}, "widths is .* finite"),
        ({"kernel": "gausian"}, "gausian.*gaussian"),
        ({"extension": 1.0}, "extension is 1.0.*above 1"),
        ({"gradient_seconds": 0.0}, "gradient_seconds is 0.0"),
    ],
)
def test_a_mistake_is_named(changes, message):
    with pytest.raises(ValueError, match=message):
        make_network(CENTRES, RATES, **{"widths": 0.1, **changes})


def test_outputs_must_fit_the_centres():
    with pytest.raises(ValueError, match="allowed are"):
        make_network(CENTRES, RATES[:-1], widths=0.1)
    with pytest.raises(ValueError, match="finite"):
        make_network(CENTRES, [np.nan, *RATES[1:]], widths=0.1)
