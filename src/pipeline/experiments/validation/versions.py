"""Which of the independent codes are installed; light, for the plan asks."""

from __future__ import annotations

import re
import shutil
import subprocess
from importlib import metadata


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
