"""Compiled kernels on a node's own disk: the jobs of a cluster load hundreds of small files from there, each once.

The cache that all machines share is filled by the first job of a run that compiles (the step `engine`); a node copies
what a step needs of it when its first job comes, and gives back what had to be compiled there.
"""

from __future__ import annotations

import os
import shutil
import stat
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from pipeline.kernel.code import closure, of_code
from pipeline.kernel.places import cache_root

_ASKED = "CHARGE_PIPELINE_CACHE"
_JOBS = ("SLURM_JOB_ID", "PBS_JOBID", "LSB_JOBID")
_shared: dict[str, Path] = {}


def on_a_cluster() -> bool:
    """Tell whether this process is a job of a batch system."""
    return any(os.environ.get(name) for name in _JOBS)


def bring(module: str) -> None:
    """Copy the kernels of a module and of all that it imports to this node's disk, and have them looked for there.

    Nothing is done outside a batch system, or where the node has no folder that is this user's alone.
    """
    near = _folder() if on_a_cluster() else None
    if near is None:
        return
    shared = cache_root()
    _shared["cache"] = shared
    for name in _folders(module):
        _copy(shared / "numba" / name, near / "numba" / name)
    os.environ[_ASKED] = str(near)


def give_back(module: str) -> None:
    """Copy kernels that were compiled on this node to the cache that all machines share."""
    shared = _shared.get("cache")
    if shared is None:
        return
    for name in _folders(module):
        _copy(cache_root() / "numba" / name, shared / "numba" / name)


def _folders(module: str) -> Iterator[str]:
    """Yield the names of the folders of kernels, as `pipeline.jit` has them."""
    for name in sorted(closure(module)):
        yield of_code(name)[:16]


def _folder() -> Path | None:
    """Return the folder of this user on the node's disk; None where it is not safe: kernels are code that is run."""
    folder = Path(os.environ.get("SLURM_TMPDIR") or tempfile.gettempdir()) / f"charge-pipeline-{os.getuid()}"
    try:
        folder.mkdir(mode=0o700, exist_ok=True)
        found = folder.lstat()
    except OSError:
        return None
    mine = stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid() and not found.st_mode & 0o077
    return folder if mine else None


def _copy(source: Path, target: Path) -> None:
    """Copy the files that are missing or older, each whole or not at all; an index after the kernels that it names."""
    with suppress(OSError):
        for path in sorted(source.iterdir(), key=lambda path: (path.suffix == ".nbi", path.name)):
            there = target / path.name
            if not path.is_file() or (there.exists() and there.stat().st_mtime_ns >= path.stat().st_mtime_ns):
                continue
            target.mkdir(parents=True, exist_ok=True)
            handle, name = tempfile.mkstemp(prefix=f".{path.name}.", dir=target)
            os.close(handle)
            shutil.copy2(path, name)
            Path(name).replace(there)
