"""The acceptance pair under discharge pulses: a discharge depolarises it and does not reverse it; against scipy."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from pipeline.charge.records import EngineSettings, Mode
from pipeline.charge.simulate import BENCH, run
from pipeline.charge.state import DEPTH, RELAXATIONS, TEMPERATURE
from tests.charge.independent import AMBIENT_K, circuit, slopes
from tests.charge.samples import battery, charge, settings, values

LEAD = battery("lead_acid_12v7ah")
BEGIN_S = 10.0
# Charge, its share, discharge, its share: the sheet's own, and one that discharges the pair in every pulse.
COMMON, STRONG = (2.1, 0.9, 0.5, 0.05), (1.0, 0.3, 8.0, 0.3)
SECONDS = {1.0: 12.0, 10.0: 9.0, 90.0: 0.5, 500.0: 0.1}


def clamped(time, state, current, held, signed):
    """Slopes with the pair at zero where it is held, or, not signed, charged by charging currents alone."""
    found = np.array(slopes(time, state, "current", current))
    main = circuit(state, "current", current)[1]
    if held:
        found[3] = 0.0
    elif not signed and main < 0.0:
        found[3] = -state[3] / 30.0
    return found


def empty(_, state, *__):
    return state[3]


empty.terminal, empty.direction = True, -1


def go_on(state, length, current, signed):
    """Integrate a stretch of constant current; from where the pair is discharged it stays so until charged again."""
    # The least above zero, for a pair that rises from there.
    held = state[3] <= 0.0 and circuit(state, "current", current)[1] <= 0.0
    while length > 1e-14:
        found = solve_ivp(
            clamped, (0, length), state, "DOP853", rtol=1e-10, atol=1e-15, args=(current, held, signed),
            events=None if held or current > 0.0 else empty, max_step=0.05,
        )  # fmt: skip
        state, length = found.y[:, -1].copy(), length - found.t[-1]
        if length > 1e-14:
            held, state[3] = True, 0.0
    return state


def reference(soc, shape, frequency_hz, signed=True):
    """Return the state at the end: 1 - SOC, three pair voltages, temperature, energy; and the least of the third."""
    charge_a, charge_share, discharge_a, discharge_share = shape
    state = go_on(np.array([1 - soc, 0, 0, 0, AMBIENT_K, 0]), BEGIN_S, 2.1, signed)
    period, least = 1.0 / frequency_hz, np.inf
    for _ in range(round(SECONDS[frequency_hz] * frequency_hz)):
        state = go_on(state, charge_share * period, charge_a, signed)
        state = go_on(state, discharge_share * period, -discharge_a, signed)
        least = min(least, state[3])
        state = go_on(state, (1.0 - charge_share - discharge_share) * period, 0.0, signed)
    return state, least


def sheet(shape, frequency_hz):
    names = ("charge_a", "charge_share", "discharge_a", "discharge_share")
    phases = {
        "begin": {"constant_current": {"current_a": 2.1}, "until": {"elapsed_s": BEGIN_S}},
        "reflex": {"reflex": dict(zip(names, shape, strict=True)) | {"frequency_hz": frequency_hz}},
    }
    return Mode(title="Reflex", phases=phases, stop={"elapsed_s": BEGIN_S + SECONDS[frequency_hz]})


@pytest.mark.parametrize("shape", [COMMON, STRONG])
@pytest.mark.parametrize("frequency_hz", SECONDS)
@pytest.mark.parametrize("soc", [0.5, 0.75, 0.91, 0.99])
def test_discharge_pulses_depolarise_it_as_scipy_says(soc, frequency_hz, shape):
    expected, least = reference(soc, shape, frequency_hz)
    assert (least == 0.0) == (shape == STRONG and frequency_hz <= 10.0)
    for driver in ("edge", "averaged"):
        engine = EngineSettings(driver=driver, tolerance=1e-9)
        state = run(LEAD, sheet(shape, frequency_hz), BENCH, settings(soc), engine).run["state"]
        found = values(charge(LEAD, sheet(shape, frequency_hz), settings(soc), engine=engine))
        assert state[DEPTH] == pytest.approx(expected[0], abs=1e-9)
        assert state[RELAXATIONS : RELAXATIONS + 3] == pytest.approx(expected[1:4], abs=2e-7)
        assert state[TEMPERATURE] == pytest.approx(expected[4], abs=2e-7)
        energy = (found["energy_in_wh"] - found["energy_out_wh"]) * 3600
        assert energy == pytest.approx(expected[5], rel=2e-7)


def test_a_pair_that_knows_no_discharge_would_be_seen():
    """What the test above would say of max(i, 0) in place of the signed current."""
    signed, other = (reference(0.91, STRONG, 1.0, signed=which)[0] for which in (True, False))
    assert abs(signed[3] - other[3]) > 1000 * 2e-7
    assert abs(signed[5] / other[5] - 1.0) > 100 * 2e-7
