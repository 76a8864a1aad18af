"""Comparisons at the same current: the reference sets that of every mode, whatever capacity a sheet was for."""

import pytest

from pipeline.charge.comparison import Level, compared, peak_current_a, scale
from pipeline.charge.records import Mode
from pipeline.charge.waveforms import WAVEFORMS
from pipeline.errors import UserError
from tests.charge.samples import battery, charge, load, settings, values

LARGE = battery("lead_acid_12v18ah")
OWN = Mode(**(load("modes/cc_cv.yaml") | {"max_current_a": 4.0}))
PEAK, MEAN = Level(OWN, mean=False), Level(OWN, mean=True)
PHASES = {
    "constant_current": {"current_c_rate": 0.1},
    "constant_voltage": {"max_current_a": 1.5, "voltage_v": 14.4},
    "pulse": {"charge_a": 2.1, "charge_share": 0.9, "frequency_hz": 5.0},
    "reflex": {
        "charge_c_rate": 0.2, "charge_share": 0.9, "frequency_hz": 5.0, "discharge_a": 0.5, "discharge_share": 0.05
    },
    "rate_switch": {"fast_a": 2.0, "trickle_a": 0.1, "trip_rate_k_s": 1.0, "sample_interval_s": 1.0},
}  # fmt: skip


def mode(waveform, phase=None, **knobs):
    limit = {} if waveform == "constant_voltage" else {"limit": {"voltage_v": 14.4}}
    return Mode(title=waveform, phases={"only": {waveform: phase or {}} | limit}, stop={"elapsed_s": 20}, **knobs)


def highest_a(sheet, cell=LARGE):
    return max(charge(cell, sheet, settings(0.3, sample_interval_s=1.0)).trace["current_max_a"])


@pytest.mark.parametrize("as_knobs", [True, False])
@pytest.mark.parametrize("waveform", PHASES)
def test_every_waveform_charges_with_the_peak_of_the_reference(waveform, as_knobs):
    """A user's battery of 18 Ah beside sheets for 7 Ah: 4.0 A were compared with 2.1 A."""
    numbers = PHASES[waveform]
    if as_knobs:
        sheet = mode(waveform, **numbers)
    else:
        capacity = LARGE.capacity_in_use_ah
        amperes = {
            name.replace("_c_rate", "_a"): capacity * value if name.endswith("_c_rate") else value
            for name, value in numbers.items()
        }
        sheet = mode(waveform, amperes)
    made = compared(sheet, PEAK, LARGE)
    assert highest_a(made) == pytest.approx(4.0, rel=1e-9)
    assert scale(sheet, PEAK, LARGE) == pytest.approx(4.0 / peak_current_a(sheet, LARGE))


def test_stages_keep_their_proportions():
    sheet = mode("staged", {"currents_a": ["first_a", 1.0], "soc_edges": [0.5, 0.9]}, first_c_rate=0.1)
    made = compared(sheet, PEAK, LARGE)
    assert made.knobs["first_c_rate"] * 18.0 == pytest.approx(4.0)
    assert made.phases["only"].waveform.currents_a[1] == pytest.approx(1.0 * 4.0 / 1.8)


@pytest.mark.parametrize("name", ["cv_pulse", "cv_reflex"])
def test_bulk_pulses_and_discharge_are_scaled_together(name):
    sheet = Mode(**load(f"modes/{name}.yaml"))
    made = compared(sheet, PEAK, LARGE)
    assert (made.knobs["max_current_a"], made.knobs["charge_a"]) == pytest.approx((4.0, 4.0))
    assert made.knobs.get("discharge_a", 0.5 * 4.0 / 2.1) == pytest.approx(0.5 * 4.0 / 2.1)
    assert made.stop == sheet.stop


def test_a_mode_at_that_peak_already_comes_back_as_it_is():
    sheet = Mode(**load("modes/cv_reflex.yaml"))
    level = Level(Mode(**load("modes/cc_cv.yaml")), mean=False)
    assert compared(sheet, level, LARGE) is sheet


@pytest.mark.parametrize("rate", [True, False])
def test_the_same_mean_sets_the_bulk_too_and_knows_the_capacity(rate):
    sheet = load("modes/cv_reflex.yaml")
    if rate:
        sheet["discharge_c_rate"] = sheet.pop("discharge_a") / 18.0
    made = compared(Mode(**sheet), MEAN, LARGE)
    assert made.knobs["max_current_a"] == pytest.approx(4.0)
    knobs = made.knobs
    discharge_a = 18.0 * knobs["discharge_c_rate"] if rate else knobs["discharge_a"]
    mean_a = knobs["charge_a"] * knobs["charge_share"] - discharge_a * knobs["discharge_share"]
    assert mean_a == pytest.approx(4.0, rel=1e-12)
    pulses = {"phases": {"reflex": made.phases["reflex"].model_dump()}, "stop": {"elapsed_s": 10}}
    kept = {name: value for name, value in knobs.items() if name not in ("max_current_a", "voltage_v")}
    free = Mode(title="free", **(pulses | kept | {"voltage_v": 20.0}))
    assert values(charge(LARGE, free, settings(0.3)))["mean_current_a"] == pytest.approx(4.0, rel=1e-9)


def test_a_current_that_is_decided_as_it_runs_is_left():
    network = {"low": [0.0, -1.0], "high": [50.0, 1.0], "widths": [1.0, 1.0], "gradient_seconds": 60.0}
    network |= {"centres": [[25.0, 0.0]], "outputs_c_rate": [0.5]}
    sheet = mode("controller", {"network": network, "sample_interval_s": 1.0})
    assert compared(sheet, PEAK, LARGE) is sheet


def test_a_current_still_to_be_found_is_refused():
    sheet = mode("constant_current", current_a={"from": "staging", "value": "constant_same_time_a"})
    with pytest.raises(UserError, match=r"phases\.only\.current_a: still to be found"):
        compared(sheet, PEAK, LARGE)
    with pytest.raises(UserError, match="none has a constant current that is known"):
        compared(OWN, Level(mode("rest"), mean=False), LARGE)


def test_no_waveform_is_forgotten():
    """Those whose current is a parameter are above; the others have none, or decide it as they run."""
    others = {"staged", "controller", "rest", "constant_power"}
    assert set(WAVEFORMS) <= {*PHASES, *others}
