"""The words of a notebook against the engine itself; what they refuse, and that they write nothing."""

from __future__ import annotations

import doctest
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import matplotlib
import numpy as np
import pytest

import pipeline as cp
from pipeline.cell.records import Battery
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.charge.simulate import BENCH, Supply, simulate
from pipeline.commands.run import main
from pipeline.config.compose import compose_tree
from pipeline.config.inheritance import CONF
from pipeline.config.study import study_from
from pipeline.errors import UserError
from pipeline.notebook import named

LEAD = "lead_acid_12v7ah"


@pytest.fixture(autouse=True)
def _empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Work in an empty folder; nothing may be written there."""
    matplotlib.use("Agg")
    monkeypatch.chdir(tmp_path)
    yield
    assert list(tmp_path.iterdir()) == []


def test_importing_the_package_imports_nothing_else() -> None:
    code = "import sys, pipeline; print(sorted(n for n in sys.modules if n.startswith(('numpy', 'pipeline.'))))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_the_room_is_a_room_still_whichever_comes_first() -> None:
    for first in ("import pipeline.charge.simulate", "import pipeline; pipeline.charge"):
        code = f"{first}\nimport pipeline as cp, pipeline.charge.simulate as s\n"
        code += "assert callable(cp.charge); assert cp.charge.simulate is s; print(cp.charge.__name__)"
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
        assert done.stdout.strip() == "pipeline.charge", done.stderr


def test_an_unknown_word_is_no_attribute() -> None:
    with pytest.raises(AttributeError, match="chargee"):
        _ = cp.chargee  # type: ignore[attr-defined]


@pytest.mark.parametrize("module", ["pipeline", "pipeline.notebook.charges", "pipeline.notebook.named",
                                    "pipeline.notebook.outcome"])  # fmt: skip
def test_docstrings_run(module: str) -> None:
    found = doctest.testmod(import_module(module))
    assert found.attempted > 0
    assert found.failed == 0


def test_records_by_name_are_those_of_a_study() -> None:
    study = study_from(compose_tree(["study=solar_reflex"]))
    assert cp.battery(LEAD) == study.battery
    for name in ("cc_cv", "cv_pulse", "cv_reflex"):
        assert cp.mode(name) == study.modes[name]


def test_a_charge_is_the_engines_own() -> None:
    study = study_from(compose_tree(["study=solar_reflex", "modes.cv_reflex.frequency_hz=90"]))
    settings = ChargeSettings(initial_soc=0.7, ambient_c=25.0, soc_marks=[0.5, 0.8, 0.9, 0.95, 0.99])
    expected = simulate(study.battery, study.modes["cv_reflex"], BENCH, settings, EngineSettings())
    for battery, mode in ((LEAD, "cv_reflex"), (study.battery, study.modes["cv_reflex"])):
        found = cp.charge(battery=battery, mode=mode, frequency_hz=90, initial_soc=0.7)  # type: ignore[operator]
        for column, values in expected.trace.items():
            np.testing.assert_array_equal(found.trace[column].to_numpy(), values)
        assert dict(found.summary) == {
            row.quantity: row.value if row.text is None else row.text for row in expected.summary
        }


def test_a_supply_limits() -> None:
    battery, mode = cp.battery(LEAD), cp.mode("cc_cv")
    settings = ChargeSettings(initial_soc=0.7, ambient_c=25.0)
    limited = Supply(np.zeros(1), np.array([10.0]))
    expected = simulate(battery, mode, limited, settings, EngineSettings())
    found = cp.charge(LEAD, "cc_cv", supply_power_w=10.0, initial_soc=0.7)  # type: ignore[operator]
    np.testing.assert_array_equal(found.trace["soc"].to_numpy(), expected.trace["soc"])
    assert found.summary["time_at_supply_limit_s"] > 0


def test_a_current_may_be_given_in_either_unit() -> None:
    in_a = cp.charge(LEAD, "cc_cv", max_current_a=1.4, initial_soc=0.7)  # type: ignore[operator]
    as_rate = cp.charge(LEAD, "cc_cv", max_current_c_rate=0.2, initial_soc=0.7)  # type: ignore[operator]
    assert as_rate.summary["end_time_s"] == pytest.approx(in_a.summary["end_time_s"], rel=1e-9)


def test_a_comparison_has_a_row_a_mode_and_gives_each_its_own_knobs() -> None:
    table = cp.compare(LEAD, ["cc_cv", "cv_reflex"], frequency_hz=90, initial_soc=0.7, max_current_a=1.4)
    for mode, knobs in (("cc_cv", {}), ("cv_reflex", {"frequency_hz": 90})):
        alone = cp.charge(LEAD, mode, initial_soc=0.7, max_current_a=1.4, **knobs)  # type: ignore[operator]
        for name in ("end_time_s", "peak_temperature_c", "end_reason"):
            assert table.loc[mode, name] == alone.summary[name]
            assert table.attrs["units"][name] == alone.summary.units[name]


def test_a_knob_that_is_as_another_moves_with_it_unless_it_is_given() -> None:
    def knobs(**given: float) -> dict[str, object]:
        charge = cp.charge(LEAD, "cv_pulse", frequency_hz=90, initial_soc=0.9, **given)  # type: ignore[operator]
        return dict(charge.mode.knobs)

    assert knobs()["charge_a"] == 2.1
    assert knobs(max_current_a=1.0)["charge_a"] == 1.0
    assert knobs(max_current_a=1.0, charge_a=0.7)["charge_a"] == 0.7
    assert knobs(max_current_a=1.0, charge_c_rate=0.2)["charge_c_rate"] == 0.2
    by_rate = knobs(max_current_c_rate=0.2)
    assert by_rate["charge_c_rate"] == 0.2
    assert "charge_a" not in by_rate


def test_a_sweep_has_a_row_a_combination() -> None:
    batteries = [LEAD, "lead_acid_12v18ah"]
    table = cp.sweep(battery=batteries, mode="cc_cv", max_current_c_rate=[0.1, 0.2], initial_soc=0.7)
    assert list(zip(table["battery"], table["max_current_c_rate"], strict=True)) == [
        (battery, rate) for battery in batteries for rate in (0.1, 0.2)
    ]
    assert table["max_current_c_rate"].dtype == float
    alone = cp.charge("lead_acid_12v18ah", "cc_cv", max_current_c_rate=0.2, initial_soc=0.7)  # type: ignore[operator]
    assert table.iloc[3]["end_time_s"] == alone.summary["end_time_s"]


def test_marks_are_a_list_and_not_swept() -> None:
    table = cp.sweep(LEAD, "cc_cv", initial_soc=[0.6, 0.7], soc_marks=[0.8, 0.95])
    assert len(table) == 2
    assert {"time_to_soc_0.8_s", "time_to_soc_0.95_s"} <= set(table.columns)


def test_a_plot_has_four_axes_and_takes_those_of_another() -> None:
    import matplotlib.pyplot as plt

    one, two = (cp.charge(LEAD, "cc_cv", max_current_a=a, initial_soc=0.8) for a in (1.0, 2.0))  # type: ignore[operator]
    axes = two.plot(one.plot())
    assert [len(each.lines) for each in axes] == [2, 2, 2, 2]
    np.testing.assert_allclose(axes[2].lines[1].get_ydata(), 100.0 * two.trace["soc"])
    plt.close("all")


def test_a_summary_reads_with_units() -> None:
    summary = cp.charge(LEAD, "cc_cv", initial_soc=0.8, soc_marks=[0.5, 0.9]).summary  # type: ignore[operator]
    assert summary["end_reason"] == "stop: soc 0.99"
    assert summary.units["end_time_s"] == "s"
    assert "capacity" not in summary
    assert summary.shown("end_time_s").endswith(" s")
    assert all(name in repr(summary) for name in summary)


MISTAKES: dict[str, tuple[dict[str, Any], tuple[str, ...]]] = {
    "a battery": ({"battery": "lead_acid_12v7"}, ("no conf/battery/lead_acid_12v7.yaml", LEAD)),
    "a mode": ({"mode": "cv_refleks"}, ("no mode 'cv_refleks' in conf/modes", "cv_reflex")),
    "a knob": ({"frequenzy_hz": 90}, ("frequenzy_hz", "frequency_hz")),
    "a condition": ({"inital_soc": 0.2}, ("inital_soc", "initial_soc")),
    "a range": ({"initial_soc": 1.2}, ("initial_soc=1.2", "charge.initial_soc", "less than 1")),
    "text for a number": ({"charge_a": "x"}, ("charge_a='x'", "modes.cv_reflex.charge_a")),
    "not a number": ({"charge_a": float("nan")}, ("modes.cv_reflex.charge_a", "finite")),
    "a mode that does not fit": ({"voltage_v": 11.0}, ("voltage_v=11.0", "modes.cv_reflex", "11")),
    "a value still to be found": ({}, ("modes.cv_reflex", "search", "snakemake --cores 2 solar_reflex")),
    "no power": ({"frequency_hz": 90, "supply_power_w": 0.0}, ("supply_power_w", "0.0")),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_one_message(mistake: str) -> None:
    given, words = MISTAKES[mistake]
    with pytest.raises(UserError) as refused:
        cp.charge(**{"battery": LEAD, "mode": "cv_reflex", **given})  # type: ignore[operator]
    for word in words:
        assert word in str(refused.value)


def test_the_message_is_that_of_the_command_line() -> None:
    with pytest.raises(UserError) as typed:
        main(["modes.cv_reflex.charge_a=x", "--cfg"])
    with pytest.raises(UserError) as called:
        cp.charge(LEAD, "cv_reflex", charge_a="x")  # type: ignore[operator]
    assert str(typed.value).split(": ", 1)[1] == str(called.value).split(": ", 1)[1]


def test_a_knob_of_no_mode_and_an_empty_list_are_refused() -> None:
    with pytest.raises(UserError, match="discharge_aa"):
        cp.compare(LEAD, ["cc_cv", "cv_pulse"], discharge_aa=1.0)
    with pytest.raises(UserError, match=r"modes: value \[\]"):
        cp.compare(LEAD, [])
    with pytest.raises(UserError, match=r"mode: value \[\]"):
        cp.sweep(LEAD, [])


def test_nothing_is_composed_twice_and_an_edit_is_seen(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    cp.battery(LEAD)
    monkeypatch.setattr(named, "compose_tree", lambda words: pytest.fail("composed again"))
    cp.battery(LEAD)
    cp.mode("cc_cv", LEAD)
    # As after an edit: the file has another time of change.
    kept = named._KEPT[LEAD]
    file = CONF / "battery" / f"{LEAD}.yaml"
    monkeypatch.setitem(kept._files, file, (0, 0))
    monkeypatch.setattr(named, "compose_tree", compose_tree)
    cp.battery(LEAD)
    assert named._KEPT[LEAD] is not kept


def test_values_that_a_study_found_are_taken_from_its_results(monkeypatch: pytest.MonkeyPatch) -> None:
    class Ran:
        keys = {"search": "key"}  # noqa: RUF012

    monkeypatch.setattr(named, "run_of", lambda words: Ran())
    monkeypatch.setattr(named.store, "damage", lambda folder: None)
    monkeypatch.setattr(named, "resolve", lambda values, folders: {**values, "frequency_hz": 90.0})
    found = cp.charge(LEAD, "cv_reflex", initial_soc=0.8)  # type: ignore[operator]
    given = cp.charge(LEAD, "cv_reflex", initial_soc=0.8, frequency_hz=90.0)  # type: ignore[operator]
    assert dict(found.summary) == dict(given.summary)


def test_batteries_and_modes_are_records() -> None:
    assert isinstance(cp.battery("lfp_8ah"), Battery)
    assert isinstance(cp.mode("staged_printed"), Mode)
    assert isinstance(cp.charge, ModuleType)
