"""The first law, for every cell and every mode, against state functions; and that it fails when it should."""

import numpy as np
import pytest

from pipeline.cell.circuit import compile_cell
from pipeline.charge.energy import balance, pair_stores
from pipeline.charge.records import EngineSettings, Mode
from pipeline.charge.simulate import BENCH, run
from tests.charge.samples import BATTERIES, ENGINE, MODES, SUITED, battery, charge, settings, suited_mode, values


@pytest.mark.parametrize("cell", BATTERIES)
@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("soc", [0.3, 0.8])  # flat and sloping parts of the curves
def test_it_closes(cell, mode, soc):
    result = charge(battery(cell), suited_mode(mode, cell), settings(soc))
    assert abs(values(result)["energy_balance_residual"]) < 1e-9
    energy = dict(zip(result.energy["path"], result.energy["energy_j"], strict=True))
    heat = sum(e for e, role in zip(result.energy["energy_j"], result.energy["role"], strict=True) if role == "loss")
    assert heat == pytest.approx(energy["sensible"] + energy["ambient"], rel=1e-9, abs=1e-7)


@pytest.mark.parametrize("cell", BATTERIES)
@pytest.mark.parametrize("mode", MODES)
def test_it_closes_over_strides(cell, mode):
    averaged = EngineSettings(driver="averaged", maximum_steps=2_000_000)
    sheet = suited_mode(mode, cell, stop_s=200.0)
    result = charge(battery(cell), sheet, settings(SUITED[cell][2]), engine=averaged)
    assert abs(values(result)["energy_balance_residual"]) < 1e-6
    energy = dict(zip(result.energy["path"], result.energy["energy_j"], strict=True))
    heat = sum(e for e, role in zip(result.energy["energy_j"], result.energy["role"], strict=True) if role == "loss")
    assert heat == pytest.approx(energy["sensible"] + energy["ambient"], rel=1e-9, abs=1e-7)


def outcome_of(cell, mode, soc, stop_s=40.0):
    return run(battery(cell), suited_mode(mode, cell, stop_s=stop_s), BENCH, settings(soc), ENGINE)


def residual(outcome, against, pairs):
    cell = compile_cell(against)
    energy = balance(cell, outcome.book.gains, outcome.start, outcome.run["state"], pairs)
    of_path = dict(zip(energy["path"], energy["energy_j"], strict=True))
    return abs(of_path["residual"] / of_path["electrical"])


def test_the_wrong_sign_of_the_entropy_shows():
    outcome = outcome_of("lead_acid_12v7ah", "cv_reflex", 0.8)
    right = battery("lead_acid_12v7ah")
    wrong = right.model_copy(update={"entropic_coefficient_v_k": -right.entropic_coefficient_v_k})
    assert residual(outcome, right, tuple(right.pairs)) < 1e-9
    assert residual(outcome, wrong, tuple(right.pairs)) > 1e-2


def test_a_lost_pair_shows():
    outcome = outcome_of("lead_acid_12v7ah", "cv_reflex", 0.8)
    right = battery("lead_acid_12v7ah")
    wrong = right.model_copy(update={"acceptance": None})
    assert residual(outcome, wrong, tuple(right.pairs)) > 1e-6


def test_heat_that_is_left_out_shows():
    outcome = outcome_of("lead_acid_12v7ah", "cc_cv", 0.8)
    outcome.run["state"][1] -= 1e-6
    right = battery("lead_acid_12v7ah")
    assert residual(outcome, right, tuple(right.pairs)) > 1e-9


@pytest.mark.parametrize("cell", BATTERIES)
def test_after_a_long_rest_every_pair_is_empty(cell):
    rate, voltage, soc = SUITED[cell]
    phases = {
        "charge": {"constant_voltage": {}, "until": {"elapsed_s": 60}},
        "rest": {"rest": {}},
    }
    mode = Mode(title="Rest", max_current_c_rate=rate, voltage_v=voltage, phases=phases, stop={"elapsed_s": 40000})
    outcome = run(battery(cell), mode, BENCH, settings(soc), ENGINE)
    # Self-discharge by the side reaction, less than a milliampere, goes on through the pairs.
    assert np.abs(pair_stores(outcome.cell, outcome.run["state"])).sum() < 1e-8
    assert residual(outcome, battery(cell), tuple(battery(cell).pairs)) < 1e-9
