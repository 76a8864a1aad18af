"""A lab sheet that cannot be run says so, with the place, the value and what is allowed."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from pydantic import ValidationError

import pipeline
from pipeline.charge.checks import check
from pipeline.charge.drive import run_program
from pipeline.charge.period import run_endless
from pipeline.charge.protocol import resolve
from pipeline.charge.records import EngineSettings, Mode
from pipeline.charge.simulate import BENCH, Task, kernels_of, warm_up
from pipeline.errors import UserError
from pipeline.kernel.tables import to_arrow
from tests.charge.samples import BATTERIES, MODES, battery, charge, load, settings
from tests.making import declared

LEAD = battery("lead_acid_12v7ah")


@pytest.mark.parametrize("mode", MODES)
def test_the_modes_of_the_configuration_are_right(mode):
    sheet = Mode(**load(f"modes/{mode}.yaml"))
    check(LEAD, sheet, settings(0.2))
    assert Mode.model_validate(sheet.model_dump()) == sheet


@pytest.mark.parametrize("cell", BATTERIES)
def test_batteries_read_what_they_write(cell):
    record = battery(cell)
    assert type(record).model_validate(record.model_dump()) == record


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"frequencyhz": 90.0}, r"frequencyhz: no phase uses this knob; best matches are: frequency_hz"),
        ({"charge_share": 0.97}, r"phases.reflex: charge_share 0.97 \+ discharge_share 0.05 is more than the period"),
        ({"charge_share": 1.2}, r"phases.reflex.charge_share: 1.2 is not a share"),
        ({"frequency_hz": 1e6}, r"phases.reflex.frequency_hz: at 1e\+06 Hz a segment lasts 9e-07 s"),
        ({"frequency_hz": -3.0}, r"phases.reflex.frequency_hz: -3; it must be greater than 0"),
        ({"voltage_v": 11.0}, r"voltage_v: 11 V does not charge a battery that rests at 12.08 V"),
        ({"stop": {"soc": 0.99}}, r"stop.elapsed_s: missing"),
        ({"stop": {"elapsed_s": 10, "soc": 0.1}}, r"stop.soc: 0.1 is not above initial_soc 0.2"),
        ({"stop": {"elapsed_s": 10, "temperature_c": 20}}, r"stop.temperature_c: 20 degC is not above the ambient"),
        ({"phases": {"a": {"reflex": {}}, "b": {"rest": {}}}}, r"phases.a.until: missing"),
        (
            {"phases": {"a": {"reflex": {"charge_a": "chrge_a"}}}},
            r"phases.a.charge_a: names the knob 'chrge_a'; best matches are: charge_a",
        ),
        ({"phases": {"a": {"reflex": {}, "until": {"current_a": 0.1}}}}, r"phases.a.until.current_a: only a constant"),
    ],
)
def test_a_mistake_is_named(change, message):
    sheet = Mode(**(load("modes/cv_reflex.yaml") | change))
    with pytest.raises(UserError, match=message):
        check(LEAD, sheet, settings(0.2))


@pytest.mark.parametrize(
    ("phase", "message"),
    [
        ({"reflx": {}}, "unknown waveform or key 'reflx'; best matches are: reflex"),
        ({"reflex": {}, "rest": {}}, "a phase has one waveform"),
        ({"reflex": {"charge": 1}}, "charge"),
        ({"rest": {}, "until": {"volts": 1}}, "volts"),
    ],
)
def test_an_unknown_key_is_refused(phase, message):
    with pytest.raises(ValidationError, match=message):
        Mode(**(load("modes/cv_reflex.yaml") | {"phases": {"a": phase}}))


def test_a_knob_still_to_be_found_passes_the_check_but_not_the_charge():
    sheet = Mode(**(load("modes/cv_reflex.yaml") | {"frequency_hz": {"from": "search", "value": "frequency_hz"}}))
    check(LEAD, sheet, settings(0.2))
    with pytest.raises(UserError, match=r"phases\.reflex\.frequency_hz: still to be found by 'search'"):
        resolve(sheet, 7.0)


def test_a_rate_stands_for_a_multiple_of_the_capacity():
    sheet = load("modes/cc_cv.yaml")
    sheet["max_current_c_rate"] = 0.3
    sheet.pop("max_current_a")
    assert resolve(Mode(**sheet), 18.0).courses[0].segments[0].current_a == pytest.approx(5.4)


def test_every_table_is_as_declared():
    windows = [{"start_s": 0.5, "length_s": 0.1}]
    sheet = load("modes/cv_reflex.yaml") | {"stop": {"elapsed_s": 2.0}}
    result = charge(LEAD, Mode(**sheet), settings(0.5, windows=windows, soc_marks=[0.9]))
    for table, columns in (
        (declared("charge")["trace"].table, result.trace),
        (declared("charge")["waveform"].table, result.waveform),
        (declared("charge")["phases"].table, result.phases),
        (declared("charge")["energy"].table, result.energy),
        (
            declared("charge")["summary"].table,
            {name: [getattr(row, name) for row in result.summary] for name in result.summary[0]._fields},
        ),
    ):
        assert to_arrow(table, columns).num_rows > 0


def test_records_and_checks_import_nothing_heavy():
    code = (
        "import sys, pipeline.cell.records, pipeline.charge.records, pipeline.charge.checks;"
        "import pipeline.charge.comparison;"
        "print([name for name in ('numba', 'scipy', 'numpy', 'matplotlib') if name in sys.modules])"
    )
    source = str(Path(pipeline.__file__).parents[1])
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env={"PYTHONPATH": source})
    assert found.stdout.strip() == "[]", found.stderr


def test_warming_up_names_its_kernels():
    assert "run_program" in warm_up()


def test_a_sheet_without_periods_takes_an_engine_without_periods():
    code = (
        "import pipeline as cp\n"
        "from pipeline.charge.drive import run_program\n"
        "cp.charge('lead_acid_12v7ah', 'cc_cv', initial_soc=0.9)\n"
        "assert not run_program.overloads\n"
        "cp.charge('lead_acid_12v7ah', 'cv_pulse', frequency_hz=90, initial_soc=0.95)\n"
        "assert [str(types[-1]) for types in run_program.overloads] == ['none']\n"
    )
    source = str(Path(pipeline.__file__).parents[1])
    environment = os.environ | {"PYTHONPATH": source}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stderr


def test_what_is_still_to_be_compiled_is_known(monkeypatch):
    endless, periods = (
        Task(LEAD, Mode(**load(f"modes/{mode}.yaml")), BENCH, settings(0.5), EngineSettings())
        for mode in ("three_stage_agm", "cv_reflex")
    )
    kept: dict[str, dict[str, str]] = {"endless": {}, "periods": {}}
    for kernel, kind in ((run_endless, "endless"), (run_program, "periods")):
        monkeypatch.setattr(kernel._cache._cache_file, "_load_index", lambda kind=kind: kept[kind])
    assert kernels_of([endless]) == {"endless"}
    assert kernels_of([endless, periods]) == {"endless", "periods"}
    assert kernels_of([endless] * 100) == {"periods"}
    kept["endless"]["types"] = "file"
    assert kernels_of([endless, periods]) == {"periods"}
    kept["periods"]["types"] = "file"
    assert kernels_of([endless, periods]) == set()
