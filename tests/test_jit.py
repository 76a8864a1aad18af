"""The cache of compiled kernels: one for all copies of the same sources, another after an edit anywhere below."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numba
import numpy as np
import pytest
from numba.core.registry import cpu_target

from pipeline.jit import Folder, Types, cache_folder, inlined, kernel
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


@inlined
def half(x: float) -> float:
    return 0.5 * x


@kernel
def power_of_half(x: float, times: int) -> float:
    for _ in range(times):
        x = half(x)
    return x


@kernel
def descent(x: float, times: int) -> float:
    return power_of_half(x, 1) + power_of_half(x, 2) + power_of_half(x, times)


@numba.njit
def descent_of_another(x: float) -> float:
    return descent(x, 3)


def test_what_a_kernel_calls_is_translated_once_and_turned_into_machine_code_with_it() -> None:
    """Counted by numba itself: what a release of it does otherwise fails here."""
    assert descent(8.0, 3) == 4.0 + 2.0 + 1.0
    for part in (half, power_of_half):
        assert not part.overloads, "compiled for Python, which never called it"
        [found] = part.part.overloads.values()
        assert [one.name for one in found.library.get_defined_functions() if "cpython" in one.name] == []
        engine = cpu_target.target_context.codegen()._engine
        assert not engine.is_symbol_defined(found.fndesc.llvm_func_name)


def test_what_is_remembered_of_types_is_what_numba_says() -> None:
    assert descent(8.0, 3) == 7.0
    context = cpu_target.typing_context
    assert len(Types.known) > 1
    for (function, *args), found in Types.known.items():
        assert context.resolve_function_type(function, tuple(args), {}) == found


def test_what_is_part_of_a_kernel_can_be_called_by_python_too() -> None:
    assert descent(8.0, 3) == 7.0
    assert half(np.float64(3.0)) == 1.5
    assert power_of_half(8.0, 3) == 1.0
    assert len(half.part.overloads) == 1


def test_a_function_of_another_can_call_a_kernel_with_all_its_parts() -> None:
    assert descent_of_another(8.0) == 7.0


def test_a_kernel_from_the_cache_is_what_was_compiled(cache: Path) -> None:
    """It is kept as machine code alone: the second process has nothing to compile it from."""
    ask = """
import numpy as np
from pipeline.search.moves import sine_squared
print([float(sine_squared(x)).hex() for x in np.linspace(0.0, 3.0, 7)])
print(sum(sine_squared.stats.cache_hits.values()))
"""
    environment = os.environ | {"CHARGE_PIPELINE_CACHE": str(cache)}
    told = [
        subprocess.run([sys.executable, "-c", ask], env=environment, capture_output=True, text=True, check=True).stdout
        for _ in range(2)
    ]
    first, second = (one.splitlines() for one in told)
    assert first[0] == second[0]
    assert (first[1], second[1]) == ("0", "1")
