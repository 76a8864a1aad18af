"""Cell temperature against the models' own equations."""

import numpy as np
import pytest

from pipeline.weather.records import FaimanCells, NoctCells, SapmCells
from pipeline.weather.transposition import cell_temperature_c

LIGHT, AIR, WIND = np.array([0.0, 200.0, 1000.0]), np.array([-5.0, 10.0, 30.0]), np.array([0.0, 1.0, 6.0])


def test_noct_is_what_its_name_says():
    assert cell_temperature_c(NoctCells(noct_c=47.0), [800.0], [20.0], 1.0) == pytest.approx([47.0])


def test_faiman():
    found = cell_temperature_c(FaimanCells(u0_w_m2_k=25.0, u1_w_s_m3_k=6.84), LIGHT, AIR, WIND)
    np.testing.assert_allclose(found, AIR + LIGHT / (25.0 + 6.84 * WIND), rtol=1e-12)


def test_sapm():
    found = cell_temperature_c(SapmCells(a=-3.56, b_s_m=-0.075, cell_above_back_k=3.0), LIGHT, AIR, WIND)
    back = AIR + LIGHT * np.exp(-3.56 - 0.075 * WIND)
    np.testing.assert_allclose(found, back + 3.0 * LIGHT / 1000.0, rtol=1e-12)


@pytest.mark.parametrize(
    "model",
    [
        NoctCells(noct_c=47.0),
        FaimanCells(u0_w_m2_k=25.0, u1_w_s_m3_k=6.84),
        SapmCells(a=-3.5, b_s_m=0, cell_above_back_k=3),
    ],
)
def test_in_the_dark_cells_are_as_warm_as_the_air(model):
    assert cell_temperature_c(model, [0.0], [12.5], 3.0) == pytest.approx([12.5])
