"""What a row comes to, and what makes the target fail."""

from __future__ import annotations

import importlib
import math

import numpy as np
import pytest

from pipeline.commands.validate import exit_code, findings
from pipeline.experiments.validation import order
from pipeline.experiments.validation.records import Curve, Found, Row, at_least, at_most, largest
from pipeline.experiments.validation.registry import CHECKS, installed, module_name
from pipeline.experiments.validation.validation import run
from tests import making


@pytest.mark.parametrize(
    ("row", "finding"),
    [
        (at_most("error", 1e-9, 1e-9), "holds"),
        (at_most("error", 1.1e-9, 1e-9), "broken"),
        (at_least("order", 4.9, 4.5), "holds"),
        (at_least("order", 4.4, 4.5), "broken"),
        (at_most("error", math.nan, 1.0), "broken"),
        (at_least("order", math.nan, 1.0), "broken"),
        (at_most("error", largest(np.array([0.0, math.nan])), 1.0), "broken"),
        (at_most("difference", None, 1.0), "not installed"),
        (Row("power", 1.4), "told"),
    ],
)
def test_a_row_is_judged_by_its_bound(row: Row, finding: str) -> None:
    assert row.finding == finding


@pytest.mark.parametrize(
    ("found", "code"),
    [
        ({"exact": ["holds", "told"]}, 0),
        ({"exact": ["holds"], "against_ngspice": ["not installed"]}, 0),
        ({"exact": ["holds"], "order": ["holds", "broken"]}, 1),
        ({"exact": ["holds"], "order": []}, 1),
    ],
)
def test_a_broken_bound_fails_the_target(found: dict[str, list[str]], code: int) -> None:
    assert exit_code({name: [{"finding": one} for one in rows] for name, rows in found.items()}) == code


@pytest.mark.parametrize("name", CHECKS)
def test_every_check_has_its_module(name: str) -> None:
    assert callable(importlib.import_module(module_name(name)).check)
    peer = CHECKS[name].peer
    assert peer is None or installed(peer) is None or installed(peer)


def test_the_step_writes_what_the_terminal_reads(tmp_path, monkeypatch) -> None:
    found = Found(
        [at_most("error", 2.0, 1.0, "V", "why"), at_most("other", None, 1.0), Row("told", 3.0)],
        [Curve("field", "line", "time [s]", "error [V]", np.arange(3.0), np.ones(3))],
    )
    for name in CHECKS:
        monkeypatch.setattr(importlib.import_module(module_name(name)), "check", lambda settings: found)
        folder = tmp_path / name
        run({"check": name, "settings": {}}, making.inputs({}), making.output("validation", folder))
        (folder / "rows.parquet").rename(tmp_path / f"{name}.rows.parquet")
    read = dict(findings(tmp_path))
    assert list(read) == list(CHECKS)
    assert [row["finding"] for row in read["exact"]] == ["broken", "not installed", "told"]
    assert exit_code(read) == 1


def test_the_slope_is_that_of_a_power() -> None:
    lengths = [1.0, 2.0, 4.0]
    assert order.fitted_order(lengths, [3e-6 * x**5 for x in lengths]) == pytest.approx(5.0, rel=1e-12)
    assert math.isnan(order.fitted_order(lengths, [1e-16] * 3))
