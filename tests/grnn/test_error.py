"""Errors of many networks at once: the same as one by one, and as the networks themselves give."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.grnn.error import Form, candidates, errors, network_of
from pipeline.grnn.network import KERNELS, responses


@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("widths", [(0.002, 0.01), (0.02, 0.3), (0.2, 1.0), (1.0, 10.0)])
def test_a_population_at_once_is_each_network_by_itself(surfaces, kernel, widths):
    data, form = surfaces["sigmoid"], Form(kernel, widths)
    strings = np.random.default_rng(2).integers(len(data.rate), size=(40, 6))
    strings[0] = strings[0, 0]
    table = candidates(data, form)
    together = errors(table, strings)
    np.testing.assert_array_equal(together, [errors(table, string[None])[0] for string in strings])
    networks = [network_of(data, form, string) for string in strings]
    expected = [np.mean((responses(one, data.inputs) - data.rate) ** 2) for one in networks]
    np.testing.assert_allclose(together, expected, rtol=1e-9)


def test_all_points_as_centres_of_no_width_leave_no_error(surfaces):
    data = surfaces["plateau_ramp"]
    for kernel in KERNELS:
        table = candidates(data, Form(kernel, (1e-4, 1e-4)))
        assert errors(table, np.arange(len(data.rate))[None])[0] == 0.0


def test_one_centre_gives_its_output_everywhere(surfaces):
    data = surfaces["plateau_ramp"]
    table = candidates(data, Form("extendable", (0.1, 1.0)))
    assert errors(table, np.array([[560]]))[0] == pytest.approx(np.mean((data.rate - data.rate[560]) ** 2))
