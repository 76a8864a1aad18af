"""What a run is expected to come to: bytes, numbers, found values and verdicts of its artefacts, on some machine."""

from __future__ import annotations

import json
import math
import os
import platform
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

from pipeline.commands.compare import damage, manifest
from pipeline.errors import UserError
from pipeline.kernel import digest, publish, registry, store, tables
from pipeline.kernel.plan import PYTHON
from pipeline.kernel.tables import TableFile

VERSION = 1
DIGITS = 9
"""Digits to which numbers are written; ten are more than another machine gives back."""
KINDS = ("found", "verdicts", "numbers", "tables")
"""What is recorded of a run beside bytes."""
_NONE = object()
# What makes another machine of this one, in libraries that say nothing of it themselves.
_ARITHMETIC = ("GLIBC_TUNABLES", "OPENBLAS_CORETYPE")


def fingerprint() -> dict[str, str]:
    """Return what the bytes of an artefact depend on, beside configuration and code."""
    from numba.core.registry import cpu_target

    _, cpu, features = cpu_target.target_context.codegen().magic_tuple()
    return {
        "cpu": cpu,
        "cpu features": " ".join(sorted(word[1:] for word in features.split(",") if word.startswith("+"))),
        "libc": " ".join(platform.libc_ver()),
        "lock file": digest.of_lock(),
        "numpy's features": " ".join(sorted(numpy_features())),
        "platform": f"{platform.system()} {platform.machine()}",
        "python": PYTHON,
        **{name: os.environ[name] for name in _ARITHMETIC if name in os.environ},
    }


def numpy_features(dispatched: bool = False) -> list[str]:
    """Return the instructions that numpy uses here: all, or those without which it would still run."""
    inside = import_module("numpy._core._multiarray_umath")
    names = inside.__cpu_dispatch__ if dispatched else inside.__cpu_features__
    return [name for name in names if inside.__cpu_features__[name]]


@dataclass(frozen=True)
class Recorded:
    """What runs came to.

    `runs` is what is written: run -> `sha256` of its artefacts, and their `found` values, `verdicts`, `numbers` and
    `tables`; `declared` is run and place of a table -> its declaration.
    """

    runs: dict[str, Any]
    declared: dict[tuple[str, str], TableFile | None]

    @classmethod
    def of(cls, results: Path) -> Recorded:
        """Read what the runs of a results folder came to, from what lies on disk.

        Raises
        ------
        UserError : a file that is missing or is not what its manifest lists, or no run at all.
        """
        made = cls({}, {})
        for path in publish.manifests(results):
            made._add(results, manifest(path))
        if not made.runs:
            raise UserError(f"{results}: no run was made there")
        return made

    def _add(self, results: Path, read: Mapping[str, Any]) -> None:
        name = f"{read['study']}/{read['run']}"
        run = self.runs.setdefault(name, {kind: {} for kind in ("sha256", *KINDS)})
        run["found"] |= _found(results, read["nodes"])
        for place, listed in read["artefacts"].items():
            fault = damage(listed)
            if fault:
                raise UserError(f"{fault}; run the study again")
            run["sha256"][place] = listed.sha256
            if listed.path.suffix == ".parquet":
                step = registry.steps().get(listed.step)
                table = tables.of_file(step.tables, listed.file) if step is not None else None
                self.declared[name, place] = table
                for kind, values in _summary(listed.path, table).items():
                    run[kind][place] = values

    def tolerance(self, run: str, place: str, name: str) -> float:
        """Return how far a column or a named number may be off on another machine."""
        table = self.declared.get((run, place))
        return tables.ELSEWHERE if table is None else table.tolerance(name)


def _found(results: Path, nodes: Mapping[str, Mapping[str, str]]) -> dict[str, Any]:
    """Return the values that the steps of a run found and others ask for, in full."""
    files = {name: store.artefact(results, node["step"], node["key"]) / "found.json" for name, node in nodes.items()}
    return {
        name: _rounded(json.loads(file.read_text(encoding="utf-8"))) for name, file in files.items() if file.is_file()
    }


def _summary(path: Path, table: TableFile | None) -> dict[str, Any]:
    """Return a table in a few numbers, under the kind of what it holds; nothing of what is chaotic."""
    import pyarrow.parquet as pq

    def lasting(name: str) -> bool:
        return table is None or math.isfinite(table.tolerance(name))

    columns = pq.read_table(path).to_pydict()
    if {"statement", "verdict"} <= set(columns):
        return {"verdicts": dict(zip(columns["statement"], columns["verdict"], strict=True))}
    names = columns.get("quantity", ())
    if "value" in columns and len(set(names)) == len(names) > 0:
        pairs = zip(names, columns["value"], strict=True)
        return {"numbers": {name: _rounded(value) for name, value in pairs if lasting(name)}}
    told = {name: _column(values) for name, values in columns.items() if lasting(name)}
    return {"tables": {"rows": len(next(iter(columns.values()))), **told}} if told else {}


_TOLD = ("least", "mean", "most", "last")


def _column(values: Sequence[Any]) -> Any:
    """Return a column in a few numbers: one where all are the same, a digest of what is no number."""
    there = [value for value in values if value is not None and value == value]
    if not there:
        return None
    if not all(isinstance(value, int | float) for value in there):
        return digest.of_value([str(value) for value in values])[:12]
    numbers = [float(value) for value in there]
    if min(numbers) == max(numbers) and len(there) == len(values):
        return _rounded(numbers[0])
    told = dict(zip(_TOLD, (min(numbers), math.fsum(numbers) / len(numbers), max(numbers), numbers[-1]), strict=True))
    empty = len(values) - len(there)
    return _rounded(told) | ({"empty": empty} if empty else {})


def _rounded(value: Any) -> Any:
    """Return plain data with every number to some digits; what is not finite as text, which JSON can hold."""
    if isinstance(value, Mapping):
        return {key: _rounded(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_rounded(one) for one in value]
    if isinstance(value, float):
        return float(f"{value:.{DIGITS}g}") if math.isfinite(value) else str(value)
    return value


def text_of(expected: Mapping[str, Any]) -> str:
    """Return what is expected as text: sorted, a value a line, so that a change reads as numbers."""
    return json.dumps(expected, indent=1, sort_keys=True, ensure_ascii=False, allow_nan=False) + "\n"


def load(path: Path) -> dict[str, Any]:
    """Read what is expected; raise `UserError` where there is none."""
    try:
        expected: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise UserError(f"{path}: nothing is expected yet; record it with --renew") from None
    except ValueError as error:
        raise UserError(f"{path}: not JSON ({error}); record it anew with --renew") from None
    if not isinstance(expected, dict) or expected.get("version") != VERSION:
        raise UserError(f"{path}: not a file of version {VERSION}; record it anew with --renew")
    return expected


@dataclass
class Comparison:
    """What differs between expected and found.

    `faults` in words, `counts` of what was compared by kind, and the largest difference that was let pass, as a share
    of its column and with its place.
    """

    faults: list[str] = field(default_factory=list)
    counts: dict[str, int] = field(default_factory=dict)
    largest: tuple[float, str] = (0.0, "")

    def both(self, place: str, here: Any, there: Any, none: Any = None) -> bool:
        """Tell whether something was expected and made; what was only one of the two is a fault."""
        if here is none or there is none:
            self.faults.append(f"{place}: {'expected, not made' if there is none else 'made, not expected'}")
        return here is not none and there is not none

    def one(self, kind: str, place: str, here: Any, there: Any, scale: float | None, tolerance: float) -> None:
        """Compare one value with the expected one.

        Arguments
        ---------
        kind : under which it is counted.
        place : where it stands.
        here, there : as expected, and as found.
        scale : what a difference is a share of; the larger of the two numbers where it is not given.
        tolerance : the largest share that is none.
        """
        self.counts[kind] = self.counts.get(kind, 0) + 1
        share = _share(here, there, scale)
        if share > tolerance:
            by = f", {share:.3g} of its size, {tolerance:.3g} allowed" if math.isfinite(share) else ""
            self.faults.append(f"{place}: {here!r} expected, {there!r} found{by}")
        else:
            self.largest = max(self.largest, (share, place))


def compared(expected: Mapping[str, Any], found: Recorded, bytes_too: bool) -> Comparison:
    """Compare what runs came to with what they are expected to come to.

    Arguments
    ---------
    expected : the runs as recorded.
    found : the runs as made.
    bytes_too : whether the machine is the recorded one, so that every artefact must be the same byte for byte. Where
        it is not, numbers may be as far off as they are declared.
    """
    comparison = Comparison()
    for run in sorted(expected.keys() | found.runs.keys()):
        if not comparison.both(run, expected.get(run), found.runs.get(run)):
            continue
        here, there = expected[run], found.runs[run]
        for place in sorted(here["sha256"].keys() | there["sha256"].keys()):
            pair = here["sha256"].get(place), there["sha256"].get(place)
            if comparison.both(f"{run} {place}", *pair) and bytes_too:
                comparison.one("artefacts", f"{run} {place}: sha256", *pair, None, 0.0)
        for kind in KINDS:
            for place in sorted(here[kind].keys() & there[kind].keys()):
                tolerances = partial(found.tolerance, run, place)
                _compare(comparison, kind, f"{run} {place}", here[kind][place], there[kind][place], tolerances)
    return comparison


def _compare(
    comparison: Comparison, kind: str, place: str, here: Any, there: Any, tolerance: Callable[[str], float]
) -> None:
    """Compare the values of an artefact under their names."""
    for name in sorted(here.keys() | there.keys()):
        at, allowed = f"{place}: {name}", tolerance(name)
        if math.isinf(allowed) or not comparison.both(at, here.get(name, _NONE), there.get(name, _NONE), _NONE):
            continue
        first, second = (dict(_leaves(one)) for one in _alike(here[name], there[name]))
        sizes = [abs(value) for value in first.values() if _is_number(value)]
        scale = max(sizes, default=0.0) if kind == "tables" else None
        for leaf in sorted(first.keys() | second.keys()):
            comparison.one(kind, at + leaf, first.get(leaf), second.get(leaf), scale, allowed)


def _alike(here: Any, there: Any) -> tuple[Any, Any]:
    """Return two values told alike: a column of one number is told by that number, until its last digit varies."""
    one, other = (
        dict.fromkeys(_TOLD, value) if _is_number(value) and isinstance(beside, Mapping) else value
        for value, beside in ((here, there), (there, here))
    )
    return one, other


def _leaves(value: Any, place: str = "") -> Iterator[tuple[str, Any]]:
    """Yield every plain value in nested data with its place."""
    if isinstance(value, Mapping | list):
        for key, one in value.items() if isinstance(value, Mapping) else enumerate(value):
            yield from _leaves(one, f"{place} {key}")
    else:
        yield place, value


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _share(here: Any, there: Any, scale: float | None) -> float:
    """Return by how much two values differ, as a share of a scale; infinite where they are no two numbers."""
    if here == there:
        return 0.0
    if not (_is_number(here) and _is_number(there)):
        return math.inf
    return float(abs(here - there) / (scale or max(abs(here), abs(there))))
