"""What a file holds: opened, unpacked and decoded, whatever it was packed and encoded with."""

from __future__ import annotations

import bz2
import gzip
import io
import lzma
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from pipeline.errors import UserError, best_matches
from pipeline.own_files import digest
from pipeline.record import OwnFile, Record

MOST_BYTES = 1 << 30
"""What a file may come to when it is unpacked: a gibibyte, a year by the second in ten columns."""
_PACKED: tuple[tuple[bytes, str, Callable[[io.BytesIO], io.BufferedIOBase]], ...] = (
    (b"\x1f\x8b", "gzip", lambda raw: gzip.GzipFile(fileobj=raw)),
    (b"BZh", "bzip2", bz2.BZ2File),
    (b"\xfd7zXZ\x00", "xz", lzma.LZMAFile),
)
_ZIP, _OLD_EXCEL = b"PK\x03\x04", b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"
_MARKS = ((b"\xef\xbb\xbf", "utf-8-sig"), (b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16"))
_OTHERS = {
    b"\x89HDF": "a netCDF or HDF5 file",
    b"CDF\x01": "a netCDF file",
    b"CDF\x02": "a netCDF file",
    b"GRIB": "a GRIB file",
    b"%PDF": "a PDF file",
    _OLD_EXCEL: "an Excel file of before 2007",
    b"\x00\x01\x00\x00Standard ": "an Access database (an Arbin .res file is one)",
    b"SQLite format 3\x00": "an SQLite database",
    b"ARROW1": "an Arrow (Feather) file",
    b"\x93NUMPY": "a numpy file",
    b"\x80\x04\x95": "a Python pickle",
    b"\x89PNG": "a PNG picture",
    b"\xff\xd8\xff": "a JPEG picture",
}
_NAMED = {b"MATLAB": "a MATLAB file", b"BIO-LOGIC": "a BioLogic .mpr file", b"NEWARE": "a Neware .nda file"}
"""With zero bytes after the name; a table in text may begin with the name of what wrote it, too."""
_CONTROLS = bytes(set(range(32)) - set(b"\t\n\r\f\x1a\x1b"))
"""What no text holds; a form feed, the end mark of old systems and colours of a terminal it may."""


class Content(NamedTuple):
    """Bytes of a file, unpacked, its name without the ending of the packing, and what was found on the way."""

    path: Path
    name: str
    data: bytes
    said: tuple[str, ...] = ()


def load(path: Path, member: str | None = None) -> Content:
    """Return a file's bytes, unpacked.

    Arguments
    ---------
    path : the file; gzip, bzip2, xz and zip are told by their first bytes, not by its name.
    member : which file of a zip archive; the only one where not given.

    Raises
    ------
    UserError : no such file, no file at all, one that cannot be read or unpacked, an archive of several.
    """
    _refuse_no_file(path)
    try:
        data = path.read_bytes()
    except OSError as error:
        raise UserError(f"{path}: cannot be read ({error.strerror or error})") from None
    _refuse_others(path, data)
    for start, kind, opener in _PACKED:
        if data.startswith(start):
            name = path.name.removesuffix(path.suffix) if Path(path.stem).suffix else path.name
            inner = _unpacked(path, kind, opener(io.BytesIO(data)))
            _refuse_others(path, inner)
            return Content(path, name, inner, (f"packed with {kind}",))
    if data.startswith(_ZIP) and not is_excel(data):
        return _of_zip(path, data, member)
    return Content(path, path.name, data)


def is_excel(data: bytes) -> bool:
    """Tell whether bytes are an Excel workbook, which is a zip archive with a list of its parts."""
    if not data.startswith(_ZIP):
        return False
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            return any(name.startswith("xl/") for name in archive.namelist())
    except zipfile.BadZipFile:
        return False


def text_of(content: Content) -> tuple[str, tuple[str, ...]]:
    """Return the text and, where it is not plain UTF-8, how it was decoded.

    A mark of byte order decides; then UTF-16 where every other byte is zero; then UTF-8; then Latin-1 as in Windows.

    Raises
    ------
    UserError : bytes that are no text.
    """
    data = content.data
    for mark, encoding in _MARKS:
        if data.startswith(mark):
            return _decoded(content, encoding), () if encoding == "utf-8-sig" else ("encoded in UTF-16",)
    head = data[:4096]
    halves = {"utf-16-be": (head[::2], head[1::2]), "utf-16-le": (head[1::2], head[::2])}
    for encoding, (upper, lower) in halves.items():
        # Of a table in UTF-16 nearly all characters have an upper byte of zero, and none is zero.
        if len(head) > 3 and upper.count(0) > 0.8 * len(upper) and not lower.count(0):
            return _decoded(content, encoding), ("encoded in UTF-16 without a mark",)
    if 0 in head:
        raise UserError(f"{content.path}: no text, no Parquet and no Excel file: it holds zero bytes")
    if len(head) - len(head.translate(None, _CONTROLS)) > 0.01 * len(head):
        raise UserError(f"{content.path}: no text, no Parquet and no Excel file: it holds control characters")
    try:
        return data.decode("utf-8"), ()
    except UnicodeDecodeError:
        return data.decode("cp1252", errors="replace"), ("encoded in Latin-1 (Windows-1252)",)


def _refuse_others(path: Path, data: bytes) -> None:
    for start, kind in (_OTHERS | _NAMED if 0 in data[:1024] else _OTHERS).items():
        if data.startswith(start):
            raise UserError(f"{path}: is {kind}, which is not read; save it as CSV, Parquet or .xlsx")


def _refuse_no_file(path: Path) -> None:
    try:
        if path.is_file():
            return
        if path.is_dir():
            raise UserError(f"{path}: is a folder; give a file in it")
        if path.exists():
            raise UserError(f"{path}: is no ordinary file; save what it gives to one")
        beside = [one.name for one in path.parent.iterdir()] if path.parent.is_dir() else []
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise UserError(f"{str(path)[:200]}: cannot be opened ({reason})") from None
    near = best_matches(path.name, beside) if beside else ""
    raise UserError(f"{path}: no such file" + (f"; {near}" if near.startswith("best") else ""))


def _unpacked(path: Path, kind: str, file: io.BufferedIOBase) -> bytes:
    try:
        data = file.read(MOST_BYTES + 1)
    except (OSError, EOFError, lzma.LZMAError, zlib.error) as error:
        raise UserError(
            f"{path}: is packed with {kind} and cannot be unpacked ({error}); was it copied whole?"
        ) from None
    if len(data) > MOST_BYTES:
        raise UserError(f"{path}: comes to more than {MOST_BYTES >> 20} MiB unpacked; give a part of it")
    return data


def _of_zip(path: Path, data: bytes, member: str | None) -> Content:
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            held = [one for one in archive.namelist() if not one.endswith("/") and not one.startswith("__MACOSX")]
            if member is None and len(held) != 1:
                raise UserError(f"{path}: holds {len(held)} files, {', '.join(held[:9])}; choose one, sheet=NAME")
            if member is not None and member not in held:
                raise UserError(f"{path}: holds no {member!r}; {best_matches(member, held)}")
            chosen = held[0] if member is None else member
            with archive.open(chosen) as file:
                inner = _unpacked(path, "zip", file)  # type: ignore[arg-type]
        _refuse_others(path, inner)
    except (zipfile.BadZipFile, RuntimeError, NotImplementedError) as error:
        raise UserError(f"{path}: is a zip archive that cannot be unpacked ({error})") from None
    return Content(path, Path(chosen).name, inner, (f"{chosen} of a zip archive",))


def _decoded(content: Content, encoding: str) -> str:
    try:
        return content.data.decode(encoding)
    except UnicodeDecodeError as error:
        raise UserError(
            f"{content.path}: begins as {encoding} and goes on as something else ({error.reason})"
        ) from None


def settings(record: Record, name: str) -> dict[str, Any]:
    """Return a record as plain data under a name for its title; the sha256 of its file, where it has one, beside it."""
    found: dict[str, Any] = {**record.model_dump(mode="json", by_alias=True), "title": name}
    if isinstance(record, OwnFile):
        found["file_sha256"] = digest(Path(record.file))
    return found


def without_digest(found: Any) -> dict[str, Any]:
    """Return settings as the record takes them."""
    return {key: value for key, value in found.items() if key != "file_sha256"}
