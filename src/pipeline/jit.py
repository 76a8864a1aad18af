"""Compilation of the numerical kernels, with a cache that no edit can leave stale.

numba files a compiled function under the time stamp of its own module and never looks at the modules it calls.
Each module's kernels therefore lie in a folder named by the digest of the module and of all that it imports.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
import numpy as np
from numba.core import config
from numpy.typing import NDArray

from pipeline import digest

F = TypeVar("F", bound=Callable[..., Any])


@cache
def cache_folder(module: str) -> Path:
    """Return the folder of a module's compiled kernels, for the sources as they are now."""
    root = Path(os.environ.get("CHARGE_PIPELINE_CACHE") or digest.PROJECT / ".cache")
    return root / "numba" / digest.of_code(module)[:16]


def jit(function: F) -> F:
    """Compile `function` without Python objects, IEEE arithmetic kept, the result cached on disk."""
    return _compile(function)


def kernel(function: F) -> F:
    """Compile a function that allocates nothing.

    Without the counting of references, which allocation would need and which costs more than a small kernel's work;
    Python's lock is let go while it runs, so that threads run several at once.
    """
    return _compile(function, _nrt=False, nogil=True)


def inlined(function: F) -> F:
    """Compile like `kernel`, into its callers: for the innermost functions, whose call would cost more than they do."""
    return _compile(function, _nrt=False, forceinline=True)


def new_record(fields: np.dtype[Any], alignment: int = 1) -> Any:
    """Return a record of zeros, the first byte of it on a multiple of `alignment`; its fields are attributes too."""
    room = np.zeros(fields.itemsize + alignment - 1, dtype=np.uint8)
    begin = -room.ctypes.data % alignment if alignment > 1 else 0
    return room[begin : begin + fields.itemsize].view(np.dtype((np.record, fields)))[0]


def by_reference(record: Any) -> NDArray[Any]:
    """Return the array of one that a record stands in: a kernel takes that thirty times as fast as the record."""
    return cast("NDArray[Any]", record.base)


@cache
def by_address(signature: Any, function: Callable[..., None]) -> Any:
    """Compile a function of one signature, to be handed to a kernel: all functions of a signature are of one type."""
    return numba.cfunc(signature, **_settings(function))(function)


def _compile(function: F, **options: bool) -> F:
    settings = _settings(function) | options
    return cast(F, numba.njit(**settings)(function))


def _settings(function: Callable[..., Any]) -> dict[str, Any]:
    # Functions of other places (a notebook, a test) are compiled but not kept.
    keep = function.__module__.split(".")[0] == "pipeline"
    if keep:
        # numba reads the folder when a function is decorated.
        config.CACHE_DIR = str(cache_folder(function.__module__))  # type: ignore[attr-defined]
    # The nodes of a step stand side by side in memory: four of them are one operation.
    config.SLP_VECTORIZE = 1  # type: ignore[attr-defined]
    return {"cache": keep, "fastmath": False, "error_model": "numpy"}
