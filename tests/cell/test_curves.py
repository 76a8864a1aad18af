import numpy as np
import pytest
from pydantic import ValidationError
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


def test_a_table_of_five_hundred_points_is_the_curve_it_samples():
    soc = np.linspace(0, 1, 512)
    bank = bank_of(Tabulated(soc=soc.tolist(), value=(3.0 + 0.5 * np.sin(1.5 * soc)).tolist()))
    for x in np.linspace(0.001, 0.999, 97):
        assert value_and_slope(bank, 0, x)[0] == pytest.approx(3.0 + 0.5 * np.sin(1.5 * (1 - x)), abs=1e-7)
    with pytest.raises(ValidationError, match="at most 512"):
        Tabulated(soc=np.linspace(0, 1, 513).tolist(), value=[3.0] * 513)


def test_a_table_that_reaches_beyond_is_cut_at_full_and_empty():
    wide = Tabulated(soc=[-0.05, 0.05, 0.5, 0.98, 1.05], value=[2.6, 3.0, 3.3, 3.4, 3.75])
    cut = Tabulated(soc=[0, 0.05, 0.5, 0.98, 1], value=[2.8, 3.0, 3.3, 3.4, 3.5])
    assert wide.outside == [-0.05, 1.05]
    assert np.allclose(wide.inside, [cut.soc, cut.value], rtol=1e-15)
    one, other = bank_of(wide), bank_of(cut)
    for x in (0.0, 0.01, 0.3, 0.97, 1.0):
        assert value_and_slope(one, 0, x) == pytest.approx(value_and_slope(other, 0, x), rel=1e-12)
        assert value_of(wide, 1 - x) == pytest.approx(value_of(cut, 1 - x), rel=1e-12)
    assert Tabulated.model_validate(wide.model_dump()) == wide
