"""Panels by name, from the module databases that pvlib carries; read without pvlib, in a quarter of a second.

CEC: some 21 500 modules with the parameters of the single-diode model (Dobos 2012, DOI 10.1115/1.4005759). Sandia: some
500 with measured values at reference conditions, from which a data sheet is made (King, Boyson and Kratochvil 2004,
SAND2004-3535).
"""

from __future__ import annotations

import csv
import difflib
import importlib.util
import math
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import Field

from pipeline.errors import UserError, best_matches
from pipeline.panel.records import DatabaseName
from pipeline.record import NOT_GIVEN, Record

FILES: dict[DatabaseName, str] = {
    "cec": "sam-library-cec-modules-2019-03-05.csv",
    "sandia": "sam-library-sandia-modules-2015-6-30.csv",
}
TITLES: dict[DatabaseName, str] = {"cec": "CEC module database", "sandia": "Sandia module database"}
PLAIN = str.maketrans(' -.()[]:+/",', "_" * 12)
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
    found = rows.get(entry.name) or rows.get(entry.name.translate(PLAIN))
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


_SHOWN = 6
_LEAST_SHARE = 0.3
"""Share of the weight of the words asked for that a name must have, to be offered."""


def _near(entry: PanelEntry, rows: Mapping[str, Any]) -> str:
    near = by_words(entry.name, rows)
    other: DatabaseName = "sandia" if entry.database == "cec" else "cec"
    there = ""
    if entry.name.translate(PLAIN) in _rows(other):
        there = f"; it stands in the {TITLES[other]}: panel.database={other}"
    elif not near:
        others = by_words(entry.name, _rows(other))[:_SHOWN]
        there = f"; near in the {TITLES[other]} (panel.database={other}): {', '.join(others)}" if others else ""
    if not near:
        return f"none is close{there}; names there look like {next(iter(rows))}"
    # Words that none of them has would find nothing.
    asked = " ".join(word for word in _words(entry.name) if all(word in name.lower() for name in near[:_SHOWN]))
    more = f" and {len(near) - _SHOWN} more: python -m pipeline panels {asked}" if len(near) > _SHOWN else ""
    return f"best matches are: {', '.join(near[:_SHOWN])}{more}{there}"


def by_words(asked: str, names: Iterable[str]) -> list[str]:
    """Return the names that have most of some words in them, as far as they have as much of it as the best.

    A word counts the more the fewer names have it; one that no name has counts as the one that is spelt most like it.

    Arguments
    ---------
    asked : words, divided by anything that is neither letter nor digit; capitals or not.
    names : those to choose from.
    """
    known = {name: set(_words(name)) for name in names}
    joined = {name: "_".join(_words(name)) for name in known}
    scores = dict.fromkeys(known, 0.0)
    whole = 0.0
    for word in dict.fromkeys(_words(asked)):
        weight, meant = 1.0, word
        found = [name for name, text in joined.items() if word in text]
        if not found:
            vocabulary = set().union(*known.values())
            close = difflib.get_close_matches(word, vocabulary, n=1, cutoff=0.75)
            weight, meant = (0.6, close[0]) if close else (0.0, word)
            found = [name for name, text in joined.items() if close and meant in text]
        rarity = math.log((1.0 + len(known)) / (1.0 + len(found)))
        whole += rarity
        for name in found:
            begins = any(part.startswith(meant) for part in known[name])
            share = 1.0 if meant in known[name] else 0.9 if begins else 0.7 if len(meant) > 2 else 0.0
            scores[name] += weight * share * rarity
    best = max(scores.values(), default=0.0)
    if best <= 0.0 or best < _LEAST_SHARE * whole:
        return []
    return [name for name in sorted(scores, key=lambda name: (-scores[name], name)) if scores[name] >= 0.8 * best]


def _words(text: str) -> list[str]:
    return re.findall(r"[a-z0-9]+", text.lower())


class Listed(NamedTuple):
    """A panel with its numbers at 1000 W/m2 and 25 degC."""

    name: str
    database: str
    max_power_w: float
    max_power_voltage_v: float
    max_power_current_a: float
    open_circuit_voltage_v: float
    short_circuit_current_a: float
    cells_in_series: int
    technology: str

    @classmethod
    def of(cls, name: str, where: str, values: Mapping[str, Any], technology: str) -> Listed:
        """Return a panel from the fields of its record."""
        return cls._make([name, where, *(values[field] for field in cls._fields[2:-1]), " ".join(technology.split())])


def listed(database: DatabaseName, words: Collection[str] = ()) -> Iterator[Listed]:
    """Yield the panels of a database that have some words in their names, in small letters; all of them without."""
    kind = "Technology" if database == "cec" else "Material"
    for name, row in _rows(database).items():
        if not all(word in name.lower() for word in words):
            continue
        values = _of_cec(row) if database == "cec" else _of_sandia(row)
        yield Listed.of(name, database, values, row[kind])


@cache
def _rows(database: DatabaseName) -> dict[str, dict[str, str]]:
    """Return name as pvlib spells it -> row of the database; two rows follow the heading with units and SAM's names."""
    found = importlib.util.find_spec("pvlib")
    if found is None or not found.submodule_search_locations:
        raise UserError("the module databases come with pvlib, which is not installed")
    path = Path(found.submodule_search_locations[0]) / "data" / FILES[database]
    with path.open(encoding="utf-8", newline="") as file:
        lines = list(csv.reader(file))
    return {line[0].translate(PLAIN): dict(zip(lines[0], line, strict=True)) for line in lines[_HEADINGS:]}


LEFT_OUT = ("alpha_isc_a_per_k", "beta_voc_v_per_k", "gamma_pmp_percent_per_k", "cells_in_series")
_STRINGS = (9, 18, 36, 40, 48, 54, 60, 66, 72, 80, 96, 120, 128, 144)
"""Numbers of cells in series that modules of crystalline silicon are made with; half cells are in two strings."""


class Usual(NamedTuple):
    """Values of a technology, each (5th percentile, median, 95th percentile) over a number of modules.

    Arguments
    ---------
    modules : how many.
    isc, voc, power : coefficients of the short-circuit current, open-circuit voltage, maximum power [%/K].
    cell_v : open-circuit voltage of a cell [V].
    """

    modules: int
    isc: tuple[float, float, float]
    voc: tuple[float, float, float]
    power: tuple[float, float, float]
    cell_v: tuple[float, float, float]


TECHNOLOGIES = {
    "crystalline_silicon": Usual(
        20946, (0.0240, 0.0512, 0.0945), (-0.4012, -0.3374, -0.2833), (-0.5271, -0.4502, -0.383), (0.600, 0.6255, 0.665)
    ),
    "mono_silicon": Usual(
        9725, (0.0193, 0.0500, 0.0860), (-0.4014, -0.3319, -0.2780), (-0.5328, -0.450, -0.370), (0.6037, 0.6306, 0.6783)
    ),
    "multi_silicon": Usual(
        11221, (0.0250, 0.0564, 0.1041), (-0.3998, -0.340, -0.299), (-0.5212, -0.4515, -0.400), (0.5994, 0.6222, 0.6485)
    ),
    "cadmium_telluride": Usual(
        20, (0.0550, 0.0560, 0.0570), (-0.2800, -0.2785, -0.2770), (-0.2610, -0.2525, -0.244), (0.8135, 0.8235, 0.8304)
    ),
}
"""CEC's Technology: Mono-c-Si and Multi-c-Si together, each alone, CdTe. Its thin films differ too much for one."""
DEFAULT = "crystalline_silicon"


def completed(values: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, dict[str, Any]]]:
    """Return a data sheet with usual values in the place of those it leaves out, and their sources.

    Arguments
    ---------
    values : fields of `pipeline.panel.records.Panel`, without some of LEFT_OUT, perhaps with `technology`, a key of
        TECHNOLOGIES; crystalline silicon where it is not there.

    Returns
    -------
    The fields without `technology`; name of each value that was put in -> its source, an estimate with its range.

    Raises
    ------
    UserError : an unknown technology.
    """
    given = {key: value for key, value in values.items() if key != "technology"}
    technology = values.get("technology") or DEFAULT
    if technology not in TECHNOLOGIES:
        raise UserError(f"technology: value {technology!r}; {best_matches(str(technology), TECHNOLOGIES)}")
    current: Any = given.get("short_circuit_current_a")
    voltage: Any = given.get("open_circuit_voltage_v")
    if not _is_positive(current) or not _is_positive(voltage):
        return given, {}  # the record says what is wrong with it
    found = _usual(TECHNOLOGIES[technology], float(current), float(voltage))
    absent = [name for name in LEFT_OUT if given.get(name) is None]
    sources = {}
    for name in absent:
        low, given[name], high = found[name]
        sources[name] = {
            "kind": "estimate",
            "ref": f"{NOT_GIVEN}: usual for {technology.replace('_', ' ')}, the median of "
            f"{TECHNOLOGIES[technology].modules} modules of the CEC database (in pvlib); nine of ten lie in the range",
            "range": [low, high],
        }
    return given, sources


def _usual(one: Usual, current_a: float, voltage_v: float) -> dict[str, tuple[float, float, float]]:
    """Return lowest, usual and highest value of each field, in its own unit."""
    low_v, median_v, high_v = one.cell_v
    likely = voltage_v / median_v
    cells = min(_STRINGS, key=lambda cells: (abs(cells - likely), cells)) if median_v < 0.75 else max(1, round(likely))
    if abs(cells - likely) > 0.08 * likely:
        cells = max(1, round(likely))
    alpha = [share / 100.0 * current_a for share in one.isc]
    beta = [share / 100.0 * voltage_v for share in one.voc]
    return {
        "alpha_isc_a_per_k": (alpha[0], alpha[1], alpha[2]),
        "beta_voc_v_per_k": (beta[0], beta[1], beta[2]),
        "gamma_pmp_percent_per_k": one.power,
        "cells_in_series": (min(cells, int(voltage_v / high_v)), cells, max(cells, round(voltage_v / low_v))),
    }


def _is_positive(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and value > 0
