"""Compilation of the numerical kernels, with a cache that no edit can leave stale.

numba files a compiled function under the place and content of its own module and never looks at the modules it calls.
Each module's kernels therefore lie in a folder named by the digest of the module and of all that it imports, so that
copies of the project share what they have in common.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
import numpy as np
from numba.core import config
from numpy.typing import NDArray

from pipeline.kernel.code import of_code
from pipeline.kernel.places import cache_root

F = TypeVar("F", bound=Callable[..., Any])
_LOCATORS = f"{__name__}.Folder,UserProvidedCacheLocator,InTreeCacheLocator,UserWideCacheLocator,IPythonCacheLocator"


@cache
def cache_folder(module: str) -> Path:
    """Return the folder of a module's compiled kernels, for the sources as they are now."""
    return cache_root() / "numba" / of_code(module)[:16]


class Folder:
    """Where numba looks for the compiled form of a function of this package, by the content of its sources alone."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self._path = cache_folder(function.__module__)
        self._line = function.__code__.co_firstlineno

    @classmethod
    def from_function(cls, py_func: Callable[..., Any], py_file: str) -> Folder | None:
        """Return the place of a function; none for those of other packages."""
        return cls(py_func) if _ours(py_func) else None

    def ensure_cache_path(self) -> None:
        """Make the folder; raise `OSError` where nothing can be written there."""
        self._path.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=self._path).close()

    def get_cache_path(self) -> str:
        """Return the folder."""
        return str(self._path)

    def get_source_stamp(self) -> str:
        """Return what tells an older form from a newer one: nothing, since they lie in folders of their own."""
        return ""

    def get_disambiguator(self) -> str:
        """Return what tells functions of one name apart."""
        return str(self._line)


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
    keep = _ours(function)
    # numba reads this when a function is decorated.
    config.CACHE_LOCATOR_CLASSES = _LOCATORS  # type: ignore[attr-defined]
    # The nodes of a step stand side by side in memory: four of them are one operation.
    config.SLP_VECTORIZE = 1  # type: ignore[attr-defined]
    return {"cache": keep, "fastmath": False, "error_model": "numpy"}


def _ours(function: Callable[..., Any]) -> bool:
    return function.__module__.split(".")[0] == "pipeline"
