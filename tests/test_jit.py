"""The cache of compiled kernels: one for all copies of the same sources, another after an edit anywhere below."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numba
import pytest

from pipeline.jit import Folder, cache_folder, kernel
from pipeline.kernel.places import PACKAGE

ASK = """
from pipeline.search import moves
moves.sine_squared(0.3)
found = moves.sine_squared.stats
print(sum(found.cache_hits.values()), sum(found.cache_misses.values()))
"""


@pytest.fixture
def cache(tmp_path: Path) -> Path:
    return tmp_path / "cache"


def asked(folder: Path, cache: Path) -> tuple[int, int]:
    """Return how many kernels a copy of the package found compiled, and how many it had to compile."""
    done = subprocess.run(
        [sys.executable, "-c", ASK],
        env=os.environ | {"PYTHONPATH": str(folder), "CHARGE_PIPELINE_CACHE": str(cache)},
        capture_output=True,
        text=True,
        check=True,
    )
    hits, misses = done.stdout.split()
    return int(hits), int(misses)


def copied(folder: Path) -> Path:
    """Copy the package with new time stamps."""
    shutil.copytree(
        PACKAGE, folder / "pipeline", ignore=shutil.ignore_patterns("__pycache__"), copy_function=shutil.copyfile
    )
    return folder


def test_copies_share_what_is_compiled_until_one_is_edited(tmp_path: Path, cache: Path) -> None:
    first, second = copied(tmp_path / "first"), copied(tmp_path / "second")
    assert asked(first, cache) == (0, 1)
    assert asked(second, cache) == (1, 0)
    file = second / "pipeline" / "search" / "moves.py"
    file.write_text(file.read_text().replace("_TERMS = 12", "_TERMS = 11"))
    assert asked(second, cache) == (0, 1)


def test_functions_of_others_are_not_kept_here() -> None:
    assert Folder.from_function(numba.njit, "") is None
    assert Folder.from_function(test_functions_of_others_are_not_kept_here, "") is None
    own = Folder.from_function(kernel, "")
    assert own is not None
    assert own.get_cache_path() == str(cache_folder("pipeline.jit"))
