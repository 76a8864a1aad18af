"""Many charges at once are the charges one by one, bit for bit, and fail as they do."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as limits
from hypothesis import strategies as st

from pipeline.cell.bank import compile_cells, new_room
from pipeline.cell.circuit import compile_cell
from pipeline.cell.records import Battery, resting_voltage_v
from pipeline.charge import drive, population
from pipeline.charge.feasible import NEVER_FULL, check_range, check_resistance
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode, Window
from pipeline.charge.simulate import BENCH, Supply, Task, simulate, simulate_many, try_many
from pipeline.charge.soundness import EMPTY_V, FOUND, FULL_V, SOUND, START_V, WARM_FULL_V, look
from pipeline.errors import EngineError, UserError
from tests.charge import samples
from tests.charge.samples import BATTERIES, MODES, SUITED, load, settings, suited_mode
from tests.charge.test_controller import NETWORK

battery = cache(samples.battery)
ENGINE = EngineSettings()
SUN = Supply(
    np.array([0.0, 7.0, 20.0]), np.array([30.0, 4.0, 11.0]), np.array([1.1, 1.2, 1.3]), np.array([0.5, 0.0, 2.0])
)
HELD = np.ones(1, dtype=bool)
SENSOR = {"sample_interval_s": 1.0, "rate_span_s": 5.0, "temperature_noise_k": 0.1, "noise_stream": 3}


def waveforms(cell, hz=90.0):
    """Return a mode of every waveform, suited to a battery; by name."""
    rate, volts, _ = SUITED[cell]
    pulse = {"charge_a": "i", "charge_share": 0.8, "frequency_hz": hz}
    reflex = pulse | {"discharge_a": "i", "discharge_share": 0.04}
    held = {"limit": {"voltage_v": volts}}
    phases = {
        "constant_current": {"constant_current": {"current_a": "i"}},
        "constant_voltage": {"constant_voltage": {"voltage_v": volts, "max_current_a": "i"}},
        "constant_power": {"constant_power": {"power_w": 0.5 * rate * battery(cell).capacity_in_use_ah * volts}} | held,
        "pulse": {"pulse": pulse} | held,
        "reflex": {"reflex": reflex} | held,
        "staged": {"staged": {"currents_a": ["i", "j"], "soc_edges": [0.8005, 0.9]}},
        "rate_switch": {"rate_switch": SENSOR | {"fast_a": "i", "trickle_a": "j", "trip_rate_k_s": 0.01}},
        "controller": {"controller": SENSOR | {"network": NETWORK}},
        "rest": {"rest": {}},
    }
    amperes = rate * battery(cell).capacity_in_use_ah

    def mode(phase):
        used = {knob: value for knob, value in (("i", amperes), ("j", 0.5 * amperes)) if f"'{knob}'" in str(phase)}
        rest = {"wait": {"rest": {}, "until": {"elapsed_s": 2.0}}} if "rest" not in phase else {}
        until = {"until": {"elapsed_s": 25.0}} if rest else {}
        first = {"one": phase | until if "staged" not in phase else phase}
        return Mode(**({"title": "one", "phases": first | rest, "stop": {"elapsed_s": 40.0}} | used))

    return {name: mode(phase) for name, phase in phases.items()}


def assert_same(found, expected):
    """Every number of every table, and the summary, to the last bit."""
    assert repr(found.summary) == repr(expected.summary)
    for name in ("trace", "waveform", "phases", "energy"):
        mine, theirs = getattr(found, name), getattr(expected, name)
        assert list(mine) == list(theirs)
        for column, values in theirs.items():
            assert np.asarray(mine[column]).tobytes() == np.asarray(values).tobytes(), (name, column)


def tasks():
    return [
        Task(battery(cell), suited_mode(mode, cell), BENCH, settings(SUITED[cell][2]), ENGINE)
        for cell in BATTERIES
        for mode in MODES
    ]


@pytest.mark.parametrize("driver", ["edge", "averaged"])
@pytest.mark.parametrize("cell", BATTERIES)
def test_every_waveform_is_the_same_bit_for_bit(cell, driver):
    conditions = settings(0.8, soc_marks=[0.803, 0.801, 0.9], windows=[Window(start_s=10.0, length_s=0.02)])
    engine = EngineSettings(driver=driver)
    asked = [
        Task(battery(cell), mode, supply, conditions, engine)
        for mode in waveforms(cell).values()
        for supply in (BENCH, SUN)
    ]
    for task, found in zip(asked, simulate_many(asked, threads=2), strict=True):
        assert_same(found, simulate(*task))


def test_the_modes_of_the_configuration_are_the_same_whatever_the_order_and_the_threads():
    expected = [simulate(*task) for task in tasks()]
    for threads in (1, 3):
        for found, own in zip(simulate_many(tasks(), threads), expected, strict=True):
            assert_same(found, own)
    for found, own in zip(simulate_many(tasks()[::-1]), expected[::-1], strict=True):
        assert found.summary == own.summary


def test_charges_of_one_mode_that_end_differently_are_told_apart():
    mode = Mode(
        title="goals",
        phases={
            "bulk": {"constant_current": {"current_a": 2.0}, "until": {"voltage_v": 13.2}},
            "hold": {"constant_voltage": {"voltage_v": 13.2, "max_current_a": 2.0}, "until": {"current_a": 1.5}},
        },
        stop={"elapsed_s": 600.0, "soc": 0.9},
    )
    starts = [0.2, 0.4, 0.5, 0.6, 0.7, 0.8, 0.85, 0.89, 0.9 - 1e-10, 0.9 - 1e-8]
    asked = [
        Task(battery("lead_acid_12v7ah"), mode, supply, settings(soc, soc_marks=[0.5, 0.9]), ENGINE)
        for supply in (BENCH, SUN)
        for soc in starts
    ]
    found = simulate_many(asked)
    for one, task in zip(found, asked, strict=True):
        assert_same(one, simulate(*task))
    words = {tuple(row.text for row in one.summary if row.text is not None) for one in found}
    assert len(words) > 5


def scattered(cell, factors):
    """Return a battery with its resistances, time constants, heat capacity and capacity times some factors."""
    tree = battery(cell).model_dump(mode="json")

    def times(value, factor):
        if isinstance(value, float | int):
            return value * factor
        if "polynomial" in value:
            return {"polynomial": [one * factor for one in value["polynomial"]]}
        key = "scale" if "soc" in value else "factor"
        return value | {key: value[key] * factor}

    tree["series_resistance_ohm"] = times(tree["series_resistance_ohm"], factors[0])
    for pair in tree["pairs"].values():
        pair["resistance_ohm"] = times(pair["resistance_ohm"], factors[1])
        pair["time_constant_s"] *= factors[2]
    tree["thermal"]["heat_capacity_j_k"] *= factors[3]
    return Battery.model_validate(tree | {"scaled_to_capacity_ah": tree["capacity_ah"] * factors[4]})


FACTORS = st.tuples(*[st.floats(0.6, 1.6)] * 5)
ONE = st.tuples(
    st.sampled_from(BATTERIES), st.sampled_from(sorted(waveforms("lfp_8ah"))), st.sampled_from([0.5, 7.0, 90.0]),
    FACTORS, st.floats(0.3, 0.85), st.floats(5.0, 40.0), st.booleans(), st.sampled_from(["auto", "edge", "averaged"]),
)  # fmt: skip


def charge_or_refusal(run):
    try:
        return run(), ""
    except (UserError, EngineError) as error:
        return None, f"{type(error).__name__}: {error}"


@limits(max_examples=15, deadline=None)
@given(
    drawn=st.lists(ONE, min_size=1, max_size=12), block=st.sampled_from([1, 3, 128]), threads=st.sampled_from([1, 2])
)
def test_random_populations_are_the_same_bit_for_bit_and_refused_alike(drawn, block, threads):
    asked = []
    for cell, name, hz, factors, soc, ambient_c, sunny, driver in drawn:
        conditions = ChargeSettings(initial_soc=soc, ambient_c=ambient_c, sample_interval_s=7.0, soc_marks=[soc + 1e-3])
        supply = SUN if sunny else BENCH
        engine = EngineSettings(driver=driver)
        asked.append(Task(scattered(cell, factors), waveforms(cell, hz)[name], supply, conditions, engine))
    expected = [charge_or_refusal(lambda task=task: simulate(*task)) for task in asked]
    first = next((told for _, told in expected if told), "")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(population, "BLOCK", block)
        patch.setattr(population, "FEW", 1)
        found, told = charge_or_refusal(lambda: simulate_many(asked, threads))
    assert told == first
    for mine, (theirs, _) in zip(found or [], expected, strict=bool(found)):
        assert_same(mine, theirs)


def test_the_batteries_of_a_population_are_compiled_as_each_by_itself():
    own = [battery(cell) for cell in BATTERIES] + [scattered(cell, (0.9, 1.1, 1.2, 0.8, 1.7)) for cell in BATTERIES]
    room = new_room(len(own))
    for order in (own, own[::-1], own[3:]):
        for compiled, one in zip(compile_cells(order, room), order, strict=True):
            alone = compile_cell(one)
            tables = {"pieces": ("knots", "coefficients"), "factor_pieces": ("factor_knots_k", "factor_coefficients")}
            for name in set(alone.dtype.names) - {name for names in tables.values() for name in names}:
                assert np.asarray(compiled[name]).tobytes() == np.asarray(alone[name]).tobytes(), name
            # What a table of another battery left behind the last piece is not read.
            for counts, names in tables.items():
                for row, pieces in enumerate(alone[counts]):
                    # The last knot of factors ends their last piece.
                    for name, reach in zip(names, (pieces + (pieces > 0 and "factor" in counts), pieces), strict=True):
                        assert compiled[name][row, :reach].tobytes() == alone[name][row, :reach].tobytes()


def random_battery(random):
    """Return a shipped battery with random tables in it, its potential rising or falling a little; none if refused."""

    def table(least, most):
        grid = sorted({0, *random.integers(2, 99, random.integers(1, 10)).tolist(), 100})
        shares = random.integers(0, 51, len(grid)) / 50
        return {"soc": [soc / 100 for soc in grid], "value": (least + (most - least) * shares).tolist()}

    potential = table(3.0, random.choice([3.01, 3.02, 3.1, 4.0]))
    if random.random() < 0.7:
        potential["value"].sort()
    if random.random() < 0.5:
        potential["value"][random.integers(len(potential["value"]))] *= 1.0 - 0.012 * random.random()
    chosen = {"open_circuit_voltage_v": potential}
    if random.random() < 0.3:
        chosen["entropic_coefficient_v_k"] = table(-2e-4, 2e-4)
    if random.random() < 0.5:
        chosen["series_resistance_ohm"] = table(0.0, 0.01)
    try:
        return Battery.model_validate(battery(random.choice(BATTERIES)).model_dump(mode="json") | chosen)
    except ValueError:
        return None


def test_curves_called_sound_pass_the_check_of_each_by_itself():
    random, seen = np.random.default_rng(5), []
    for _ in range(250):
        one, celsius = random_battery(random), random.choice([25.0, 5.0, 45.0])
        low, stop = 0.6 * random.random(), 0.7 + 0.3 * random.random()
        if one is None:
            continue
        asked = np.array([[low, low, min(stop, 1.0 if one.fills else NEVER_FULL), celsius]])
        found = np.empty((1, FOUND))
        look(compile_cells([one]), np.zeros(1, dtype=np.int64), asked, HELD, found)
        try:
            check_range("battery", one, low, stop, celsius)
            check_resistance("phases.one", one, low, stop)
            passes = True
        except UserError:
            passes = False
        seen.append((passes, bool(found[0, SOUND])))
        rounding = 1.0 + 1e-12
        assert resting_voltage_v(one, low, celsius) <= found[0, START_V] * rounding
        assert resting_voltage_v(one, 0.01, celsius) <= found[0, EMPTY_V] * rounding
        assert resting_voltage_v(one, 0.99, celsius) >= found[0, FULL_V] / rounding
        assert resting_voltage_v(one, 0.99, 25.0) >= found[0, WARM_FULL_V] / rounding
    assert (False, True) not in seen
    assert min(seen.count((True, True)), seen.count((False, False))) > 20


@pytest.mark.parametrize("cell", BATTERIES)
def test_nothing_is_in_doubt_about_a_shipped_battery(cell):
    one = battery(cell)
    found = np.empty((1, FOUND))
    asked = np.array([[0.2, 0.2, 1.0 if one.fills else NEVER_FULL, 25.0]])
    look(compile_cells([one]), np.zeros(1, dtype=np.int64), asked, HELD, found)
    assert found[0, SOUND] == 1.0


def test_a_mode_that_does_not_fit_is_named():
    bad = Mode(**(load("modes/cc_cv.yaml") | {"voltage_v": 11.0}))
    one = tasks()[0]
    with pytest.raises(UserError, match="11 V does not charge"):
        simulate_many([*tasks(), one._replace(battery=battery("lead_acid_12v7ah"), mode=bad)])


def test_the_first_failure_counts_whatever_kind_it_is():
    good = [task for task in tasks() if task.battery.name == "lead_acid_12v7ah"]
    low = Mode(**(load("modes/cc_cv.yaml") | {"voltage_v": 11.0}))
    refused, exhausted = good[0]._replace(mode=low), good[1]._replace(engine=EngineSettings(maximum_steps=5))
    for wrong in ([refused, exhausted], [exhausted, refused]):
        with pytest.raises((UserError, EngineError)) as alone:
            simulate(*wrong[0])
        for many in (wrong, [*good, *good, *wrong, *good]):
            with pytest.raises(type(alone.value)) as together:
                simulate_many(many)
            assert str(together.value) == str(alone.value)
    with pytest.raises(EngineError, match="the steps are used up"):
        try_many([*good, refused, *good, exhausted])


def test_what_does_not_fit_stands_in_its_place():
    good = [task for task in tasks() if task.battery.name == "lead_acid_12v7ah"]
    low = Mode(**(load("modes/cc_cv.yaml") | {"voltage_v": 11.0}))
    for many in ([good[0], good[0]._replace(mode=low), good[1]], [*good, good[0]._replace(mode=low), *good, *good]):
        for task, found in zip(many, try_many(many), strict=True):
            if task.mode == low:
                assert isinstance(found, UserError)
                assert "11 V does not charge" in str(found)
            else:
                assert_same(found, simulate(*task))


def test_whoever_of_a_group_does_not_fit_is_found_and_told_what_it_would_be_alone():
    mode = suited_mode("cc_cv", "lfp_8ah")
    stopped = mode.model_copy(update={"stop": mode.stop.model_copy(update={"soc": 0.81})})
    asked = [
        Task(battery("lfp_8ah"), stopped, BENCH, settings(soc), ENGINE)
        for soc in (0.5, 0.8, 0.805, 0.82, 0.4, 0.6, 0.7, 0.9, 0.3, 0.809, 0.81)
    ]
    for task, found in zip(asked, try_many(asked), strict=True):
        if task.settings.initial_soc < 0.81:
            assert_same(found, simulate(*task))
            continue
        with pytest.raises(UserError, match=r"stop.soc: 0.81 is not above initial_soc") as alone:
            simulate(*task)
        assert str(found) == str(alone.value)


def test_an_open_reference_is_refused_as_alone():
    one = tasks()[0]
    open_mode = Mode.model_validate(one.mode.model_dump() | {"voltage_v": {"from": "search", "value": "voltage_v"}})
    with pytest.raises(UserError, match="still to be found by 'search'"):
        simulate_many([one, one._replace(mode=open_mode)])
    with pytest.raises(UserError, match="still to be found by 'search'"):
        simulate_many([*tasks(), one._replace(mode=open_mode)])
    # It says nothing of whether the charge is possible.
    for others in ([], tasks()):
        with pytest.raises(UserError, match="still to be found by 'search'"):
            try_many([*others, one._replace(mode=open_mode)])


def test_one_sheet_is_looked_at_once_for_a_population(monkeypatch):
    from pipeline.charge import soundness

    looked = []
    real = soundness.check_sheet
    monkeypatch.setattr(soundness, "check_sheet", lambda mode, facts: looked.append(mode) or real(mode, facts))
    one = tasks()[0]
    names = [scattered("lead_acid_12v7ah", (1.0 + n / 100, 1.0, 1.0, 1.0, 1.0)) for n in range(40)]
    mode = suited_mode("cc_cv", "lead_acid_12v7ah")
    simulate_many([one._replace(battery=own, mode=mode.model_copy()) for own in names])
    assert len(looked) == 2


def test_a_supply_that_may_not_be_written_needs_no_kernel_of_its_own():
    mode = waveforms("lead_acid_12v7ah")["pulse"]
    simulate(battery("lead_acid_12v7ah"), mode, SUN, settings(0.5), ENGINE)
    before = len(drive.run_program.overloads)
    frozen = Supply(*(part.copy() for part in SUN))
    for part in frozen:
        part.setflags(write=False)
    charged = simulate(battery("lead_acid_12v7ah"), mode, frozen, settings(0.5), ENGINE)
    assert len(drive.run_program.overloads) == before
    assert_same(charged, simulate(battery("lead_acid_12v7ah"), mode, SUN, settings(0.5), ENGINE))
