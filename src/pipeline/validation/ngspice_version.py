"""Which ngspice is installed; light, for the plan asks."""

from __future__ import annotations

import re
import shutil
import subprocess


def version() -> str | None:
    """Return the version of the program ngspice, none without it."""
    program = shutil.which("ngspice")
    if program is None:
        return None
    told = subprocess.run([program, "--version"], capture_output=True, text=True, check=False).stdout
    found = re.search(r"ngspice-(\S+)", told)
    return found.group(1) if found else "unknown"
