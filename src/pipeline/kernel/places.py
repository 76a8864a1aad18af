"""Where the package, the project and the configuration lie, in a clone and where the package is installed."""

from __future__ import annotations

import os
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent.parent
_CLONE = PACKAGE.parent.parent
INSTALLED = (PACKAGE / "shipped").is_dir()
"""Whether the package was installed from a wheel, and is not a clone's."""
SHIPPED = PACKAGE / "shipped" if INSTALLED else _CLONE
"""Where conf/, workflow/, profiles/, Snakefile and lock file lie that come with the package."""


def _project() -> Path:
    """Return the folder of the project: a clone, or one that `init` made and that is worked in."""
    here = Path.cwd()
    made = (here / "conf").is_dir() and (here / "Snakefile").is_file() and not (here / "src" / "pipeline").is_dir()
    return here if INSTALLED or made else _CLONE


PROJECT = _project()


def place(name: str) -> Path:
    """Return a file or folder of the project, or the one that is shipped where the project has none of its own."""
    return PROJECT / name if (PROJECT / name).exists() else SHIPPED / name


def confs() -> tuple[Path, ...]:
    """Return the folders of configuration, the project's own first: what is in both is taken from there."""
    return tuple(dict.fromkeys(one / "conf" for one in (PROJECT, SHIPPED) if (one / "conf").is_dir()))


def cache_root() -> Path:
    """Return where kernels and facts of code are kept: as asked for, in the clone, or in the user's own cache."""
    asked = os.environ.get("CHARGE_PIPELINE_CACHE")
    if asked:
        return Path(asked)
    if not INSTALLED:
        return SHIPPED / ".cache"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "charge-pipeline"


LOCK_FILE = place("requirements.lock")
