"""The checks of `make validate`, in the order of the page.

To add one: a module here with `check(settings) -> Found`, whose rows are made by `records.at_most`, `records.at_least`
or, for a number without a bound, `records.Row`, and whose curves may be empty; and an entry in `CHECKS`. Nothing else:
its node, its job, its part of the page and of the exit code follow, and all curves of a check are drawn where a card in
`conf/report/validation.yaml` names it under `options.check`. A check that wants settings gets the part of the
configuration's `validation` that its entry names; `rows` without a value (None) count as `not installed`.
"""

from __future__ import annotations

import re
import shutil
import subprocess
from importlib import metadata
from typing import NamedTuple

from pipeline.kernel.tables import Column, Table, TableFile


class Check(NamedTuple):
    """A check: its title, what it does in a few sentences, and what it takes.

    `settings` names a part of the record `Validation`; `peer` the code that it needs beside the project's own.
    """

    title: str
    text: str
    settings: str | None = None
    peer: str | None = None


_COMMON = (
    "The common model is the lead-acid battery without acceptance, side reaction and entropy: a straight open-circuit "
    "voltage, a series resistance linear in SOC, two pairs, a lump of heat. The engine runs at a tolerance of 1e-9; "
    "lines show the largest difference in each of 300 stretches of a charge."
)

CHECKS: dict[str, Check] = {
    "exact": Check(
        "Exact solutions",
        "Charges of a plain cell that can be written down, at the default tolerance. What is linear in the engine must "
        "keep to rounding; cooling is integrated. Each is run by both drivers: steady by edge, in pulses by averaged.",
    ),
    "order": Check(
        "Order of convergence",
        "The error of each driver against the length of its steps or strides at a loose tolerance, and against the "
        "tolerance alone. Edge: SOC under a held voltage. Averaged: temperature under 19 200 pulses with cooling.",
    ),
    "first_law": Check(
        "First law",
        "Electrical energy less every change of a state function less the heat given off, over the electrical energy, "
        "for every battery and mode. Then mistakes put in, computed anew: the residual must show each of them.",
        settings="first_law",
    ),
    "against_pybamm": Check(
        "Against PyBaMM",
        f"PyBaMM's Thevenin model, solved by IDAKLU at 1e-9. {_COMMON} PyBaMM counts i v of a pair as heat, with "
        "what its capacitor stores; here it is v\u00b2/R. So its temperature is compared with pairs that dissipate "
        "v\u00b2/R, and as shipped, where the difference must be that of the energy stored.",
        settings="peers",
        peer="pybamm",
    ),
    "against_ngspice": Check(
        "Against ngspice",
        f"A generated deck in which SOC and temperature are nodes, with heat as it is here. {_COMMON}",
        settings="peers",
        peer="ngspice",
    ),
    "panel_checks": Check(
        "The panel against pvlib",
        "Maximum power of modules drawn by a fixed seed from the CEC database, at random irradiances from 20 to "
        "1200 W/m\u00b2 and cells from -20 to 80 \u00b0C, against pvlib's bracketed solver; and a clear day, minute by "
        "minute, from the place of the sun to the power through the rooms that a day in the sun goes through, against "
        "the DC output of its ModelChain from its own clear sky. Then mistakes put in, which the day must show.",
    ),
}


def module_name(name: str) -> str:
    """Return the module of a check."""
    return f"pipeline.experiments.validation.{name}"


VALIDATION_ROWS = Table(
    "validation_rows",
    "What a check of the engine finds, a row per quantity",
    (
        Column("quantity", "", "what was computed", "text"),
        Column("value", "see unit", "its value; empty where it could not be computed here", optional=True),
        Column("unit", "", "its unit", "text"),
        Column("relation", "", "at most, at least, or empty where there is no bound", "text", optional=True),
        Column("bound", "see unit", "what it is held to", optional=True),
        Column("finding", "", "holds, broken, not installed, or told where there is no bound", "text"),
        Column("note", "", "what must be known to read it", "text"),
    ),
)
VALIDATION_CURVES = Table(
    "validation_curves",
    "Errors and differences of a check of the engine, a row per point",
    (
        Column("group", "", "field that the line is drawn in", "text"),
        Column("series", "", "name of the line", "text"),
        Column("across", "", "what x is, with its unit", "text"),
        Column("up", "", "what y is, with its unit", "text"),
        Column("x", "see across", "in the unit that `across` names"),
        Column("y", "see up", "in the unit that `up` names"),
    ),
)

VALIDATION = {
    "rows": TableFile("rows.parquet", VALIDATION_ROWS),
    "curves": TableFile("curves.parquet", VALIDATION_CURVES),
}
"""What a check writes."""


def installed(peer: str) -> str | None:
    """Return the version of a code, `pybamm` or `ngspice`, that is installed here; none without it."""
    return {"pybamm": pybamm, "ngspice": ngspice}[peer]()


def pybamm() -> str | None:
    """Return the version of PyBaMM, none without it; nothing of it is imported."""
    try:
        return metadata.version("pybamm")
    except metadata.PackageNotFoundError:
        return None


def ngspice() -> str | None:
    """Return the version of the program ngspice, none without it."""
    program = shutil.which("ngspice")
    if program is None:
        return None
    told = subprocess.run([program, "--version"], capture_output=True, text=True, check=False).stdout
    found = re.search(r"ngspice-(\S+)", told)
    return found.group(1) if found else "unknown"
