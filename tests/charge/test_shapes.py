"""What anyone who has charged these batteries expects to see."""

import numpy as np
import pytest

from pipeline.charge.records import Mode
from tests.charge.samples import battery, charge, load, settings, values


def test_lead_acid_by_constant_current_and_voltage():
    conditions = settings(0.2, soc_marks=[0.95, 0.99])
    result = charge(battery("lead_acid_12v7ah"), Mode(**load("modes/cc_cv.yaml")), conditions)
    found, trace = values(result), result.trace
    held = np.argmax(trace["voltage_limited_share"] > 0)
    assert trace["Test Time / s"][held] / 3600 == pytest.approx(2.1, abs=0.05)
    assert trace["soc"][held] == pytest.approx(0.83, abs=0.01)
    assert found["time_to_soc_0.95_s"] < 3 * 3600
    assert found["time_to_soc_0.99_s"] < 4 * 3600
    assert found["peak_temperature_rise_k"] == pytest.approx(5.0, abs=0.5)


@pytest.mark.parametrize(("voltage", "low", "high"), [(14.4, 0.008, 0.013), (13.65, 0.002, 0.004)])
def test_the_current_at_the_end_is_the_side_reaction_alone(voltage, low, high):
    phases = {"float": {"constant_voltage": {"voltage_v": voltage, "max_current_a": 2.1}}}
    mode = Mode(title="Float", phases=phases, stop={"elapsed_s": 7 * 86400})
    result = charge(battery("lead_acid_12v7ah"), mode, settings(0.9, sample_interval_s=3600))
    trace = result.trace
    assert low < trace["Current / A"][-1] < high
    assert trace["side_current_a"][-1] == pytest.approx(trace["Current / A"][-1], rel=1e-9)
    assert abs(values(result)["energy_balance_residual"]) < 1e-9


def aaa_cells():
    """Return the pair of cells as the reference has them: smaller, and so in worse contact with the air."""
    one = battery("nicd_2s_600mah")
    thermal = one.thermal.model_copy(update={"heat_capacity_j_k": 41.0, "resistance_k_w": 50.0})
    return one.model_copy(update={"thermal": thermal})


@pytest.mark.parametrize(("rate", "peak_v", "drop_s", "warm_c"), [(4, 3.57, 930, 37.5), (8, 3.73, 470, 46.2)])
def test_nickel_cadmium_knee_and_drop(rate, peak_v, drop_s, warm_c):
    mode = Mode(
        title="Fast",
        current_c_rate=rate,
        phases={"charge": {"constant_current": {}}},
        stop={"elapsed_s": 1.3 * drop_s},
    )
    trace = charge(aaa_cells(), mode, settings(0.02, ambient_c=30, sample_interval_s=1)).trace
    voltage, temperature = trace["Voltage / V"], trace["Surface Temperature / degC"]
    top = int(np.argmax(voltage))
    fallen = top + int(np.argmax(voltage[top:] < voltage[top] - 0.01))
    assert voltage[top] == pytest.approx(peak_v, abs=0.02)
    assert trace["Test Time / s"][fallen] == pytest.approx(drop_s, abs=5)
    assert temperature[fallen] == pytest.approx(warm_c, abs=1)
    slope = np.diff(temperature)
    assert slope[fallen] > 5 * abs(slope[: top // 2]).max()
    assert np.all(trace["soc"] < 1.0)


def test_nickel_cadmium_cools_at_one_c():
    mode = Mode(title="Slow", current_c_rate=1, phases={"charge": {"constant_current": {}}}, stop={"elapsed_s": 3600})
    trace = charge(aaa_cells(), mode, settings(0.02, ambient_c=30)).trace
    assert trace["Surface Temperature / degC"].min() == pytest.approx(27.0, abs=0.3)


def test_a_full_nickel_cadmium_cell_takes_eight_c():
    mode = Mode(title="Over", current_c_rate=8, phases={"charge": {"constant_current": {}}}, stop={"elapsed_s": 900})
    result = charge(battery("nicd_2s_600mah"), mode, settings(0.9999, ambient_c=30))
    assert 0.0 < 1.0 - values(result)["end_soc"] < 1e-3
    assert np.isfinite(result.trace["Voltage / V"]).all()
    assert abs(values(result)["energy_balance_residual"]) < 1e-9


def test_lithium_iron_phosphate_by_the_printed_currents():
    currents = [39.2, 36.6, 29.8, 14.3, 12.9, 11.8, 8.5, 9.7]
    phases = {"stage": {"staged": {"currents_a": currents, "soc_edges": [0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9]}}}
    mode = Mode(title="Stages", phases=phases, stop={"elapsed_s": 4000})
    result = charge(battery("lfp_8ah"), mode, settings(0.1))
    assert values(result)["end_time_s"] == pytest.approx(sum(2880 / current for current in currents), abs=1e-6)
    rises = np.array(result.phases["end_temperature_c"]) - 25
    assert rises == pytest.approx([1.1, 2.4, 3.5, 3.8, 3.9, 4.0, 3.7, 3.6], abs=0.15)
    assert result.trace["voltage_max_v"].max() < 3.65
