"""Files as people have them are read; what they do not say is asked for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from pipeline.config.planning import run_of
from pipeline.errors import UserError
from pipeline.experiments.own_battery.reading import Series, measured_series
from pipeline.experiments.own_battery.records import Measured
from tests.experiments.own_battery.making import AMBIENT_C, SHARED, card, made, pulsed, small_file, written

LFP = card("lfp_8ah")


def _series() -> Series:
    return made(LFP, 0.9, pulsed(LFP.capacity_ah, 1, 120), None)


def _text(tmp_path: Path, text: str) -> str:
    path = tmp_path / "own.csv"
    path.write_text(text, encoding="utf-8")
    return str(path)


def _rows(current: str = "{i}", series: Series | None = None, more: str = "") -> str:
    one = _series() if series is None else series
    lines = [
        f"{t:g},{v:.5f}," + current.format(i=f"{i:g}", a=f"{abs(i):g}", n=f"{-i:g}") + more.format(i=i)
        for t, v, i in zip(one.time_s, one.voltage_v, one.current_a, strict=True)
    ]
    return "\n".join(lines) + "\n"


def test_battery_data_format_is_read_by_its_names(tmp_path: Path) -> None:
    series = _series()
    names = {"time_s": "Test Time / s", "voltage_v": "Voltage / V", "current_a": "Current / A"}
    names |= {"temperature_c": "Surface Temperature / degC", "ambient_c": "Ambient Temperature / degC"}
    table = pa.table({heading: getattr(series, name) for name, heading in names.items()})
    pq.write_table(table, tmp_path / "own.bdf.parquet")
    for file in (tmp_path / "own.bdf.parquet", written(tmp_path / "own.csv", series, **names)):
        found = measured_series(Measured(file=str(file)))[0]
        for name in names:
            np.testing.assert_allclose(getattr(found, name), getattr(series, name), atol=1e-5)


def test_the_coming_names_of_the_format_are_read_too(tmp_path: Path) -> None:
    names = {"time_s": "test_time_second", "voltage_v": "voltage_volt", "current_a": "current_ampere"}
    names |= {"temperature_c": "surface_temperature_celsius", "ambient_c": "ambient_temperature_celsius"}
    file = written(tmp_path / "own.csv", _series(), **names)
    found = measured_series(Measured(file=str(file)))[0]
    np.testing.assert_allclose(found.temperature_c, _series().temperature_c, atol=1e-5)


@pytest.mark.parametrize(("current", "word"), [("{i}", "positive_charging"), ("{n}", "positive_discharging")])
def test_the_sign_of_the_current_is_judged_from_the_voltage(tmp_path: Path, current: str, word: str) -> None:
    file = _text(tmp_path, "time_s,Voltage,Current\n" + _rows(current))
    found = measured_series(Measured(file=file))[0]
    np.testing.assert_allclose(found.current_a, _series().current_a, atol=1e-5)
    assert any(word in line for line in found.said)


def test_the_sign_that_a_column_tells_is_taken_where_the_current_has_none(tmp_path: Path) -> None:
    series = _series()
    modes = ["REST" if i == 0 else "CHRG" if i > 0 else "DCHG" for i in series.current_a]
    lines = [
        f"{t:g},{v:.5f},{abs(i):g},{mode},"
        for t, v, i, mode in zip(series.time_s, series.voltage_v, series.current_a, modes, strict=True)
    ]
    file = _text(tmp_path, "Time(s),Voltage(V),Current(A),Mode,Loop,Loop,\n" + "\n".join(f"{one}1,2," for one in lines))
    found = measured_series(Measured(file=file))[0]
    np.testing.assert_allclose(found.current_a, series.current_a, atol=1e-5)
    assert any("by_mode" in line for line in found.said)


def test_a_current_whose_sign_cannot_be_seen_is_asked_for(tmp_path: Path) -> None:
    file = _text(tmp_path, "time_s,voltage_v,current_a\n" + "".join(f"{t},3.3,1.0\n" for t in range(30)))
    with pytest.raises(UserError, match=r"current=positive_charging or measured\.current=positive_discharging"):
        measured_series(Measured(file=file))
    assert measured_series(Measured(file=file, current="positive_discharging"))[0].current_a[0] == -1.0


def test_a_missing_column_of_time_is_asked_for_with_what_the_file_hints_at(tmp_path: Path) -> None:
    rows = "".join(f"{v:.4f},{i:g}\n" for v, i in zip(_series().voltage_v, _series().current_a, strict=True))
    file = _text(tmp_path, "Timestep,10Hz\nVoltage,Current\n" + rows)
    with pytest.raises(UserError, match=r"measured\.sample_interval_s=0\.1"):
        measured_series(Measured(file=file))
    found = measured_series(Measured(file=file, sample_interval_s=0.1))[0]
    assert found.time_s[-1] == pytest.approx(0.1 * (len(found.time_s) - 1))


def test_sensors_in_different_rows_are_brought_together(tmp_path: Path) -> None:
    lines = ["time,voltage,current,temperature"]
    for minute in range(60):
        at = f"2017-03-26 07:{minute:02d}"
        volts, amperes = (12.6, 2.5) if minute >= 10 else (13.2, 0.0)
        lines += [f"{at}:05.000,,,{20 + minute / 60:.9f}", f"{at}:35.000,{volts - 0.001 * minute},{amperes},"]
    lines[3], lines[4] = lines[4], lines[3]
    found = measured_series(Measured(file=_text(tmp_path, "\n".join(lines))))[0]
    assert len(found.time_s) == 60
    assert (np.diff(found.time_s) > 0.0).all()
    assert found.current_a[-1] == -2.5
    assert found.temperature_c[30] == pytest.approx(20.5 + 0.5 / 60, abs=1e-6)
    assert any("other rows" in line for line in found.said)


def test_glitches_are_named_and_left_out(tmp_path: Path) -> None:
    series = _series()
    volts = series.voltage_v.copy()
    volts[40], volts[50] = 0.0, 5.5
    file = _text(tmp_path, "time_s,voltage_v,current_a\n" + _rows(series=series._replace(voltage_v=volts)))
    found = measured_series(Measured(file=file))[0]
    assert len(found.time_s) == len(series.time_s) - 2
    assert any("line 42 (0 V), line 52 (5.5 V)" in line for line in found.said)


def test_a_clock_that_begins_anew_goes_on(tmp_path: Path) -> None:
    series = _series()
    half = len(series.time_s) // 2
    again = np.where(np.arange(len(series.time_s)) >= half, series.time_s - half, series.time_s)
    text = "time_s,voltage_v,current_a\n" + _rows(series=series._replace(time_s=again))
    found = measured_series(Measured(file=_text(tmp_path, text)))[0]
    np.testing.assert_allclose(found.time_s, series.time_s)
    assert any("begins anew 1 times" in line for line in found.said)
    wrong = series.time_s.copy()
    wrong[half] -= 3.0
    text = "time_s,voltage_v,current_a\n" + _rows(series=series._replace(time_s=wrong))
    with pytest.raises(UserError, match=rf"line {half + 2}: the time goes back"):
        measured_series(Measured(file=_text(tmp_path, text)))


def test_repeated_rows_are_left_out_and_jumps_kept(tmp_path: Path) -> None:
    rows = _rows().splitlines()
    jump = rows[10].split(",")
    text = "\n".join(
        ["time_s,voltage_v,current_a", *rows[:10], rows[9], *rows[10:11], f"{jump[0]},3.1,-1.5", *rows[11:]]
    )
    found = measured_series(Measured(file=_text(tmp_path, text)))[0]
    assert len(found.time_s) == len(rows) + 1
    assert (np.diff(found.time_s) == 0.0).sum() == 1


@pytest.mark.parametrize(
    ("head", "words", "told"),
    [
        ("time_s,volts_of_it,current_a", [], r"no column 'voltage_v' \[V\].*columns=\{voltage_v"),
        ("Time,voltage_v,current_a", [], r"measured\.units=\{time_s: s\}"),
        ("time_s,Voltage,Cell Voltage,current_a", [], "may all be the voltage of the battery; say which"),
        (
            "time_s,voltage_v,current_a",
            ["measured.units.voltage_v=mV"],
            "rests between .* a card of its kind",
        ),
        ("time_s,voltage_v,current_a", ["measured.units.current_a=bar"], r"units\.current_a is 'bar'"),
        ("time_s,voltage_v,current_a", ["own_battery.initial_soc=[0.5,0.6]"], "2 values for 1 files"),
        ("time_s,voltage_v,current_a", ["own_battery.held_out.files=[other.csv]"], "'other.csv' is none of"),
        ("time_s,voltage_v,current_a", ["own_battery.held_out.around_soc=[0.1]"], "no pulse and no rest lies there"),
    ],
)
def test_what_cannot_be_used_is_refused_with_the_remedy(tmp_path: Path, head: str, words: list[str], told: str) -> None:
    rows = _rows()
    if head.count(",") == 3:
        rows = "".join(f"{line.replace(',', ',3.3,', 1)}\n" for line in rows.splitlines())
    file = _text(tmp_path, f"{head}\n{rows}")
    with pytest.raises(UserError, match=told):
        run_of(["study=own_battery", f"measured.file={file}", *words])


def test_no_file_is_asked_for() -> None:
    with pytest.raises(UserError, match=r"measured\.file: no file is named.*measured\.file=FILE"):
        run_of(["study=own_battery"])


def test_a_plan_says_what_was_done_to_the_file() -> None:
    run = run_of(["study=own_battery", f"measured.file={small_file()}"])
    assert [node.name for node in run.nodes][:3] == ["own_reading", "own_fit", "own_charges"]
    assert any("positive_charging, judged" in line for line in run.remarks)


@pytest.mark.skipif(not SHARED.is_dir(), reason="../shared/data is not there")
@pytest.mark.parametrize(
    ("file", "settings", "rows", "sign"),
    [
        ("lfp_hppc_k2_26650/HPPC_20C.csv", {"sample_interval_s": 1.0}, 72140, "positive_charging"),
        ("lfp_hppc_k2_26650/HPPC_40C.csv", {"sample_interval_s": 1.0}, 72142, "positive_charging"),
        ("solar_home_lead_acid/2017-03-25_2017-03-25.csv", {}, 415, "positive_discharging"),
        ("solar_home_lead_acid/2017-03-27_2017-03-27.csv", {}, 611, "positive_discharging"),
        ("solar_home_lead_acid/2017-03-28_2017-03-29.csv", {}, 790, "positive_discharging"),
        ("leaf_cell_bitrode/cell-low-current-hppc-25c-2.csv", {}, 13248, "positive_charging"),
        ("leaf_cell_bitrode/cell-cycling-first-400-rows.csv", {}, 399, "by_mode"),
        ("samsung_inr21700/multipulse_hppc.xlsx", {"units": {"time_s": "s"}}, 1187, "positive_discharging"),
    ],
)
def test_real_files_are_read(file: str, settings: dict[str, object], rows: int, sign: str) -> None:
    found = measured_series(Measured.model_validate({"file": str(SHARED / file), **settings}))[0]
    assert len(found.time_s) == rows
    assert any(line.startswith("current:") and sign in line for line in found.said)
    if "40C" in file:
        assert any("left out: line 20298 (0 V)" in line for line in found.said)
    assert np.isnan(found.ambient_c).all() or abs(float(found.ambient_c[0]) - AMBIENT_C) < 25.0
