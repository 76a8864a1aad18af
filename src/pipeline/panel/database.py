"""Panels by name, from the module databases that pvlib carries; read without pvlib, in a quarter of a second.

CEC: some 21 500 modules with the parameters of the single-diode model (Dobos 2012, DOI 10.1115/1.4005759). Sandia: some
500 with measured values at reference conditions, from which a data sheet is made (King, Boyson and Kratochvil 2004,
SAND2004-3535).
"""

from __future__ import annotations

import csv
import difflib
import importlib.util
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

from pydantic import Field

from pipeline.errors import UserError
from pipeline.panel.records import DatabaseName
from pipeline.record import Record

FILES: dict[DatabaseName, str] = {
    "cec": "sam-library-cec-modules-2019-03-05.csv",
    "sandia": "sam-library-sandia-modules-2015-6-30.csv",
}
TITLES: dict[DatabaseName, str] = {"cec": "CEC module database", "sandia": "Sandia module database"}
_PLAIN = str.maketrans(' -.()[]:+/",', "_" * 12)
_HEADINGS = 3
_CEC = (
    *("I_mp_ref", "V_mp_ref", "V_oc_ref", "I_sc_ref", "alpha_sc", "beta_oc", "gamma_r", "N_s"),
    *("I_L_ref", "I_o_ref", "R_s", "R_sh_ref", "a_ref", "Adjust"),
)


class PanelEntry(Record):
    """A panel that is known by its name."""

    database: DatabaseName = Field(description="which database its name is looked up in")
    name: str = Field(min_length=1, description="name of the panel there, as pvlib spells it")
    panels_in_series: int = Field(default=1, ge=1, description="panels in series [1]")
    panels_in_parallel: int = Field(default=1, ge=1, description="strings of panels in parallel [1]")


def names(database: DatabaseName) -> list[str]:
    """Return every name in a database."""
    return list(_rows(database))


def look_up(entry: PanelEntry) -> dict[str, Any]:
    """Return the fields of `pipeline.panel.records.Panel` for a panel known by name.

    Arguments
    ---------
    entry : database, name, number of panels.

    Raises
    ------
    UserError : no such name; the closest ones are named.
    """
    rows = _rows(entry.database)
    found = rows.get(entry.name) or rows.get(entry.name.translate(_PLAIN))
    if found is None:
        raise UserError(
            f"no panel {entry.name!r} among the {len(rows)} of the {TITLES[entry.database]}; {_near(entry, rows)}"
        )
    values = _of_cec(found) if entry.database == "cec" else _of_sandia(found)
    title = " ".join(found["Name"].split())
    return {
        "title": title,
        **values,
        "panels_in_series": entry.panels_in_series,
        "panels_in_parallel": entry.panels_in_parallel,
    }


def reference(entry: PanelEntry) -> str:
    """Return where the values of a panel known by name stand."""
    return f"{TITLES[entry.database]} in pvlib ({FILES[entry.database]}), {entry.name}"


def _of_cec(row: Mapping[str, str]) -> dict[str, Any]:
    value = {name: float(row[name]) for name in _CEC}
    return {
        "max_power_w": value["I_mp_ref"] * value["V_mp_ref"],
        "max_power_voltage_v": value["V_mp_ref"],
        "max_power_current_a": value["I_mp_ref"],
        "open_circuit_voltage_v": value["V_oc_ref"],
        "short_circuit_current_a": value["I_sc_ref"],
        "alpha_isc_a_per_k": value["alpha_sc"],
        "beta_voc_v_per_k": value["beta_oc"],
        "gamma_pmp_percent_per_k": value["gamma_r"],
        "cells_in_series": int(value["N_s"]),
        "single_diode": {
            "photocurrent_a": value["I_L_ref"],
            "saturation_current_a": value["I_o_ref"],
            "series_resistance_ohm": value["R_s"],
            "shunt_resistance_ohm": value["R_sh_ref"],
            "modified_ideality_v": value["a_ref"],
            "adjust_percent": value["Adjust"],
        },
    }


def _of_sandia(row: Mapping[str, str]) -> dict[str, Any]:
    current, voltage = float(row["Impo"]), float(row["Vmpo"])
    return {
        "max_power_w": current * voltage,
        "max_power_voltage_v": voltage,
        "max_power_current_a": current,
        "open_circuit_voltage_v": float(row["Voco"]),
        "short_circuit_current_a": float(row["Isco"]),
        "alpha_isc_a_per_k": float(row["Aisc"]) * float(row["Isco"]),
        "beta_voc_v_per_k": float(row["Bvoco"]),
        "gamma_pmp_percent_per_k": 100.0 * (float(row["Aimp"]) + float(row["Bvmpo"]) / voltage),
        "cells_in_series": int(float(row["Cells in Series"])),
    }


def _near(entry: PanelEntry, rows: Mapping[str, Any]) -> str:
    known = {name.lower(): name for name in rows}
    asked = entry.name.translate(_PLAIN).lower()
    near = [name for name in known if asked in name][:5]
    near = near or difflib.get_close_matches(asked, known, n=5, cutoff=0.5)
    if near:
        return "best matches are: " + ", ".join(known[name] for name in near)
    return f"none is close; names there look like {next(iter(rows))}"


@cache
def _rows(database: DatabaseName) -> dict[str, dict[str, str]]:
    """Return name as pvlib spells it -> row of the database; two rows follow the heading with units and SAM's names."""
    found = importlib.util.find_spec("pvlib")
    if found is None or not found.submodule_search_locations:
        raise UserError("the module databases come with pvlib, which is not installed")
    path = Path(found.submodule_search_locations[0]) / "data" / FILES[database]
    with path.open(encoding="utf-8", newline="") as file:
        lines = list(csv.reader(file))
    return {line[0].translate(_PLAIN): dict(zip(lines[0], line, strict=True)) for line in lines[_HEADINGS:]}
