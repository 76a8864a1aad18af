"""Compilation of the numerical kernels, with a cache that no edit can leave stale.

numba files a compiled function under the time stamp of its own module and never looks at the modules it calls.
The cache folder therefore carries a digest of every module that may hold a kernel.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numba
from numba.core import config

F = TypeVar("F", bound=Callable[..., Any])

KERNEL_ROOMS = ("cell", "charge", "converter", "panel", "search", "objective", "grnn")


def cache_folder() -> Path:
    """Return the folder of compiled kernels for the sources as they are now."""
    package = Path(__file__).parent
    digest = hashlib.sha256()
    for room in KERNEL_ROOMS:
        for module in sorted((package / room).rglob("*.py")):
            digest.update(module.relative_to(package).as_posix().encode())
            digest.update(module.read_bytes())
    root = os.environ.get("CHARGE_PIPELINE_CACHE") or str(package.parent.parent / ".cache")
    return Path(root) / "numba" / digest.hexdigest()[:16]


config.CACHE_DIR = str(cache_folder())


def jit(function: F) -> F:
    """Compile `function` without Python objects, IEEE arithmetic kept, the result cached on disk."""
    return numba.njit(cache=True, fastmath=False, error_model="numpy")(function)  # type: ignore[no-any-return]


# No Python objects, IEEE arithmetic kept, cached; and no counting of references, which allocation would need and which
# costs more than the arithmetic of a small kernel.
_KERNEL: dict[str, Any] = {"cache": True, "fastmath": False, "error_model": "numpy", "_nrt": False}


def kernel(function: F) -> F:
    """Compile a function that allocates nothing."""
    return numba.njit(**_KERNEL)(function)  # type: ignore[no-any-return]


def inlined(function: F) -> F:
    """Compile like `kernel`, into its callers: for the innermost functions, whose call would cost more than they do."""
    return numba.njit(**_KERNEL, forceinline=True)(function)  # type: ignore[no-any-return]
