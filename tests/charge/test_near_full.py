"""Where next to nothing is accepted, the main current is all rounding, and the charge must go on all the same."""

import pytest

from pipeline.cell.records import Battery
from pipeline.charge.records import Mode
from tests.charge.samples import battery, charge, settings, values


def test_a_current_that_is_all_rounding_ends_no_charge():
    """Found by sampling the ranges of the estimated parameters; Newton's iteration circled on the last digit."""
    cell = battery("nicd_2s_600mah").model_dump() | {
        "entropic_coefficient_v_k": -0.0004763813257747344,
        "thermoneutral_voltage_v": 1.4700084253189105,
        "series_resistance_ohm": 0.015872501793193224,
        "thermal": {"heat_capacity_j_k": 41.362680466313094, "resistance_k_w": 52.15731356622629},
    }
    cell["side_reaction"] |= {
        "activation_energy_j_mol": 40838.7007068346,
        "recombination_time_constant_s": 116.91113532612407,
    }
    mode = Mode(title="4C", current_c_rate=4.0, phases={"charge": {"constant_current": {}}}, stop={"elapsed_s": 1400.0})
    conditions = settings(0.03870967567889001, ambient_c=30.0, sample_interval_s=1.0)
    found = values(charge(Battery.model_validate(cell), mode, conditions))
    assert found["end_time_s"] == 1400.0
    assert abs(found["energy_balance_residual"]) < 1e-9


@pytest.mark.parametrize("trickle", [0.02, 0.04432309, 0.06, 0.1, 0.3])
@pytest.mark.parametrize("interval", [0.37, 1.0])
def test_a_trickle_goes_on_into_a_full_battery(trickle, interval):
    phases = {"fast": {"constant_current": {"current_a": 4.8}, "until": {"temperature_rate_k_s": 0.2}}}
    phases |= {"trickle": {"constant_current": {"current_a": trickle}}}
    mode = Mode(title="Trickle", phases=phases, stop={"elapsed_s": 3000.0})
    conditions = settings(0.05, ambient_c=30.0, sample_interval_s=interval)
    found = values(charge(battery("nicd_2s_600mah"), mode, conditions))
    assert found["end_time_s"] == 3000.0
    assert abs(found["energy_balance_residual"]) < 1e-9
