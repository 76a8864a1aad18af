"""Modes side by side by one line: the answer against the engine's own numbers, the page, and what is refused."""

from __future__ import annotations

import csv
import json
import re
import shlex
from pathlib import Path

import numpy as np
import pytest

import pipeline as cp
from pipeline.__main__ import main
from pipeline.charge.simulate import Supply, simulate
from pipeline.commands import compare_modes
from pipeline.commands.compare_modes import Measure
from pipeline.converter.efficiency import battery_power
from pipeline.converter.records import Load
from pipeline.errors import UserError
from pipeline.notebook import charges, named
from pipeline.panel.curves import points
from pipeline.panel.single_diode import fit

LEAD = "lead_acid_12v7ah"
GIVEN = ["frequency_hz=90", "initial_soc=0.2"]


@pytest.fixture(autouse=True)
def _empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def typed(line: str) -> int:
    return main(["compare-modes", *shlex.split(line)])


def test_the_answer_the_table_and_the_page_have_the_engines_numbers(capsys: pytest.CaptureFixture[str]) -> None:
    assert typed(f"--battery {LEAD} --modes cc_cv,cv_pulse {' '.join(GIVEN)}") == 0
    told = capsys.readouterr().out
    alone = {
        mode: cp.charge(LEAD, mode, initial_soc=0.2, **knobs).summary  # type: ignore[operator]
        for mode, knobs in (("cc_cv", {}), ("cv_pulse", {"frequency_hz": 90}))
    }
    hours = {mode: float(one["time_to_soc_0.99_s"]) / 3600.0 for mode, one in alone.items()}
    lead = hours["cv_pulse"] - hours["cc_cv"]
    share = 100.0 * (hours["cv_pulse"] / hours["cc_cv"] - 1.0)
    assert lead > 0.0
    first = told.splitlines()[0]
    assert first.startswith(
        f"CC-CV is fastest to SOC 0.99, by {lead:.3f} h ({share:.0f} %): CC-CV {hours['cc_cv']:.2f} h"
    )
    folder = Path("reports/compare_modes") / f"{LEAD}__cc_cv+cv_pulse__frequency_hz=90__initial_soc=0.2"
    assert f"the page: {folder / 'index.html'}" in told
    with (folder / "tables" / "modes.csv").open(newline="") as file:
        rows = {row["quantity"]: row for row in csv.DictReader(file)}
    for name, quantity, factor in (
        ("Peak temperature", "peak_temperature_c", 1.0),
        ("Energy efficiency", "energy_efficiency", 100.0),
        ("Time to SOC 0.95", "time_to_soc_0.95_s", 1 / 3600.0),
    ):
        for title, mode in (("CC-CV", "cc_cv"), ("CV-pulse", "cv_pulse")):
            assert float(rows[name][title]) == pytest.approx(factor * float(alone[mode][quantity]), rel=1e-9)
    for name in rows:
        assert re.search(rf"^{re.escape(name)} ", told, re.M)
    page = (folder / "index.html").read_text()
    assert first in page
    assert "modes.svg" in page
    assert f"{folder.relative_to('reports')}/index.html" in Path("reports/index.html").read_text()
    curves = json.loads((folder / "traces.js").read_text().removeprefix("window.TRACES = ").rstrip(";\n"))
    assert [one["name"] for one in curves] == ["cc_cv", "cv_pulse"]
    assert set(curves[0]["quantities"]) == {"Voltage [V]", "Current [A]", "Temperature [°C]", "State of charge [%]"}
    assert curves[1]["quantities"]["State of charge [%]"][-1] == pytest.approx(99.0, abs=0.05)


def test_a_panels_supply_is_that_of_its_curve_and_converters() -> None:
    fed = named.fed("kc65t", ["weather.irradiance_w_m2=400.0", "load.power_w=5.0"])
    part = named._supplied(
        ["~study", "+panel=kc65t", "+weather=constant", "+converter=fixed_efficiency", "+load=master_system"]
    )
    most = points(part.panel, fit(part.panel), [400.0], [25.0])
    expected = battery_power(
        [0.0], [400.0], [25.0], most["max_power_w"], part.converter, Load(title="load", power_w=5.0),
        most["max_power_voltage_v"],
    )  # fmt: skip
    assert fed.supply.power_w == pytest.approx(expected["battery_power_w"], rel=1e-12)
    assert fed.supply.power_w[0] == pytest.approx(0.92 * (0.95 * 0.99 * float(most["max_power_w"][0]) - 5.0), rel=1e-9)


def test_a_panel_limits_a_charge() -> None:
    fed = named.fed("kc65t", ["weather.irradiance_w_m2=200.0"])
    found = cp.charge(LEAD, "cc_cv", panel=fed, initial_soc=0.7)  # type: ignore[operator]
    one = charges.task(LEAD, "cc_cv", fed.supply, {"initial_soc": 0.7})
    expected = simulate(*one)
    np.testing.assert_array_equal(found.trace["soc"].to_numpy(), expected.trace["soc"])
    assert found.summary["time_at_supply_limit_s"] > 0
    assert found.summary["energy_drawn_wh"] > found.summary["energy_in_wh"] / 0.95
    with pytest.raises(UserError, match=r"supply_power_w: value 5\.0; with a panel"):
        cp.charge(LEAD, "cc_cv", panel="kc65t", supply_power_w=5.0)  # type: ignore[operator]


def test_a_panel_above_the_usual_bus_has_a_bus_that_fits() -> None:
    fed = named.fed("Canadian_Solar_Inc__CS5P_235M")
    assert fed.told.startswith("Canadian Solar Inc. CS5P-235M (235.2 W), constant 1000 W/m2")
    assert 0.0 < fed.supply.power_w[0] < 235.2
    with pytest.raises(UserError, match=r"converter\.bus_voltage_v is 20 V"):
        named.fed("Canadian_Solar_Inc__CS5P_235M", ["converter.bus_voltage_v=20.0"])


def test_a_knob_may_be_that_of_one_mode() -> None:
    both = charges.side_by_side(LEAD, ["cv_pulse", "cv_reflex"], initial_soc=0.8,
                                **{"cv_pulse.frequency_hz": 50, "cv_reflex.frequency_hz": 20})  # fmt: skip
    assert [one.mode.knobs["frequency_hz"] for one in both] == [50, 20]


def test_a_value_that_waits_is_made_first(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    made: list[list[str]] = []

    def make(words: list[str]) -> int:
        made.append(words)
        monkeypatch.setattr(named, "with_found", lambda name, values: {**values, "frequency_hz": 72.0})
        return 0

    monkeypatch.setattr("pipeline.commands.run.main", make)
    assert typed(f"--battery {LEAD} --modes cv_reflex initial_soc=0.8") == 0
    assert made == [["study=solar_reflex", "-t", "search"]]
    told = capsys.readouterr().out
    assert "CV-Reflex: frequency_hz is 72, which the step search found in its study" in told


@pytest.mark.parametrize(
    ("values", "clear", "words"),
    [
        ((10.0, 10.05), False, "No clear difference in time"),
        ((10.0, 10.2), True, "is first, by 0.2 h (2 %)"),
        ((10.0, None), False, "B none"),
    ],
)
def test_a_lead_that_does_not_matter_is_none(values: tuple[float, float | None], clear: bool, words: str) -> None:
    measure = Measure("end_time_s", "time", "is first", "h", 1.0, -0.01)
    compared = compare_modes.Compared.__new__(compare_modes.Compared)
    compared.titles, compared.charges = ["A", "B"], list(values)  # type: ignore[list-item]
    compared._value = lambda name, one: one  # type: ignore[method-assign,assignment,misc,return-value]
    if values[1] is not None:
        assert measure.is_clear(values[0], values[1]) is clear
    assert words in compared._answer(measure)


MISTAKES = {
    "--battery lead_acid_12v18 --modes cc_cv": ("--battery lead_acid_12v18", "lead_acid_12v18ah"),
    f"--battery {LEAD} --modes cc_cv,cv_refleks": ("--modes cv_refleks", "cv_reflex"),
    f"--battery {LEAD} --modes cc_cv,cc_cv": ("--modes cc_cv,cc_cv", "once"),
    f"--battery {LEAD} --panel Kyocera_KC130GT --modes cc_cv": ("--panel Kyocera_KC130GT", "Kyocera_Solar_KC130GT"),
    f"--battery {LEAD} --modes cc_cv load.power_w=3": ("override load.power_w=3", "--panel"),
    f"--battery {LEAD} --panel kc65t --modes cc_cv load.power_w=-3": ("override load.power_w=-3", "0 or more"),
    f"--battery {LEAD} --panel kc65t --modes cc_cv weather=constan": ("override weather=constan", "constant"),
    f"--battery {LEAD} --modes cc_cv initial_soc=1.5": ("charge.initial_soc", "1.5", "less than 1"),
    f"--battery {LEAD} --modes cc_cv initial_soc=0.2,0.3": ("override initial_soc=0.2,0.3", "sweep"),
    f"--battery {LEAD} --modes cc_cv max_current_aa=2": ("max_current_aa", "max_current_a"),
    f"--battery {LEAD} --modes cc_cv word": ("word",),
    f"--battery {LEAD} --panel kc65t --modes cc_cv ~load": ("override ~load", "KEY=VALUE"),
    f"--battery {LEAD} --panel kc65t --modes cc_cv panel.name=x": ("override panel.name=x", "--panel NAME"),
}


@pytest.mark.parametrize("line", MISTAKES)
def test_a_mistake_is_one_message_and_writes_nothing(line: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert typed(line) == 2
    told = capsys.readouterr().err
    assert told.count("error: ") == 1
    for word in MISTAKES[line]:
        assert word in told
    assert list(Path.cwd().iterdir()) == []


def test_a_bench_supply_gives_any_power(capsys: pytest.CaptureFixture[str]) -> None:
    assert isinstance(charges._source(20.0, None), Supply)
    assert typed("--battery lfp_8ah --modes cc_cv_5c initial_soc=0.9") == 0
    told = capsys.readouterr().out
    assert "fed from a supply that gives any power" in told
    assert "is 5C of lfp_8ah; usual are 0.1C to 1C" in told
