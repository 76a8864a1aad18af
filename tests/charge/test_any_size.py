"""What is given per cell or capacity means the same on every battery, in knobs, limits, phases and stops."""

import math

import pytest
from pydantic import ValidationError

from pipeline.cell.records import Battery
from pipeline.charge.checks import check
from pipeline.charge.comparison import with_stops
from pipeline.charge.protocol import resolve
from pipeline.charge.records import Mode
from pipeline.errors import UserError
from tests.charge.samples import charge, settings, values
from tests.charge.test_exact import PLAIN

TAU_S = 360.0  # 3600 s/h x 1 Ah x 0.05 ohm / 0.5 V: the current of a held voltage falls as exp(-t / TAU_S)
START_A = (1.8 - 1.55) / 0.05
SIZES = [(1, 1.0), (2, 1.0), (24, 1.0), (2, 200.0)]


def plain(cells, capacity_ah):
    return Battery(**PLAIN | {"cells_in_series": cells, "scaled_to_capacity_ah": capacity_ah})


def held(**ends):
    """Return a voltage held from the first instant; the maximum current is above all that is drawn."""
    phase = {"constant_voltage": {}} | {key: end for key, end in ends.items() if key == "until"}
    stop = {"elapsed_s": 3000.0} | ends.get("stop", {})
    return Mode(title="Held", voltage_v_cell=1.8, max_current_c_rate=20.0, phases={"hold": phase}, stop=stop)


@pytest.mark.parametrize(("cells", "capacity_ah"), SIZES)
@pytest.mark.parametrize("place", ["until", "stop"])
@pytest.mark.parametrize("spelling", ["current_a", "current_c_rate"])
def test_a_tail_current_ends_phase_and_charge(cells, capacity_ah, place, spelling):
    rate = 0.05
    end = {spelling: rate * capacity_ah if spelling == "current_a" else rate}
    found = values(charge(plain(cells, capacity_ah), held(**{place: end}), settings(0.1)))
    assert found["end_time_s"] == pytest.approx(TAU_S * math.log(START_A / rate), abs=1e-5)
    assert found["end_reason"] == f"{'stop: ' * (place == 'stop')}current {rate * capacity_ah:g} A"
    assert not found["missed"]


@pytest.mark.parametrize(("cells", "capacity_ah"), SIZES)
def test_a_voltage_per_cell_is_that_of_the_battery_over_its_cells(cells, capacity_ah):
    phases = {"bulk": {"constant_current": {}, "until": {"voltage_v_cell": 1.7}}}
    mode = Mode(title="Bulk", current_c_rate=1.0, phases=phases, stop={"elapsed_s": 3000.0})
    found = values(charge(plain(cells, capacity_ah), mode, settings(0.1)))
    # 2 - 0.5 (1 - SOC) + 0.05 x 1 = 1.7 V
    assert found["end_soc"] == pytest.approx(0.3, abs=1e-9)
    assert found["end_reason"] == f"voltage {1.7 * cells:g} V"


def test_a_limit_may_be_given_per_cell_and_name_a_knob():
    phases = {"a": {"constant_current": {"current_a": 2.0}, "limit": {"voltage_v_cell": "most"}}}
    for knob, value in (("most", 1.8), ("most_v_cell", 1.8)):
        sheet = Mode(title="Limited", phases=phases, stop={"elapsed_s": 10.0}, **{knob: value})
        phase = sheet.phases["a"].limit
        wanted = phase if knob == "most" else phase.model_copy(update={"voltage_v_cell": None, "voltage_v": "most_v"})
        sheet = sheet.model_copy(update={"phases": {"a": sheet.phases["a"].model_copy(update={"limit": wanted})}})
        assert resolve(sheet, 1.0, cells=12).courses[0].limit_v == pytest.approx(12 * 1.8)


@pytest.mark.parametrize("spelling", [{"current_a": 0.1}, {"current_c_rate": 0.1}])
def test_a_comparison_keeps_a_stop_by_its_meaning(spelling):
    mode = held(stop=spelling | {"soc": 0.9})
    assert with_stops(mode, ["current_a"]).stop.given == {"elapsed_s", "current_a"}
    assert with_stops(mode, ["soc"]).stop.given == {"elapsed_s", "soc"}


def test_one_quantity_is_given_once():
    with pytest.raises(ValidationError, match="current_a and current_c_rate are one quantity"):
        held(until={"current_a": 0.1, "current_c_rate": 0.1})
    twice = Mode(**held().model_dump() | {"voltage_v": 3.6})
    with pytest.raises(UserError, match="voltage_v_cell: no phase uses this knob"):
        check(plain(2, 1.0), twice, settings(0.1))


def test_a_current_that_nothing_lets_fall_is_refused():
    phases = {"bulk": {"constant_current": {"current_a": 1.0}, "until": {"current_c_rate": 0.05}}}
    mode = Mode(title="Bulk", phases=phases, stop={"elapsed_s": 3000.0})
    with pytest.raises(UserError, match=r"phases.bulk.until.current_a: the current falls where a voltage is held"):
        check(plain(2, 1.0), mode, settings(0.1))


def test_a_tail_above_the_current_is_refused_with_its_amperes():
    mode = held(stop={"current_c_rate": 25.0})
    with pytest.raises(UserError, match=r"stop.current_a: 50 A, but the current is never above 40 A"):
        check(plain(2, 2.0), mode, settings(0.1))
