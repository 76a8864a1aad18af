from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from pipeline.taguchi import arrays
from pipeline.taguchi.arrays import Design
from tests.cards import card

CONF = Path(__file__).parents[2] / "conf"


def table(name):
    with (CONF / "published" / "reference" / name).open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    return {key: np.array([float(row[key]) for row in rows]) for key in rows[0]}


@pytest.fixture(scope="session")
def design():
    return Design(**card("design"))


@pytest.fixture(scope="session")
def array(design):
    return arrays.rows(design)


@pytest.fixture(scope="session")
def table_2():
    return table("solar_table2.csv")


@pytest.fixture(scope="session")
def table_3():
    return table("solar_table3.csv")
