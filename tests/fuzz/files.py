"""Wrong data files, for every place of a configuration that names one: contents, cells, formats, no files."""

from __future__ import annotations

import gzip
import io
import os
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from tests.files import makers

PLACES = {
    "weather.file": ("study=solar_reflex", "weather=measured"),
    "day.weathers.clear.file": ("study=solar_reflex", "weather@day.weathers.clear=measured"),
    "day.load.file": ("study=solar_reflex", "load@day.load=measured"),
    "network.data.table": ("study=nicd_grnn",),
    "measured.file": ("study=own_battery",),
}
"""Key path that names a file of a person -> the other words of the command line. A test holds that it is complete."""
_HOURS = [f"2015-06-20T{hour:02d}:00:00" for hour in range(24)]
TABLES = {
    "weather.file": "time,irradiance_w_m2,ambient_c\n"
    + "".join(f"{at},{max(0, 800 - 80 * abs(hour - 12))},20.5\n" for hour, at in enumerate(_HOURS)),
    "day.load.file": "time,power_w\n" + "".join(f"{hour:02d}:00,{hour + 1.5}\n" for hour in range(24)),
    "network.data.table": "temperature_c,gradient,rate_c\n"
    + "".join(f"{t},{g},{8 - 0.1 * t - g}\n" for t in range(0, 50, 5) for g in (0.0, 0.5, 1.0)),
}
# A cell of 8 Ah on a cycler: charged at half its capacity for ten minutes at a time, with rests of the same length.
TABLES["measured.file"] = "time_s,voltage_v,current_a,temperature_c\n" + "".join(
    f"{10 * row},{3.2 + 0.0008 * (row // 2) + 0.03 * (row // 60 % 2):.4f},{4.0 * (row // 60 % 2)},25.0\n"
    for row in range(240)
)
TABLES["day.weathers.clear.file"] = TABLES["weather.file"]
FORMATS = ("epw", "psm", "pvgis_hourly", "pvgis_tmy", "pvgis_tmy_json", "cams", "midc", "surfrad", "pvwatts")
FORMATS += ("open_meteo", "solargis", "solcast", "nasa_power", "dwd")


@dataclass(frozen=True)
class WrongFile:
    """A wrong file.

    Arguments
    ---------
    kind : what is wrong with it.
    place : the key path that names it.
    name : of the file.
    make : writes it, or what stands in its place.
    sure : whether nobody could take it for a right one.
    """

    kind: str
    place: str
    name: str
    make: Callable[[Path], None]
    sure: bool

    def words(self, file: Path) -> list[str]:
        """Return the command line that names it."""
        return [*PLACES[self.place], f"{self.place}={file}"]


def _bytes(data: bytes) -> Callable[[Path], None]:
    return lambda path: path.write_bytes(data) and None


def _text(text: str, encoding: str = "utf-8") -> Callable[[Path], None]:
    return _bytes(text.encode(encoding, errors="replace"))


CELLS = {
    "a word": "nonesuch",
    "far too large": "1e300",
    "large": "1e30",
    "far below": "-1e6",
    "no number": "nan",
    "infinity": "inf",
    "full-width digits": "１２",
    "digits of another script": "٣",
    "underscores": "1_0",
    "a truth value": "true",
    "empty": "",
    "a formula": "=1+1",
    "two numbers": "1 2",
    "year 1 in universal time": "0001-01-01T00:00:00Z",
    "year 9999 in universal time": "9999-12-31T23:59:59Z",
    "year 9999 with an offset": "9999-12-31T23:59:59-14:00",
    "a day that is none": "2015-02-30T00:00:00",
    "an hour that is none": "2015-06-20T25:61:00",
    "a long word": "x" * 5000,
    "a zero byte": "1\x002",
    "markup": "<script>{{7*7}}</script>",
}
_IN_NUMBERS = set(CELLS) - {"empty", "no number"}


def _in_cells(place: str, rng: np.random.Generator) -> Iterator[WrongFile]:
    rows = [line.split(",") for line in TABLES[place].splitlines()]
    for kind, cell in CELLS.items():
        for column in range(len(rows[0])):
            changed = [list(row) for row in rows]
            changed[int(rng.integers(2, len(rows) - 2))][column] = cell
            text = "\n".join(map(",".join, changed)) + "\n"
            sure = column > 0 and kind in _IN_NUMBERS and place != "day.load.file"
            yield WrongFile(f"cell: {kind}", place, "own.csv", _text(text), sure)


def _in_lines(place: str, rng: np.random.Generator) -> Iterator[WrongFile]:
    lines = TABLES[place].splitlines()
    heading, rows = lines[0], lines[1:]
    middle = int(rng.integers(2, len(rows) - 2))
    names = heading.split(",")
    ways = {
        "a value too many": ([heading, *rows[:middle], rows[middle] + ",7", *rows[middle + 1 :]], True),
        "a value too few": ([heading, *rows[:middle], rows[middle].rpartition(",")[0], *rows[middle + 1 :]], True),
        "no headings": (rows, False),
        "headings alone": ([heading], True),
        "one row": (lines[:2], place != "day.load.file"),
        "a row twice": ([heading, *rows[:middle], rows[middle], *rows[middle:]], place == "network.data.table"),
        "rows backwards": ([heading, *rows[::-1]], False),
        "a heading twice": ([",".join([names[1], *names[1:]]), *rows], True),
        "no first column": ([line.partition(",")[2] for line in lines], False),
        "no last column": ([line.rpartition(",")[0] for line in lines], True),
        "unknown headings": ([",".join(f"{name}_nonesuch" for name in names), *rows], False),
        "semicolons in one row": ([heading, *rows[:middle], rows[middle].replace(",", ";"), *rows[middle + 1 :]], True),
        "an open quote": ([heading, *rows[:middle], '"' + rows[middle], *rows[middle + 1 :]], False),
        "a line of a million letters": ([heading, *rows[:middle], "x" * 1_000_000, *rows[middle:]], False),
        "half of it": ([TABLES[place][: len(TABLES[place]) // 2]], False),
    }
    for kind, (written, sure) in ways.items():
        yield WrongFile(f"lines: {kind}", place, "own.csv", _text("\n".join(written) + "\n"), sure)


def _as_bytes(place: str, rng: np.random.Generator) -> Iterator[WrongFile]:
    good = TABLES[place].encode()
    packed = gzip.compress(good)
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w") as several:
        several.writestr("a.csv", good)
        several.writestr("b.csv", good)
    ways = {
        "nothing": b"",
        "spaces": b" \n \n",
        "zero bytes": bytes(1000),
        "random bytes": rng.bytes(3000),
        "a packed file cut short": packed[: len(packed) // 2],
        "a packed file damaged": packed[:20] + bytes([packed[20] ^ 255]) + packed[21:],
        "an archive of several": archive.getvalue(),
        "an archive cut short": archive.getvalue()[:60],
        "an archive alone in name": b"PK\x03\x04" + rng.bytes(200),
        "Parquet in name": b"PAR1" + rng.bytes(200) + b"PAR1",
        "Parquet cut short": _parquet({"time": ["00:00"]})[:-9],
        "a PDF": b"%PDF-1.7\n" + rng.bytes(100),
        "JSON": b'{"a": [1, 2]}',
        "JSON cut short": b'{"a": [1, ',
        "markup": b"<html><body>no table</body></html>",
        "an old workbook": b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + rng.bytes(100),
        "HDF": b"\x89HDF\r\n\x1a\n" + rng.bytes(100),
        "a packed file of nothing": b"\x1f\x8b" + bytes(50),
    }
    for kind, data in ways.items():
        yield WrongFile(f"bytes: {kind}", place, "own.csv", _bytes(data), True)
    yield WrongFile(
        "bytes: UTF-16 without a mark, odd", place, "own.csv", _bytes(good.decode().encode("utf-16-le")[:-1]), False
    )
    yield WrongFile("bytes: a right file named Parquet", place, "own.parquet", _bytes(good), True)


def _parquet(columns: dict[str, object]) -> bytes:
    target = io.BytesIO()
    pq.write_table(pa.table(columns), target)
    return target.getvalue()


def _as_parquet(place: str, rng: np.random.Generator) -> Iterator[WrongFile]:
    lines = [line.split(",") for line in TABLES[place].splitlines()]
    names, count = lines[0], len(lines) - 1
    columns = {name: [line[at] for line in lines[1:]] for at, name in enumerate(names)}
    hours = np.arange(count, dtype=np.int64)
    odd: dict[str, object] = {
        "truth values": pa.array([True] * count),
        "lists": pa.array([[1.0, 2.0]] * count),
        "mappings": pa.array([{"a": 1}] * count),
        "bytes": pa.array([b"\xff\x00"] * count),
        "nothing": pa.nulls(count),
        "infinities": pa.array([float("inf")] * count),
        "times of year 190000": pa.array(hours * 3600 + 5_900_000_000_000, pa.timestamp("s")),
        "times before year 1": pa.array(hours * 3600 - 90_000_000_000, pa.timestamp("s", tz="UTC")),
        "times of an unknown zone": pa.array(hours * 3600, pa.timestamp("s", tz="Mars/Olympus")),
        "times of an odd offset": pa.array(hours * 3600, pa.timestamp("s", tz="+99:99")),
        "the latest nanoseconds": pa.array(np.full(count, 2**63 - 1), pa.timestamp("ns", tz="UTC")),
        "the earliest milliseconds": pa.array(np.full(count, -(2**63) + 1), pa.timestamp("ms")),
        "dates": pa.array(np.full(count, 2**31 - 1, dtype=np.int32), pa.date32()),
        "times of day": pa.array(hours, pa.time64("us")),
        "durations": pa.array(hours, pa.duration("s")),
        "large integers": pa.array(np.full(count, 2**63 - 1)),
        "decimals": pa.array([1] * count).cast(pa.decimal128(38, 10)),
        "categories": pa.array(["a"] * count).dictionary_encode(),
    }
    for kind, values in odd.items():
        for name in names:
            data = _parquet(columns | {name: values})
            sure = name != names[0] and kind not in ("decimals", "nothing") and place != "day.load.file"
            yield WrongFile(f"Parquet: {kind}", place, "own.parquet", _bytes(data), sure)
    yield WrongFile("Parquet: no rows", place, "own.parquet", _bytes(_parquet({name: [] for name in names})), True)
    yield WrongFile("Parquet: no columns", place, "own.parquet", _bytes(_parquet({})), True)


def _folder(path: Path) -> None:
    path.mkdir()


def _pipe(path: Path) -> None:
    os.mkfifo(path)


def _link(target: str) -> Callable[[Path], None]:
    return lambda path: path.symlink_to(target)


def _nothing(path: Path) -> None:
    return


def _no_files(place: str, rng: np.random.Generator) -> Iterator[WrongFile]:
    ways = {
        "a folder": _folder,
        "a pipe": _pipe,
        "a device without end": _link("/dev/zero"),
        "a link to nothing": _link("nothing"),
        "a link to itself": _link("own.csv"),
        "not there": _nothing,
    }
    for kind, make in ways.items():
        yield WrongFile(f"no file: {kind}", place, "own.csv", make, True)
    yield WrongFile("no file: a name of 5000 letters", place, "x" * 5000, _nothing, True)


def _formats(place: str, rng: np.random.Generator) -> Iterator[WrongFile]:
    """Damage the formats of weather services, which have readers of their own."""
    if place != "weather.file":
        return
    for name in FORMATS:
        good = getattr(makers, name)()
        text = good if isinstance(good, str) else good.decode()
        lines = text.splitlines(keepends=True)
        for kind in (
            "cut short",
            "a line left out",
            "letters changed",
            "numbers gone",
            "numbers large",
            "heading alone",
        ):
            at = int(rng.integers(1, max(2, len(lines))))
            letters = list(text)
            for place_of in rng.integers(0, len(letters), 20):
                letters[place_of] = chr(int(rng.integers(32, 127)))
            made = {
                "cut short": text[: int(rng.integers(1, len(text)))],
                "a line left out": "".join(lines[: at - 1] + lines[at:]),
                "letters changed": "".join(letters),
                "numbers gone": "".join(lines[:at] + ["x" + line[1:] for line in lines[at:]]),
                "numbers large": text.replace("20.5", "2e300"),
                "heading alone": "".join(lines[: min(9, at)]),
            }[kind]
            yield WrongFile(f"{name}: {kind}", place, "own.json" if "json" in name else "own.csv", _text(made), False)


def wrong(seed: int) -> Iterator[WrongFile]:
    """Yield every wrong file once, in an order that the seed gives."""
    rng = np.random.default_rng(seed)
    makers_of = (_in_cells, _in_lines, _as_bytes, _as_parquet, _no_files, _formats)
    everything = [one for place in PLACES for make in makers_of for one in make(place, rng)]
    for at in rng.permutation(len(everything)):
        yield everything[at]
