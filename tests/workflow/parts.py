"""A copy of what a run of the project needs, for tests in an environment that may lack those of the others."""

from __future__ import annotations

import shutil
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PARTS = ("Snakefile", "workflow", "profiles", "conf", "src", "requirements.lock")


def copy_parts(folder: Path) -> None:
    """Copy what a run needs, as it is."""
    folder.mkdir(parents=True)
    for part in PARTS:
        source = ROOT / part
        if source.is_dir():
            shutil.copytree(source, folder / part, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy2(source, folder / part)
