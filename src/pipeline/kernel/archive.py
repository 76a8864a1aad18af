"""What a job made as one file, for where results lie in a bucket: Snakemake carries it there and to who reads it.

An archive holds the artefacts of a chunk as they lie in the store; its bytes depend on theirs alone.
"""

from __future__ import annotations

import io
import shutil
import tarfile
import tempfile
from collections.abc import Collection, Iterator
from pathlib import Path, PurePosixPath

from pipeline.kernel import store

SUFFIX = ".tar"


def pack(results: Path, step: str, keys: Collection[str], archive: Path) -> None:
    """Write the artefacts of a step to an archive.

    Raises
    ------
    StoreError : one of them is not what was sealed.
    """
    archive.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(prefix=f".{archive.name}.", dir=archive.parent, delete=False) as file:
        temporary = Path(file.name)
        try:
            with tarfile.open(fileobj=file, mode="w", format=tarfile.USTAR_FORMAT) as tar:
                for key in sorted(keys):
                    folder = store.whole(results, step, key, f"archive {archive.name}")
                    for name in sorted([*store.contents(folder), store.CONTENTS]):
                        data = (folder / name).read_bytes()
                        entry = tarfile.TarInfo(f"{step}/{key}/{name}")
                        entry.size, entry.mode = len(data), 0o444
                        tar.addfile(entry, io.BytesIO(data))
            temporary.chmod(0o644)
            temporary.replace(archive)
        finally:
            temporary.unlink(missing_ok=True)


def unpack(results: Path, archive: Path) -> list[str]:
    """Put the artefacts of an archive into the store, those that are not there; return the keys of all.

    Raises
    ------
    StoreError : it is no archive of artefacts, or one in it is not what was sealed.
    """
    folder = Path(tempfile.mkdtemp(prefix="unpack-"))
    try:
        with tarfile.open(archive) as tar:
            for entry in tar:
                if not entry.isfile() or not _inside(entry.name):
                    raise store.StoreError(f"{archive}: {entry.name}: no file of an artefact")
                tar.extract(entry, folder, filter="data")
        return list(_put(results, folder, archive))
    except tarfile.TarError as error:
        raise store.StoreError(f"{archive}: no archive of artefacts ({error})") from error
    finally:
        store.remove(folder)


def _put(results: Path, folder: Path, archive: Path) -> Iterator[str]:
    for found in sorted(folder.glob("*/*")):
        fault = store.damage(found)
        if fault is not None:
            raise store.StoreError(f"{archive}: {fault}")
        sealed = store.contents(found)

        def copy(empty: Path, found: Path = found, names: Collection[str] = tuple(sealed)) -> None:
            for name in names:
                (empty / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(found / name, empty / name)

        store.make(results, found.parent.name, found.name, copy)
        yield found.name


def _inside(name: str) -> bool:
    parts = PurePosixPath(name).parts
    return len(parts) >= 3 and parts[0] != "/" and ".." not in parts
