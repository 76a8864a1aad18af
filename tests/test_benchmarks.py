"""The benchmarks' arithmetic: ratios by round, what fails, peers that are missing; and their models against scipy."""

from __future__ import annotations

import json
import math
import re
from itertools import count

import numpy as np
import pytest
from benchmarks import __main__ as runner
from benchmarks import bound, common_model, counting, results
from benchmarks.common_model import End
from benchmarks.peers import ngspice, pybamm_thevenin, runge_kutta, scipy_model
from benchmarks.protocol import Figure, Row, Times, compared, interleaved, missing, repeated
from benchmarks.sheets import reflex

SECONDS, SOC = 10 / 90.0, 0.3


def times(walls: list[float]) -> Times:
    """Return times of which the processor spent half."""
    return Times(walls, [0.5 * wall for wall in walls])


def ticking(step_s: float = 0.004):
    ticks = count()
    return lambda: step_s * next(ticks)


def test_a_ratio_is_the_median_of_the_rounds_not_of_the_times():
    row = compared("a", "b", times([1.0, 2.0, 4.0]), times([10.0, 10.0, 100.0]))
    assert (row.ratio, row.lowest, row.highest) == (10.0, 5.0, 25.0)
    assert (row.ours_s, row.peer_s, row.rounds) == (2.0, 10.0, 3)


def test_the_processors_time_stands_beside_and_decides_nothing():
    row = compared("a", "b", Times([1.0] * 3, [1.0] * 3), Times([30.0] * 3, [5.0] * 3), Figure(20.0))
    assert (row.ratio, row.processor_ratio, row.status) == (30.0, 5.0, "holds")


def test_times_scale_with_the_work():
    assert Times([1.0, 2.0], [3.0, 4.0]).scaled(2.0) == Times([2.0, 4.0], [6.0, 8.0])


def test_a_cost_is_ours_over_the_peers():
    row = compared("a", "b", times([3.0, 3.0, 6.0]), times([1.0, 2.0, 2.0]), Figure(3.5, "at most"))
    assert (row.ratio, row.bound, row.status) == (3.0, "at most", "holds")


@pytest.mark.parametrize(
    ("ratio", "status"),
    [(2500.0, "holds"), (2000.0, "holds"), (1999.0, "above half"), (1000.0, "above half"), (999.0, "fails")],
)
def test_only_below_half_its_figure_a_row_fails(ratio, status):
    assert compared("a", "b", times([1.0] * 3), times([ratio] * 3), Figure(2000.0)).status == status


@pytest.mark.parametrize(("ratio", "status"), [(1.5, "holds"), (3.0, "above half"), (3.1, "fails")])
def test_a_cost_fails_above_twice_its_figure(ratio, status):
    assert compared("a", "b", times([ratio] * 3), times([1.0] * 3), Figure(1.5, "at most")).status == status


@pytest.mark.parametrize(("found", "status"), [(1e-7, "holds"), (1e-5, "fails"), (math.nan, "fails"), (None, "fails")])
def test_a_fast_row_with_a_large_error_fails(found, status):
    row = compared("a", "b", times([1.0] * 3), times([9.0] * 3), Figure(2.0), ours_error=found, error_asked=1e-6)
    assert row.status == status


def test_without_a_figure_nothing_fails():
    assert compared("a", "b", times([9.0] * 3), times([1.0] * 3)).status == "measured"


def test_rounds_interleave():
    order: list[str] = []
    walls = interleaved({name: lambda name=name: order.append(name) for name in "abc"}, 3, 0.001, ticking())
    assert order == list("abc" * 3)
    assert {name: len(times.wall_s) for name, times in walls.items()} == {"a": 3, "b": 3, "c": 3}
    with pytest.raises(ValueError, match="at least 3"):
        interleaved({"a": lambda: None}, 2)


def test_short_runs_repeat_until_the_stretch_is_long_enough():
    calls: list[int] = []
    # The clock goes 4 ms at every look: five runs pass 20 ms.
    wall_s, _ = repeated(lambda: calls.append(1), 0.02, ticking())
    assert wall_s == pytest.approx(0.004)
    assert len(calls) == 5
    calls.clear()
    repeated(lambda: calls.append(1), 0.02, ticking(0.5))
    assert len(calls) == 1


class Subject:
    """A benchmark that measures nothing."""

    PACKAGES = ("numba", "no-such-package")

    def __init__(self, *rows: Row):
        self.listed = list(rows)

    def rows(self) -> list[Row]:
        return self.listed


@pytest.fixture
def bench(monkeypatch, tmp_path):
    modules: dict[str, Subject] = {}
    monkeypatch.setattr(runner.importlib, "import_module", lambda name: modules[name.removeprefix("benchmarks.")])
    monkeypatch.setattr(results, "FOLDER", tmp_path)
    return modules


def test_every_row_runs_before_a_failing_one_ends_it(bench, tmp_path, capsys):
    slow = compared("slow work", "some peer", times([1.0] * 3), times([1.0] * 3), Figure(10.0))
    bench["edge"] = Subject(slow, missing("edge", "absent", Figure(3.0)))
    bench["switched"] = Subject(
        compared("other", "peer", times([1.0] * 3), times([20.0] * 3), Figure(10.0), ours_error=0.0)
    )
    assert runner.main(["edge", "switched"]) == 1
    said = capsys.readouterr()
    assert said.err.strip() == "FAILS: slow work vs some peer"
    assert "edge vs absent: not installed" in said.out
    written = json.loads((tmp_path / "switched.json").read_text())
    assert written[0]["ratio_median"] == 20.0
    assert written[0]["status"] == "holds"
    assert "no-such-package" not in written[0]["versions"]


def test_a_missing_peer_does_not_fail(bench, tmp_path):
    bench["edge"] = Subject(missing("edge", "absent", Figure(3.0)))
    assert runner.main(["edge"]) == 0
    row = json.loads((tmp_path / "edge.json").read_text())[0]
    assert (row["status"], row["ratio_median"]) == ("not installed", None)
    assert "| not installed |" in results.table(["edge"])


def test_an_unknown_name_is_refused(bench, capsys):
    assert runner.main(["egde"]) == 2
    assert "edge" in capsys.readouterr().err


def test_the_table_replaces_what_is_between_its_markers():
    text = f"before\n{results.BEGIN}\nold\n{results.END}\nafter"
    assert results.put(text, "| new |") == f"before\n{results.BEGIN}\n| new |\n{results.END}\nafter"
    with pytest.raises(ValueError, match="benchmarks: begin"):
        results.put("no markers", "| new |")


def test_results_on_file_name_no_folder_and_no_host():
    files = sorted(results.FOLDER.glob("*.json"))
    assert files
    for file in files:
        for row in json.loads(file.read_text()):
            assert not re.search(r'(^|[\s"])/\w', json.dumps(row))
            assert set(row["machine"]) == {"processor", "cores", "system", "load"}


@pytest.fixture(scope="module")
def pulsed():
    battery, mode = common_model.battery(), reflex(SECONDS)
    return battery, mode, common_model.model(battery), common_model.pulses(mode, SECONDS, SOC)


def test_the_exact_solution_is_that_of_a_tight_solver(pulsed):
    _, _, m, p = pulsed
    expected, found = scipy_model.build(m, p, "DOP853", 1e-12)(), common_model.exact(m, p)
    assert found[:3] == pytest.approx(expected[:3], rel=1e-11)
    assert found.temperature_k - m.ambient_k == pytest.approx(expected.temperature_k - m.ambient_k, rel=1e-9)
    assert found.energy_j == pytest.approx(expected.energy_j, rel=1e-11)


def test_what_the_pairs_store_is_heat_only_where_it_is_asked_for(pulsed):
    _, _, m, p = pulsed
    own, stored = (common_model.exact(m, p, heat) for heat in (False, True))
    assert own[:3] == stored[:3]
    kept = sum(
        0.5 * pair.time_constant_s / pair.resistance_ohm * v**2
        for pair, v in ((m.fast, own.fast_v), (m.slow, own.slow_v))
    )
    # Little of it leaves in a ninth of a second.
    assert m.heat_capacity_j_k * (stored.temperature_k - own.temperature_k) == pytest.approx(kept, rel=1e-3)


def test_the_loop_is_of_fourth_order(pulsed):
    _, _, m, p = pulsed
    expected = common_model.exact(m, p)
    # Both halve the steps of every part of a period.
    errors = [common_model.error(runge_kutta.build(m, p, steps)(), expected) for steps in (36, 72)]
    assert math.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.3)


def test_errors_are_relative_and_the_largest_counts():
    expected = End(0.5, 0.02, 0.03, 300.0)
    assert common_model.error(End(0.5, 0.0202, 0.03, 300.0), expected) == pytest.approx(0.01)
    assert common_model.temperature_error(End(0.5, 0.02, 0.03, 301.0), expected, 290.0) == pytest.approx(0.1)


def test_every_edge_is_a_breakpoint(pulsed):
    p = pulsed[3]
    edges = pybamm_thevenin.edges(p)
    lengths = np.tile([length for _, length in p.segments], p.periods)
    assert np.diff(edges) == pytest.approx(lengths, rel=1e-9)


def test_the_deck_keeps_the_charge_of_a_pulse():
    numbers = ngspice.pulse(2.0, 0.0, 0.01, 0.02).removeprefix("PULSE(").removesuffix(")").split()
    _, current, start, rise, fall, flat, period = map(float, numbers)
    assert current * (flat + 0.5 * (rise + fall)) == pytest.approx(2.0 * 0.01)
    assert (start + 0.5 * rise, period) == (pytest.approx(0.0, abs=1e-12), 0.02)


@pytest.mark.skipif(not ngspice.installed(), reason="ngspice is not installed")
def test_ngspice_computes_the_same_model(pulsed):
    _, _, m, p = pulsed
    assert common_model.error(ngspice.build(m, p, 1e-4)(), common_model.exact(m, p)) < 1e-4


def test_the_bare_loop_computes_the_common_model(pulsed):
    _, _, m, p = pulsed
    x, fast, slow, warm, energy, *_ = bound.bare(p.periods, *bound.bare_arguments(m, p))
    expected = common_model.exact(m, p)
    assert (1.0 - x, fast, slow, energy) == pytest.approx((*expected[:3], expected.energy_j), rel=1e-11)
    assert warm == pytest.approx(expected.temperature_k - m.ambient_k, rel=1e-6)


def test_numbers_count_what_is_done_to_them_and_know_what_they_wait_for(monkeypatch):
    monkeypatch.setattr(counting.Count, "done", dict.fromkeys(counting.KINDS, 0))
    monkeypatch.setattr(counting.Count, "takes", {"add": 1.0, "multiply": 2.0, "divide": 10.0})
    a, b = counting.Number(3.0), counting.Number(4.0)
    found = (a + b) * np.float64(2.0) - 1.0 / b + np.float64(5.0) * a
    assert float(found) == 3.0 * 2.0 + 4.0 * 2.0 - 0.25 + 15.0
    assert counting.Count.done == {"add": 3, "multiply": 2, "divide": 1, "compare": 0, "function": 0}
    # The division alone takes longest, then the difference and the sum.
    assert found.ready == 12.0
    assert max(a, b) is b
    assert counting.Count.done["compare"] == 1


def test_a_fit_against_pybop_is_told_missing_where_no_python_with_it_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    from benchmarks import own_fit

    monkeypatch.delenv("PYBOP_PYTHON", raising=False)
    assert [row.status for row in own_fit.rows()] == ["not installed"] * 2


def test_our_side_of_the_fit_against_pybop_finds_what_made_the_pulses() -> None:
    from benchmarks import own_fit

    from pipeline.experiments.own_battery.numbers import with_values
    from tests.experiments.own_battery.making import made, steps

    battery = with_values(own_fit._battery(3.3), {own_fit.PATHS["r0"]: 0.03, own_fit.PATHS["tau_s"]: 40.0})
    stretch = made(battery, 0.7, steps((0.0, 30), (-6.0, 10), (0.0, 180), (6.0, 12)), None)
    found = own_fit._ours(stretch, 0.7)
    assert found["values"] == pytest.approx({"r0": 0.03, "r1": 0.02, "tau_s": 40.0}, rel=1e-3)
    assert found["rmse_v"] < 1e-5
