"""Segments crossed in closed form, with a side reaction and without, against the same charge step by step.

A window over the whole charge forbids the closed form, as every step must then be there to be drawn.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from pipeline.cell.records import Battery
from pipeline.charge.records import Mode
from pipeline.charge.simulate import BENCH, Supply, run
from pipeline.errors import EngineError
from tests.charge.independent import AMBIENT_K, circuit, slopes
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
SHEET = load("battery/lead_acid_12v7ah.yaml")
LEAK = {"current_a": 0.002, "reference_voltage_v": 2.15, "thermal_voltages": 3.0, "activation_energy_j_mol": 40000.0}
LEAKING = {
    "side_reaction": Battery(**SHEET),
    "side_reaction_without_acceptance": Battery(**{key: part for key, part in SHEET.items() if key != "acceptance"}),
    "thermal_side_reaction": Battery(**(SHEET | {"side_reaction": LEAK | {"reference_temperature_c": 20.0}})),
}
CELLS = LEAKING | {
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
BOTH_WAYS = ["lead_acid", "side_reaction"]


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
    """Compare tables, the side current on the scale of the total current: a step's tolerance is a share of that."""
    for name, column in one.trace.items():
        scale = np.abs(other.trace["Current / A" if name == "side_current_a" else name]).max() + 1e-9
        # A step's extremes are those before its last correction: they differ, and so does when they meet a limit.
        share = 1e-8 if name.startswith("voltage_") else 1e-9
        assert np.abs(column - other.trace[name]).max() <= share * scale, name


@pytest.mark.parametrize("soc", [0.2, 0.55])
@pytest.mark.parametrize("cell", CELLS.values(), ids=CELLS)
def test_it_agrees_with_the_steps(cell, soc):
    closed, stepped = both(cell, reflex(cell), soc)
    same(closed, stepped)
    rise, expected = (values(charge)["end_temperature_c"] - 25.0 for charge in (closed, stepped))
    assert rise == pytest.approx(expected, rel=1e-7)
    assert abs(values(closed)["energy_balance_residual"]) < 1e-9
    assert abs(values(stepped)["energy_balance_residual"]) < 1e-9


def test_a_side_reaction_agrees_with_scipy():
    periods, period_s, soc = 20, 1.0 / 90.0, 0.55
    mode = reflex(LEAKING["side_reaction"])
    closed = charged(LEAKING["side_reaction"], mode, settings_of(soc, sample_interval_s=period_s)).trace
    state, depths, highest = np.array([1.0 - soc, 0.0, 0.0, 0.0, AMBIENT_K, 0.0]), [], []
    for _ in range(periods):
        for current, share in ((2.1, 0.9), (-0.5, 0.05), (0.0, 0.05)):
            state = solve_ivp(
                slopes, (0.0, share * period_s), state, "DOP853", rtol=1e-12, atol=1e-15, args=("current", current)
            ).y[:, -1]
            if current > 0.0:
                _, _, _, node, ohm = circuit(state, "current", current)
                highest.append(6 * (node + ohm * current))
        depths.append(state[0])
    assert closed["voltage_max_v"][:periods] == pytest.approx(highest, abs=2e-10)
    assert closed["soc"][:periods] == pytest.approx(1.0 - np.array(depths), abs=1e-14)


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
        return {"temperature_c": float(free.trace["Surface Temperature / degC"][half])}
    # Between the peaks of two periods.
    return {"voltage_v": float(free.trace["voltage_max_v"][half]) + 1e-6}


@pytest.mark.parametrize("what", ["soc", "temperature_c", "voltage_v"])
@pytest.mark.parametrize("name", BOTH_WAYS)
def test_a_stop_is_met_where_the_steps_meet_it(name, what):
    cell = CELLS[name]
    mode = reflex(cell, **meeting(cell, what))
    closed, stepped = both(cell, mode, 0.4)
    assert closed.phases["end_reason"] == stepped.phases["end_reason"]
    assert what.split("_")[0] in closed.phases["end_reason"][-1]
    assert closed.phases["end_s"] == pytest.approx(stepped.phases["end_s"], abs=1e-6)


@pytest.mark.parametrize("name", BOTH_WAYS)
def test_a_limit_on_voltage_is_kept(name):
    cell = CELLS[name]
    free = charged(cell, reflex(cell), settings(0.4))
    limit = float(free.trace["voltage_max_v"].max()) - 0.01
    sheet = reflex(cell).model_dump(exclude_unset=True) | {"voltage_v": limit}
    closed, stepped = both(cell, Mode(**sheet), 0.4)
    assert closed.trace["voltage_limited_share"].max() > 0.1
    assert closed.trace["voltage_max_v"].max() <= limit * (1 + 2e-9)
    same(closed, stepped)


@pytest.mark.parametrize("name", BOTH_WAYS)
def test_a_weak_supply_is_kept(name):
    cell = CELLS[name]
    supply = Supply(np.array([0.0, 0.6 * SPAN_S]), np.array([24.0, 100.0]))
    closed, stepped = both(cell, reflex(cell), 0.4, supply)
    assert closed.trace["supply_limited_share"].max() > 0.1
    same(closed, stepped)


@pytest.mark.parametrize("name", BOTH_WAYS)
def test_marks_are_noted_where_the_steps_note_them(name):
    cell = CELLS[name]
    free = charged(cell, reflex(cell), settings(0.4))
    marks = [float(soc) for soc in free.trace["soc"][1:-1:2]]
    noted = []
    for windows in ([], [{"start_s": 0.0, "length_s": SPAN_S + 1.0}]):
        outcome = run(cell, reflex(cell), BENCH, settings(0.4, soc_marks=marks, windows=windows), ENGINE)
        noted.append(outcome.book.marks)
    assert np.isfinite(noted[0]).all()
    assert noted[0] == pytest.approx(noted[1], abs=1e-6)


@pytest.mark.parametrize("name", BOTH_WAYS)
def test_the_most_steps_hold_for_it_too(name):
    cell = CELLS[name]
    with pytest.raises(EngineError, match=r"the steps are used up at .* after 101 steps"):
        charged(cell, reflex(cell), settings(0.4), engine=ENGINE.model_copy(update={"maximum_steps": 100}))
