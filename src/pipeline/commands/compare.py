"""`python -m pipeline compare A B`: reads two published runs, or sweeps, and says where their artefacts differ."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pipeline.commands import Parser, as_typed, typed
from pipeline.errors import UserError, best_matches
from pipeline.kernel import digest, publish
from pipeline.kernel.store import REPORTS, RESULTS

MOST = 5
"""Names of one side alone that are told."""
LONGEST_NAME = 100
"""Letters of the name of a row; what is longer explains one."""
Columns = Mapping[str, list[Any]]


@dataclass(frozen=True)
class Listed:
    """An artefact as a manifest lists it: where it lies, the sha256 it had when published, and what it is a file of."""

    path: Path
    sha256: str
    step: str = ""
    file: str = ""


def main(arguments: Sequence[str]) -> int:
    """Compare two runs or sweeps, or all of two results folders; return 0 where all artefacts are equal, else 1."""
    parser = Parser(prog=typed("compare"), description=as_typed(__doc__ or ""))
    parser.add_argument("first", type=Path, help="study/run, the folder of a run or sweep, or a results folder")
    parser.add_argument("second", type=Path, help="the other one")
    parser.add_argument("--trust-manifest", action="store_true", help="compare the manifests, read no artefact")
    options = parser.parse_args(arguments)
    first, second = artefacts(placed(options.first)), artefacts(placed(options.second))
    both = sorted(first.keys() & second.keys())
    if options.trust_manifest:
        told = {
            place: ["sha256 in the manifests differ"] * (first[place].sha256 != second[place].sha256) for place in both
        }
    else:
        told = {place: list(faults(first[place], second[place])) for place in both}
    differing = [place for place in both if told[place]]
    for place in differing:
        print(f"differs   {place}")
        for line in told[place]:
            print(f"          {line}")
    single = 0
    for name, here, there in ((options.first, first, second), (options.second, second, first)):
        for place in sorted(here.keys() - there.keys()):
            single += 1
            print(f"only in {name}: {place}")
            if not options.trust_manifest and (fault := damage(here[place])):
                print(f"          {fault}")
    print(f"{len(both) - len(differing)} artefacts equal, {len(differing)} differ, {single} on one side only")
    if options.trust_manifest:
        print("manifests only (--trust-manifest): no artefact was read")
    return 1 if differing or single else 0


def placed(words: Path) -> Path:
    """Return the folder that words name: itself, or `study/run` of the results here, or a study's run `default`.

    Raises
    ------
    UserError : no such folder, and no run of this name.
    """
    name = shortened(words)
    folder = RESULTS / (name if "/" in name else f"{name}/default")
    found = next((one for one in (words, folder) if _manifests(one)), words)
    if not found.exists():
        known = {path.parent.relative_to(RESULTS).as_posix() for path in publish.manifests(RESULTS)}
        raise UserError(f"{words}: no such folder, and no run of this name; {best_matches(name, known)}")
    return found


def shortened(words: str | Path) -> str:
    """Return the name of a run, `study/run`, where its folder was given too."""
    return Path(words).as_posix().removeprefix(f"{RESULTS}/").removeprefix(f"{REPORTS}/").strip("/")


def _manifests(folder: Path) -> list[Path]:
    """Return the manifests of a run, else of all runs and sweeps of a study, else of a results folder."""
    of_study = (path for pattern in ("*", "sweeps/*") for path in folder.glob(f"{pattern}/manifest*.json"))
    return sorted(folder.glob("manifest*.json")) or sorted(of_study) or publish.manifests(folder)


def artefacts(folder: Path) -> dict[str, Listed]:
    """Return place -> artefact of every file that the manifests in a folder list, those of parts (`-t`) included.

    Arguments
    ---------
    folder : of a run or a sweep, of all runs and sweeps of a study, or a results folder.

    Raises
    ------
    UserError : no manifest there, or one that is damaged.
    """
    paths = _manifests(folder)
    if not paths:
        raise UserError(f"{folder}: no manifest.json there; allowed is the folder of a run or sweep, or results")
    found: dict[str, Listed] = {}
    for path in paths:
        room = path.parent.relative_to(folder)
        found |= {(room / place).as_posix(): one for place, one in manifest(path)["artefacts"].items()}
    return found


def manifest(path: Path) -> dict[str, Any]:
    """Read a manifest, its `artefacts` by their places in the run; raise `UserError` where it is none."""
    try:
        read: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        # The run of a sweep is `sweeps/NAME`, a folder deeper than others.
        view = Path(read["study"], read["run"])
        results = path.absolute().parents[len(view.parts)]
        found = {}
        for entry in read["artefacts"]:
            place = Path(entry["path"])
            room = place.parts[0]
            file = _on_disk(results, place)
            listed = Listed(file, entry["sha256"], entry.get("step", ""), entry.get("file", ""))
            found[(room / place.relative_to(room / view)).as_posix()] = listed
        return {**read, "artefacts": found}
    except (OSError, ValueError, KeyError, TypeError, IndexError, AttributeError) as error:
        raise UserError(f"{path}: not a manifest ({error}); run the study again, which writes it anew") from None


def damage(listed: Listed) -> str | None:
    """Return what is wrong with a file on disk, compared with its own manifest, or None."""
    if not listed.path.is_file():
        return f"missing: {listed.path}"
    if digest.of_file(listed.path) != listed.sha256:
        return f"not what its manifest lists ({listed.path.stat().st_size} bytes): {listed.path}"
    return None


def faults(first: Listed, second: Listed) -> Iterator[str]:
    """Yield what is wrong with either file and, where both can be read and differ, where they differ first."""
    found = [fault for one in (first, second) if (fault := damage(one))]
    yield from found
    if not (first.path.is_file() and second.path.is_file()):
        return
    if digest.of_file(first.path) != digest.of_file(second.path):
        yield from _differences(first.path, second.path)


def _differences(first: Path, second: Path) -> Iterator[str]:
    if first.suffix == ".parquet":
        yield from _table_differences(first, second)
        return
    here, there = first.read_bytes(), second.read_bytes()
    at = next((i for i, (a, b) in enumerate(zip(here, there, strict=False)) if a != b), min(len(here), len(there)))
    line = here[:at].count(b"\n") + 1
    yield f"first difference at byte {at}, line {line}; {len(here)} and {len(there)} bytes"


def _table_differences(first: Path, second: Path) -> Iterator[str]:
    import pyarrow as pa
    import pyarrow.parquet as pq

    tables = []
    for path in (first, second):
        try:
            tables.append(pq.ParquetFile(path).read())
        except (pa.ArrowException, OSError) as error:
            yield f"{path}: not a readable table ({str(error).splitlines()[0]})"
    if len(tables) < 2:
        return
    here, there = tables
    yield from _one_sided("columns", here.column_names, there.column_names)
    if here.num_rows != there.num_rows:
        yield f"{here.num_rows} and {there.num_rows} rows"
    common = [name for name in here.column_names if name in there.column_names]
    ours, theirs = ({name: table[name].to_pylist() for name in common} for table in tables)
    names, pairs = _paired(ours, theirs)
    if names:
        yield from _one_sided(" and ".join(names), _rows(ours, names), _rows(theirs, names))
    equal = True
    for name in common:
        line = _column_difference(name, ours, theirs, names, pairs)
        if line:
            equal = False
            yield line
    if equal:
        yield "values of the common columns and rows are equal; the bytes of the files differ"


def _one_sided(what: str, here: Sequence[Any], there: Sequence[Any]) -> Iterator[str]:
    """Yield the first names that one side alone has."""
    for side, own, other in (("first", here, set(there)), ("second", there, set(here))):
        alone = [one for one in own if one not in other]
        if alone:
            told = [_named(one) for one in alone[:MOST]] + [f"{len(alone) - MOST} more"] * (len(alone) > MOST)
            yield f"{what} of the {side} only: {', '.join(told)}"


def _named(one: Any) -> str:
    return " and ".join(map(repr, one)) if isinstance(one, tuple) else repr(one)


def _paired(here: Columns, there: Columns) -> tuple[list[str], list[tuple[int, int]]]:
    """Return the columns that name the rows of two tables, and which rows belong together; by number without names.

    A column of short words, no two the same, names the rows, as `quantity` does; or the first such columns together.
    They are names where most rows have theirs on both sides.
    """
    words = [name for name in here if _is_words(here[name]) and _is_words(there[name])]
    for names in [*([name] for name in words), *(words[:count] for count in range(2, len(words) + 1))]:
        first, second = _rows(here, names), _rows(there, names)
        at = {key: row for row, key in enumerate(second)}
        pairs = [(row, at[key]) for row, key in enumerate(first) if key in at]
        distinct = len(set(first)) == len(first) and len(at) == len(second)
        if distinct and 2 * len(pairs) > max(len(first), len(second)):
            return names, pairs
    return [], [(row, row) for row in range(min((len(one) for one in (*here.values(), *there.values())), default=0))]


def _is_words(column: Sequence[Any]) -> bool:
    return all(isinstance(one, str) and 0 < len(one) <= LONGEST_NAME for one in column)


def _rows(columns: Columns, names: Sequence[str]) -> list[Any]:
    """Return what names each row: the word of the one column, or those of several."""
    return columns[names[0]] if len(names) == 1 else list(zip(*(columns[name] for name in names), strict=True))


def _column_difference(
    name: str, here: Columns, there: Columns, names: Sequence[str], pairs: Sequence[tuple[int, int]]
) -> str | None:
    """Return the first differing row of a column and the largest relative difference of its numbers."""
    cells = [(row, here[name][row], there[name][other]) for row, other in pairs]
    differing = [(row, a, b) for row, a, b in cells if a != b and not (a != a and b != b)]
    if not differing:
        return None
    row, one, other = differing[0]
    which = ", ".join(f"{title} {here[title][row]!r}" for title in names) or f"row {row}"
    line = f"column {name!r}, {which}: {one!r} and {other!r}; {len(differing)} rows differ"
    numbers = [(a, b) for _, a, b in differing if isinstance(a, int | float) and isinstance(b, int | float)]
    if numbers:
        line += f", largest relative difference {max(_relative(a, b) for a, b in numbers):.3g}"
    return line


def _relative(a: float, b: float) -> float:
    if a != a or b != b:
        return float("inf")
    largest = max(abs(a), abs(b))
    return abs(a - b) / largest if largest not in (0.0, float("inf")) else float("inf")


def _on_disk(results: Path, place: Path) -> Path:
    """Return where a file is that a manifest lists: below the results folder, whatever its name, or beside it."""
    return results.joinpath(*place.parts[1:]) if place.parts[0] == "results" else results.parent / place
