"""Artefacts of a study that never ran: small tables, written as the steps write them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from pipeline.experiments.reporting.verdicts import samples
from pipeline.published.artefacts import Lookup
from pipeline.published.records import Statement
from pipeline.published.words import PARAMETERS
from pipeline.quantity import Quantity
from tests import making

CONF = Path(__file__).parents[2] / "conf" / "published"
POINT = {
    "irradiance_w_m2": 1000.0,
    "cell_temperature_c": 25.0,
    "short_circuit_current_a": 3.99,
    "open_circuit_voltage_v": 21.7,
    "max_power_current_a": 3.75,
    "max_power_voltage_v": 17.4,
    "max_power_w": 65.25,
}
PRINTED = "p_max_w,v_mp_v,i_mp_a,v_oc_v,i_sc_a\n{},{},3.75,21.7,3.99\n"
# The word of a statement that is false, by its basis.
FALSE = dict.fromkeys(("paper_data", "mathematics"), "contradicted") | dict.fromkeys(
    ("model", "search"), "not reproduced"
)
Numbers = Mapping[str, float]
UNITS = {"_s": "s", "_k": "K", "_c": "degC", "_hz": "Hz", "_ah": "Ah", "_mw2_s": "mW2 s"}


def unit(name: str) -> str:
    """Return the unit that a step would declare for a number of these tests."""
    return next((UNITS[ending] for ending in sorted(UNITS, key=len, reverse=True) if name.endswith(ending)), "1")


def write_charge(folder: Path, summary: Numbers, bulk_end_s: float = 3600.0, final_soc: float = 0.99) -> None:
    """Write a charge whose SOC rises evenly to `final_soc` in ten thousand seconds."""
    output = making.output("charge", folder)
    write_summary(folder, summary)
    time = np.linspace(100.0, 10_000.0, 100)
    trace: dict[str, Any] = {name: np.zeros(100) for name in output.columns("trace")}
    trace["Test Time / s"], trace["soc"] = time, final_soc * time / time[-1]
    trace["Step Count / 1"] = np.ones(100, dtype=np.int64)
    output.write("trace", trace)
    phases = {
        "phase": ["bulk", "pulses"],
        "start_s": [0.0, bulk_end_s],
        "end_s": [bulk_end_s, 10_000.0],
        "end_reason": ["elapsed", "soc"],
        "start_soc": [0.2, 0.5],
        "end_soc": [0.5, final_soc],
        "end_temperature_c": [27.0, 28.0],
    }
    output.write("phases", phases)


def write_summary(folder: Path, summary: Numbers) -> None:
    """Write the summary of a charge."""
    columns = {
        "quantity": list(summary),
        "value": list(summary.values()),
        "text": [None] * len(summary),
        "unit": [unit(name) for name in summary],
        "description": [""] * len(summary),
    }
    making.output("charge", folder).write("summary", columns)


def write_points(folder: Path, **changed: float) -> None:
    """Write the panel's points: the standard condition with what was changed, and another."""
    standard = POINT | changed
    other = POINT | {"irradiance_w_m2": 200.0, "max_power_w": 12.0}
    making.output("panel", folder).write("points", {name: [standard[name], other[name]] for name in POINT})


def write_switched(folder: Path, pulse_ringing_w: float) -> None:
    """Write what the steps of pulses come to; under Reflex all of it is a thousandth of an ampere, joule or watt."""
    own = {"ripple_a", "conduction_efficiency", "overshoot_a", "settling_s", "ringing_j", "ringing_w"}
    columns: dict[str, list[object]] = {
        "comparison": ["same_peak"] * 2,
        "mode": ["cv_pulse", "cv_reflex"],
        "window": [0, 0],
        "pulses_hz": [90.0] * 2,
    }
    columns |= {name: [pulse_ringing_w, 0.001] for name in own}
    making.output("switched", folder).write("modes", columns)


def write_reference(folder: Path, power_w: float = 65.0, voltage_v: float = 17.4) -> None:
    """Write the printed Table 1."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "solar_table1.csv").write_text(PRINTED.format(power_w, voltage_v), encoding="utf-8")


def write_quantities(step: str, folder: Path, numbers: Numbers) -> None:
    """Write the named numbers of a step."""
    making.output(step, folder).numbers([Quantity(name, value, unit(name), "") for name, value in numbers.items()])


def write_ensemble(folder: Path, samples: list[Mapping[str, float | None]], of: str = PARAMETERS) -> None:
    """Write an ensemble from operand in one line -> value, a mapping a point; none where no battery can be so."""
    rows = [
        (number, operand, value, int(value is not None), of)
        for number, sample in enumerate(samples)
        for operand, value in sample.items()
    ]
    making.output("ensemble", folder).rows("ensemble", rows)


@pytest.fixture(scope="session")
def shipped() -> dict[str, Statement]:
    data = yaml.safe_load((CONF / "solar_reflex.yaml").read_text(encoding="utf-8"))
    return {name: Statement.model_validate(entry) for name, entry in data.items()}


@pytest.fixture
def lookup(tmp_path: Path) -> Callable[..., Lookup]:
    """Return a maker of lookups: charges by input name -> summary numbers, beside panel and reference."""

    def make(charges: Mapping[str, Numbers], **points: float) -> Lookup:
        folders = {"panel": tmp_path / "panel"}
        write_points(folders["panel"], **points)
        write_reference(tmp_path / "printed")
        for name, summary in charges.items():
            folders[name] = tmp_path / name
            write_charge(folders[name], summary)
        return Lookup(making.inputs(folders), tmp_path / "printed")

    return make


@pytest.fixture
def ensemble(tmp_path: Path) -> Callable[..., list[Any]]:
    """Return a maker of ensembles: written as their steps write them, read as verdicts read them."""

    def make(nominal: Lookup, *found: list[Any], of: str = PARAMETERS) -> list[Any]:
        folders = {f"ensemble/{number}": tmp_path / f"ensemble_{number}" for number in range(len(found))}
        for folder, one in zip(folders.values(), found, strict=True):
            write_ensemble(folder, one, of)
        return samples(making.inputs(folders), nominal)

    return make
