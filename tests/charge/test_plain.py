"""Segments crossed in closed form, against the same charge step by step.

A window over the whole charge forbids the closed form, as every step must then be there to be drawn.
"""

import numpy as np
import pytest

from pipeline.cell.records import Battery
from pipeline.charge.records import Mode
from pipeline.charge.simulate import BENCH, Supply, run
from pipeline.errors import EngineError
from tests.charge.samples import ENGINE, load, values
from tests.charge.samples import charge as charged
from tests.charge.samples import settings as settings_of

SPAN_S = 3.0


def plain(name, **more):
    """Return a battery without what keeps its segments from the closed form."""
    sheet = load(f"battery/{name}.yaml")
    for part in ("acceptance", "side_reaction", "charge_transfer", "hysteresis", "thermoneutral_voltage_v"):
        sheet.pop(part, None)
    return Battery(**(sheet | more))


TABLES = {"soc": [0.0, 0.3, 0.6, 1.0]}
CELLS = {
    "lead_acid": plain("lead_acid_12v7ah"),
    "lithium_iron_phosphate": plain("lfp_8ah"),
    "tables": plain(
        "lead_acid_12v7ah",
        series_resistance_ohm=TABLES | {"value": [0.006, 0.004, 0.0035, 0.005]},
        entropic_coefficient_v_k=TABLES | {"value": [-4e-4, 1e-4, 2e-4, -1e-4]},
        pairs={
            "fast": {"resistance_ohm": TABLES | {"value": [0.004, 0.002, 0.003, 0.006]}, "time_constant_s": 0.002},
            "slow": {"resistance_ohm": TABLES | {"value": [0.008, 0.005, 0.003, 0.004]}, "time_constant_s": 40.0},
        },
    ),
}


def settings(soc, **more):
    return settings_of(soc, sample_interval_s=0.25, **more)


def reflex(cell, **stop):
    sheet = load("modes/cv_reflex.yaml")
    sheet = {key: value for key, value in sheet.items() if key not in ("max_current_a", "phases")}
    phases = {"reflex": load("modes/cv_reflex.yaml")["phases"]["reflex"]}
    volts = 2.4 * cell.cells_in_series if cell.cells_in_series > 1 else 3.6
    return Mode(**(sheet | {"phases": phases, "voltage_v": volts, "stop": {"elapsed_s": SPAN_S} | stop}))


def both(cell, mode, soc, supply=BENCH):
    """Return the charge in closed form wherever that serves, and step by step."""
    window = [{"start_s": 0.0, "length_s": SPAN_S + 1.0}]
    return [charged(cell, mode, settings(soc, windows=windows), supply) for windows in ([], window)]


def same(one, other):
    for name, column in one.trace.items():
        scale = np.abs(other.trace[name]).max() + 1e-9
        assert np.abs(column - other.trace[name]).max() <= 1e-9 * scale, name


@pytest.mark.parametrize("soc", [0.2, 0.55])
@pytest.mark.parametrize("cell", CELLS.values(), ids=CELLS)
def test_it_agrees_with_the_steps(cell, soc):
    closed, stepped = both(cell, reflex(cell), soc)
    same(closed, stepped)
    rise, expected = (values(charge)["end_temperature_c"] - 25.0 for charge in (closed, stepped))
    assert rise == pytest.approx(expected, rel=1e-7)
    assert abs(values(closed)["energy_balance_residual"]) < 1e-9
    assert abs(values(stepped)["energy_balance_residual"]) < 1e-9


@pytest.mark.parametrize("cell", CELLS.values(), ids=CELLS)
def test_the_two_ways_are_two(cell):
    window = [{"start_s": 0.0, "length_s": SPAN_S + 1.0}]
    closed, stepped = (
        run(cell, reflex(cell), BENCH, settings(0.4, windows=windows), ENGINE) for windows in ([], window)
    )
    assert (closed.run["plain_s"] > 0.0).all()
    assert (stepped.run["plain_s"] < 0.0).all()


def meeting(cell, what):
    """Return a limit that a charge from SOC 0.4 meets on its way, and where it stands in the summary."""
    free = charged(cell, reflex(cell), settings(0.4))
    half = len(free.trace["soc"]) // 2
    if what == "soc":
        return {"soc": float(free.trace["soc"][half])}
    if what == "temperature_c":
        return {"temperature_c": float(free.trace["Surface Temperature T1 / degC"][half])}
    # Between the peaks of two periods.
    return {"voltage_v": float(free.trace["voltage_max_v"][half]) + 1e-6}


@pytest.mark.parametrize("what", ["soc", "temperature_c", "voltage_v"])
def test_a_stop_is_met_where_the_steps_meet_it(what):
    cell = CELLS["lead_acid"]
    mode = reflex(cell, **meeting(cell, what))
    closed, stepped = both(cell, mode, 0.4)
    assert closed.phases["end_reason"] == stepped.phases["end_reason"]
    assert what.split("_")[0] in closed.phases["end_reason"][-1]
    assert closed.phases["end_s"] == pytest.approx(stepped.phases["end_s"], abs=1e-6)


def test_a_limit_on_voltage_is_kept():
    cell = CELLS["lead_acid"]
    free = charged(cell, reflex(cell), settings(0.4))
    limit = float(free.trace["voltage_max_v"].max()) - 0.01
    sheet = reflex(cell).model_dump(exclude_unset=True) | {"voltage_v": limit}
    closed, stepped = both(cell, Mode(**sheet), 0.4)
    assert closed.trace["voltage_limited_share"].max() > 0.1
    assert closed.trace["voltage_max_v"].max() <= limit * (1 + 2e-9)
    same(closed, stepped)


def test_a_weak_supply_is_kept():
    cell = CELLS["lead_acid"]
    supply = Supply(np.array([0.0, 0.6 * SPAN_S]), np.array([24.0, 100.0]))
    closed, stepped = both(cell, reflex(cell), 0.4, supply)
    assert closed.trace["supply_limited_share"].max() > 0.1
    same(closed, stepped)


def test_marks_are_noted_where_the_steps_note_them():
    cell = CELLS["lead_acid"]
    free = charged(cell, reflex(cell), settings(0.4))
    marks = [float(soc) for soc in free.trace["soc"][1:-1:2]]
    noted = []
    for windows in ([], [{"start_s": 0.0, "length_s": SPAN_S + 1.0}]):
        outcome = run(cell, reflex(cell), BENCH, settings(0.4, soc_marks=marks, windows=windows), ENGINE)
        noted.append(outcome.book.marks)
    assert np.isfinite(noted[0]).all()
    assert noted[0] == pytest.approx(noted[1], abs=1e-6)


def test_the_most_steps_hold_for_it_too():
    cell = CELLS["lead_acid"]
    with pytest.raises(EngineError, match=r"the steps are used up at .* after 101 steps"):
        charged(cell, reflex(cell), settings(0.4), engine=ENGINE.model_copy(update={"maximum_steps": 100}))
