import numpy as np
import pytest
from scipy.integrate import quad

from pipeline.cell.circuit import CELL
from pipeline.cell.curves import compile_curves, integral, value_and_slope
from pipeline.cell.records import Inverse, Logarithm, Polynomial, Root, Shepherd, Tabulated, value_of

CURVES = {
    "constant": 3.2,
    "polynomial": Polynomial(polynomial=[2.15, -0.17, 0.02, 0.3]),
    "logarithm": Logarithm(constant=1.3, factor=0.02, soc_offset=0.02, depth_offset=1e-3),
    "root": Root(factor=1.2, soc_offset=0.02),
    "shepherd": Shepherd(full_v=12.3, polarisation_v=0.35),
    "inverse": Inverse(factor=0.048, depth_offset=0.1),
    "table": Tabulated(soc=[0, 0.1, 0.4, 0.8, 1], value=[2.8, 3.1, 3.2, 3.3, 3.5], scale=2.0),
}


def bank_of(curve):
    bank = np.zeros(1, dtype=CELL).view(np.recarray)[0]
    compile_curves(bank, [curve], [1.0])
    return bank


@pytest.mark.parametrize("name", CURVES)
@pytest.mark.parametrize("x", [0.013, 0.35, 0.77])
def test_the_slope_is_that_of_the_value(name, x):
    bank = bank_of(CURVES[name])
    h = 1e-6
    difference = (value_and_slope(bank, 0, x + h)[0] - value_and_slope(bank, 0, x - h)[0]) / (2 * h)
    assert value_and_slope(bank, 0, x)[1] == pytest.approx(difference, rel=1e-7, abs=1e-8)


@pytest.mark.parametrize("name", [name for name in CURVES if name != "root"])
def test_the_integral_over_soc_is_that_of_the_value(name):
    bank = bank_of(CURVES[name])
    expected, _ = quad(
        lambda soc: value_and_slope(bank, 0, 1 - soc)[0], 0.05, 0.95, points=[0.1, 0.4, 0.8], epsrel=1e-12
    )
    assert integral(bank, 0, 0.05) - integral(bank, 0, 0.95) == pytest.approx(expected, rel=1e-11)


@pytest.mark.parametrize("name", CURVES)
def test_the_uncompiled_value_agrees_at_the_knots(name):
    bank = bank_of(CURVES[name])
    for soc in (0.1, 0.4, 0.8):
        assert value_of(CURVES[name], soc) == pytest.approx(value_and_slope(bank, 0, 1 - soc)[0], rel=1e-12)


def test_a_table_is_monotone_between_its_points():
    bank = bank_of(CURVES["table"])
    found = [value_and_slope(bank, 0, x)[0] for x in np.linspace(0, 1, 301)]
    assert np.all(np.diff(found) < 0)
