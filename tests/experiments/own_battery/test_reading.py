"""Files as people have them are read; what they do not say is asked for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from pipeline.config.planning import run_of
from pipeline.errors import UserError
from pipeline.experiments.own_battery import own_reading
from pipeline.experiments.own_battery.reading import Series, measured_series
from pipeline.experiments.own_battery.records import HeldOut, Measured
from tests.experiments.own_battery.making import AMBIENT_C, SHARED, card, made, pulsed, small_file, written
from tests.making import inputs, output

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


def _orders() -> dict[str, tuple[np.ndarray, str]]:
    count = len(_series().time_s)
    swapped = np.arange(count)
    swapped[[40, 41]] = 41, 40
    return {
        "newest first": (np.arange(count)[::-1], "turned round"),
        "two rows in each other's place": (swapped, "put in the order of time"),
        "a block again": (np.concatenate([np.arange(100), np.arange(60, count)]), "40 rows stand there a second time"),
        "everything again": (np.tile(np.arange(count), 2), f"{count} rows stand there a second time"),
        "every row twice": (np.repeat(np.arange(count), 2), f"{count} rows repeat"),
    }


@pytest.mark.parametrize("name", _orders())
def test_rows_in_disorder_come_into_order(tmp_path: Path, name: str) -> None:
    order, told = _orders()[name]
    lines = _rows().splitlines()
    file = _text(tmp_path, "\n".join(["time_s,voltage_v,current_a", *(lines[at] for at in order)]) + "\n")
    found = measured_series(Measured(file=file))[0]
    for one in ("time_s", "voltage_v", "current_a"):
        np.testing.assert_allclose(getattr(found, one), getattr(_series(), one), atol=1e-5)
    assert any(told in line for line in found.said)


def test_a_clock_that_was_set_back_is_refused_and_rows_can_be_counted_instead(tmp_path: Path) -> None:
    series = _series()
    wrong = series.time_s.copy()
    wrong[120:] -= 30.0
    file = _text(tmp_path, "time_s,voltage_v,current_a\n" + _rows(series=series._replace(time_s=wrong)))
    with pytest.raises(UserError, match=r"line 122: the time goes back.*measured\.sample_interval_s=1 "):
        measured_series(Measured(file=file))
    found = measured_series(Measured(file=file, sample_interval_s=1.0))[0]
    np.testing.assert_allclose(found.time_s, series.time_s)
    assert any("column 'time_s' is not used" in line for line in found.said)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_wild_current_turns_no_sign(tmp_path: Path, sign: float) -> None:
    series = _series()
    amperes = sign * series.current_a
    amperes[30] = 80.0
    file = _text(tmp_path, "time_s,voltage_v,current_a\n" + _rows(series=series._replace(current_a=amperes)))
    found = measured_series(Measured(file=file))[0]
    np.testing.assert_allclose(found.current_a, np.delete(series.current_a, 30), atol=1e-5)
    assert any("no voltage answers to the current, left out: line 32 (80 A)" in line for line in found.said)


def test_a_current_of_one_row_to_which_the_voltage_answers_stays(tmp_path: Path) -> None:
    battery = card("lfp_8ah")
    current = pulsed(battery.capacity_ah, 3, 300)
    current[30] = 24.0
    series = made(battery, 0.9, current, None)
    file = _text(tmp_path, "time_s,voltage_v,current_a\n" + _rows(series=series))
    assert measured_series(Measured(file=file))[0].current_a[30] == pytest.approx(24.0)


def test_a_voltage_far_above_the_others_is_left_out_at_a_pulse_too(tmp_path: Path) -> None:
    series = _series()
    edge = int(np.flatnonzero(np.abs(np.diff(series.current_a)) > 1.0)[2]) + 1
    volts = series.voltage_v.copy()
    volts[edge] = 33.0
    file = _text(tmp_path, "time_s,voltage_v,current_a\n" + _rows(series=series._replace(voltage_v=volts)))
    assert any(f"line {edge + 2} (33 V)" in line for line in measured_series(Measured(file=file))[0].said)


def _stamped(kind: str) -> tuple[str, list[str]]:
    import datetime

    begin = datetime.datetime(2024, 3, 10, 23, 30)
    at = [begin + datetime.timedelta(seconds=float(one)) for one in _series().time_s]
    seconds = [int(40 * one) for one in _series().time_s]
    return {
        "Date": ("Date", [one.isoformat(sep=" ") for one in at]),
        "Date,Time": ("Date,Time", [one.strftime("%Y-%m-%d,%H:%M:%S") for one in at]),
        "hours past a day": ("Test Time", [f"{s // 3600}:{s % 3600 // 60:02d}:{s % 60:02d}" for s in seconds]),
        "days": ("TestTime", [f"{s // 86400}d {s // 3600 % 24:02d}:{s // 60 % 60:02d}:{s % 60:02d}" for s in seconds]),
        "time/s": ("time/s", [f"{one:g}" for one in _series().time_s]),
        "t [min]": ("t [min]", [f"{one / 60.0:.9f}" for one in _series().time_s]),
    }[kind]  # fmt: skip


@pytest.mark.parametrize("kind", ["Date", "Date,Time", "hours past a day", "days", "time/s", "t [min]"])
def test_times_are_read_as_cyclers_write_them(tmp_path: Path, kind: str) -> None:
    heading, cells = _stamped(kind)
    values = zip(cells, _series().voltage_v, _series().current_a, strict=True)
    lines = [f"{time},{volts:.6f},{1e3 * amperes:.3f}" for time, volts, amperes in values]
    file = _text(tmp_path, "\n".join([f"{heading},Ewe/V,I/mA", *lines]))
    found = measured_series(Measured(file=file))[0]
    factor = 40.0 if kind in ("hours past a day", "days") else 1.0
    np.testing.assert_allclose(found.time_s, factor * _series().time_s, atol=1e-4)
    np.testing.assert_allclose(found.current_a, _series().current_a, atol=1e-5)


def test_what_is_no_measurement_is_left_out_and_said(tmp_path: Path) -> None:
    lines = ["time_s,voltage_mV,current_mA", *(f"{t:g},{1e3 * v:.3f},{1e3 * i:.3f}" for t, v, i in _plain_rows())]
    lines[20], lines[30] = "NaN,NaN,NaN", lines[30].split(",")[0] + ",N/A,"
    lines.append("4000,33")
    found = measured_series(Measured(file=_text(tmp_path, "\n".join(lines))))[0]
    assert len(found.time_s) == len(_series().time_s) - 2
    kept = np.delete(np.arange(len(_series().time_s)), [19, 29])
    np.testing.assert_allclose(found.voltage_v, _series().voltage_v[kept], atol=1e-5)
    np.testing.assert_allclose(found.current_a, _series().current_a[kept], atol=1e-5)
    for told in ("1 rows without a time", "1 rows without a value left out, the first line 31", "is cut off: left out"):
        assert any(told in line for line in found.said)


@pytest.mark.parametrize(
    ("line", "told", "missing"),
    [
        ("End of test,,", r"allowed is a number of seconds.*measured\.missing=\[\"End of test\"\]'", "End of test"),
        ("30,999999,0", r"999999.*measured\.missing=\[\"999999\"\]'", "999999"),
    ],
)  # fmt: skip
def test_marks_are_refused_with_the_line_that_leaves_them_out(
    tmp_path: Path, line: str, told: str, missing: str
) -> None:
    lines = ["time_s,voltage_v,current_a", *(f"{t:g},{v:.6f},{i:g}" for t, v, i in _plain_rows())]
    lines[31] = line
    file = _text(tmp_path, "\n".join(lines))
    with pytest.raises(UserError, match=told):
        measured_series(Measured(file=file))
    assert len(measured_series(Measured(file=file, missing=(missing,)))[0].time_s) == len(_series().time_s) - 1


def _plain_rows() -> list[tuple[float, float, float]]:
    return list(zip(_series().time_s, _series().voltage_v, _series().current_a, strict=True))


def test_a_file_named_twice_is_refused() -> None:
    with pytest.raises(UserError, match=r"measured\.more: .*small\.csv' is named twice"):
        run_of(["study=own_battery", f"measured.file={small_file()}", f"measured.more=[{small_file()}]"])


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


def test_files_are_held_out_by_their_paths_or_by_the_last_words_of_these(tmp_path: Path) -> None:
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        small = Path(small_file()).read_text(encoding="utf-8")
        (tmp_path / folder / "2017-03-25_2017-03-26.csv").write_text(small, encoding="utf-8")
    (tmp_path / "c.csv").write_text(small, encoding="utf-8")
    first, second = (tmp_path / folder / "2017-03-25_2017-03-26.csv" for folder in "ab")

    def held(name: str, *more: Path) -> list[bool]:
        words = [f"measured.file={first}", f"measured.more=[{','.join(map(str, more))}]"]
        study = run_of(["study=own_battery", *words, f"own_battery.held_out.files=[{name}]"])
        settings = next(node.settings for node in study.nodes if node.name == "own_reading")
        wanted = HeldOut.model_validate(settings["held_out"])
        return [wanted.takes(file) for file in (str(first), *map(str, more))]

    assert held(first.name, tmp_path / "c.csv") == [True, False]
    assert held("c.csv", tmp_path / "c.csv") == [False, True]
    assert held(str(second), second) == [False, True]
    with pytest.raises(UserError, match=r"is the name of .*a.* and .*b.*; give its path"):
        held(first.name, second)
    with pytest.raises(UserError, match="every file is held out"):
        held(f"{first.name},c.csv", tmp_path / "c.csv")


def test_what_is_foreseen_is_of_the_files_that_the_fit_may_see(tmp_path: Path) -> None:
    battery = card("lfp_8ah")
    cold = made(battery, 0.9, pulsed(battery.capacity_ah, 3, 300), np.random.default_rng(1))
    warm = cold._replace(temperature_c=cold.temperature_c + 20.0, ambient_c=cold.ambient_c + 20.0)
    first, second = written(tmp_path / "cold.csv", cold), written(tmp_path / "warm.csv", warm)
    words = ["study=own_battery", f"measured.file={first}", f"measured.more=[{second}]"]

    def foreseen(name: str, *more: str) -> dict[str, str]:
        run = run_of([*words, *more])
        own_reading.run(run.nodes[0].settings, inputs({}), output("own_reading", tmp_path / name))
        rows = inputs({"own_reading": tmp_path / name}).table("own_reading", "foresight")
        return dict(zip(rows["quantity"].tolist(), rows["told"].tolist(), strict=True))

    both, one = foreseen("both"), foreseen("one", "own_battery.held_out.files=[warm.csv]")
    assert (both["temperature dependence"], one["temperature dependence"]) == ("yes", "no")
    # Two rooms are no warming of a cell.
    assert both["heat capacity and cooling"] == one["heat capacity and cooling"]


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
