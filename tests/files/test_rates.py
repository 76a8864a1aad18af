"""A person's own table of charging rates: read when a study is planned, within what is possible."""

import numpy as np
import pytest

from pipeline.errors import UserError
from pipeline.files.profiles import read

GOOD = "temperature_c,gradient,rate_c\n0,0,1\n25,0.5,4\n40,1,0.5\n"


def written(folder, text, name="own.csv"):
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("text", [GOOD, GOOD.replace(".", ",").replace(",", ";", 2), "# from a sheet\n" + GOOD])
def test_a_table_is_read(tmp_path, text):
    if text.startswith("temperature_c;"):
        text = "temperature_c;gradient;rate_c\n0;0;1\n25;0,5;4\n40;1;0,5\n"
    found = read(written(tmp_path, text), 60.0)
    np.testing.assert_array_equal(found.temperature_c, [0, 25, 40])
    np.testing.assert_array_equal(found.gradient, [0, 0.5, 1])
    np.testing.assert_array_equal(found.rate_c, [1, 4, 0.5])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("25,0.5,4", "25,0.5,1e30"), r"line 3, column rate_c: value '1e30'; allowed is a number from 0 to 100 C"),
        (("25,0.5,4", "25,0.5,-1"), r"line 3, column rate_c: value '-1'; allowed is a number from 0 to 100 C"),
        (("25,0.5,4", "1e300,0.5,4"), r"line 3, column temperature_c: value '1e300'; .* -60 to 120 degC"),
        (("25,0.5,4", "298,0.5,4"), r"column temperature_c: value '298'; .* Is it in kelvin\?"),
        (("25,0.5,4", "25,61,4"), r"line 3, column gradient: value '61'; allowed is a number from -60 to 60 K/min"),
        (("25,0.5,4", "25,0.5,4,7"), r"line 3: 4 values; allowed are 3"),
        (("25,0.5,4", "25,0.5"), r"line 3: 2 values; allowed are 3"),
        (("25,0.5,4", "25,0.5,True"), r"line 3, column rate_c: value 'True'"),
        (("25,0.5,4", "25,0.5,"), r"line 3, column rate_c: empty"),
        (("25,0.5,4", "0,0,4"), r"line 3: temperature_c 0, gradient 0 stands there more than once, first in line 2"),
        (("rate_c", "rate"), r"no column 'rate_c' \[C\]; best matches are: rate"),
        ((GOOD, ""), r"empty; allowed is a line of column names"),
        ((GOOD, GOOD[:36]), r"1 points; allowed are 2 or more"),
    ],
)
def test_a_mistake_is_told(tmp_path, change, message):
    with pytest.raises(UserError, match=message):
        read(written(tmp_path, GOOD.replace(*change)), 60.0)


def test_the_gradients_unit_sets_its_limit(tmp_path):
    with pytest.raises(UserError, match=r"from -1 to 1 K/s"):
        read(written(tmp_path, GOOD.replace("40,1", "40,2")), 1.0)
    with pytest.raises(ValueError, match="gradient_seconds is 0"):
        read(written(tmp_path, GOOD), 0.0)
