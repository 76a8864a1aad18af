"""Artefacts of a study that never ran: small tables, written as the steps write them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from pipeline import quantity, schemas, schemas_switched, tables
from pipeline.published.artefacts import Lookup
from pipeline.published.records import Statement

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
Numbers = Mapping[str, float]


def write_charge(folder: Path, summary: Numbers, bulk_end_s: float = 3600.0, final_soc: float = 0.99) -> None:
    """Write a charge whose SOC rises evenly to `final_soc` in ten thousand seconds."""
    folder.mkdir(parents=True)
    names = list(summary)
    columns = {
        "quantity": names,
        "value": [summary[name] for name in names],
        "text": [None] * len(names),
        "unit": ["1"] * len(names),
        "description": [""] * len(names),
    }
    tables.write(schemas.CHARGE_SUMMARY, columns, folder / "summary.parquet")
    time = np.linspace(100.0, 10_000.0, 100)
    trace: dict[str, Any] = {column.name: np.zeros(100) for column in schemas.CHARGE_TRACE.columns}
    trace["Test Time / s"], trace["soc"] = time, final_soc * time / time[-1]
    trace["Step Index / 1"] = np.ones(100, dtype=np.int64)
    tables.write(schemas.CHARGE_TRACE, trace, folder / "trace.bdf.parquet")
    phases = {
        "phase": ["bulk", "pulses"],
        "start_s": [0.0, bulk_end_s],
        "end_s": [bulk_end_s, 10_000.0],
        "end_reason": ["elapsed", "soc"],
        "start_soc": [0.2, 0.5],
        "end_soc": [0.5, final_soc],
        "end_temperature_c": [27.0, 28.0],
    }
    tables.write(schemas.CHARGE_PHASES, phases, folder / "phases.parquet")


def write_points(folder: Path, **changed: float) -> None:
    """Write the panel's points: the standard condition with what was changed, and another."""
    folder.mkdir(parents=True)
    standard = POINT | changed
    other = POINT | {"irradiance_w_m2": 200.0, "max_power_w": 12.0}
    columns = {name: [standard[name], other[name]] for name in POINT}
    tables.write(schemas.PANEL_POINTS, columns, folder / "points.parquet")


def write_switched(folder: Path, pulse_ringing_w: float) -> None:
    """Write what the steps of pulses come to; under Reflex all of it is a thousandth of an ampere, joule or watt."""
    folder.mkdir(parents=True)
    own = {"ripple_a", "conduction_efficiency", "overshoot_a", "settling_s", "ringing_j", "ringing_w"}
    columns: dict[str, list[object]] = {
        "comparison": ["same_peak"] * 2,
        "mode": ["cv_pulse", "cv_reflex"],
        "window": [0, 0],
        "pulses_hz": [90.0] * 2,
    }
    columns |= {name: [pulse_ringing_w, 0.001] for name in own}
    tables.write(schemas_switched.SWITCHED_MODES, columns, folder / "modes.parquet")


def write_reference(path: Path, power_w: float = 65.0, voltage_v: float = 17.4) -> None:
    """Write the printed Table 1."""
    path.write_text(PRINTED.format(power_w, voltage_v), encoding="utf-8")


def write_quantities(folder: Path, numbers: Numbers) -> None:
    """Write the named numbers of a step."""
    folder.mkdir(parents=True)
    columns = quantity.columns(quantity.Quantity(name, value, "1", "") for name, value in numbers.items())
    tables.write(schemas.QUANTITIES, columns, folder / "quantities.parquet")


def write_ensemble(folder: Path, samples: list[Mapping[tuple[str, str, str], float]]) -> None:
    """Write an ensemble from (comparison, mode, quantity) -> value, one mapping per sample."""
    folder.mkdir(parents=True)
    rows = [(number, *key, value) for number, sample in enumerate(samples) for key, value in sample.items()]
    names = ("sample", "comparison", "mode", "quantity", "value")
    columns = {name: [row[place] for row in rows] for place, name in enumerate(names)}
    tables.write(schemas.ENSEMBLE, columns, folder / "ensemble.parquet")


@pytest.fixture(scope="session")
def shipped() -> dict[str, Statement]:
    data = yaml.safe_load((CONF / "solar_reflex.yaml").read_text(encoding="utf-8"))
    return {name: Statement.model_validate(entry) for name, entry in data.items()}


@pytest.fixture
def lookup(tmp_path: Path) -> Callable[..., Lookup]:
    """Return a maker of lookups: charges by input name -> summary numbers, beside panel and reference."""

    def make(charges: Mapping[str, Numbers], ensemble: list[Any] | None = None, **points: float) -> Lookup:
        folders = {"panel": tmp_path / "panel", "reference/solar_table1": tmp_path / "solar_table1.csv"}
        write_points(folders["panel"], **points)
        write_reference(folders["reference/solar_table1"])
        for name, summary in charges.items():
            folders[name] = tmp_path / name
            write_charge(folders[name], summary)
        if ensemble is not None:
            folders["ensemble"] = tmp_path / "ensemble"
            write_ensemble(folders["ensemble"], ensemble)
        return Lookup(folders)

    return make
