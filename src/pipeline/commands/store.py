"""`python -m pipeline store [list|verify|clean]`: what the folder holds, whether it is whole, what no run needs."""

from __future__ import annotations

import argparse
import json
import re
import time
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from pipeline.commands import Parser, as_typed, typed
from pipeline.commands.workflow import say
from pipeline.errors import UserError
from pipeline.kernel import digest, lock, planfile, publish, receipts, store
from pipeline.kernel.store import RESULTS

_UNITS = {"B": 1, "KiB": 2**10, "MiB": 2**20, "GiB": 2**30, "TiB": 2**40}


def main(arguments: Sequence[str]) -> int:
    """List, verify or clean; return 1 where something is damaged."""
    parser = Parser(prog=typed("store"), description=as_typed(__doc__ or ""))
    words = parser.add_subparsers(dest="word", metavar="list|verify|clean")
    words.add_parser("list", help="artefacts of each step and study: number, size, age (the default)")
    words.add_parser("verify", help="read artefacts, readable views, plans and receipts; 1 where one is damaged")
    clean = words.add_parser("clean", help="remove temporary files of ended processes, artefacts that no run needs")
    clean.add_argument(
        "--keep-below",
        type=size,
        metavar="SIZE",
        help="remove the oldest artefacts that no plan names until the store is smaller (2GiB, 500MiB) "
        "instead of all that no published run names",
    )
    choices = parser.parse_args(arguments)
    if choices.word == "verify":
        return _verify(RESULTS)
    if choices.word == "clean":
        with lock.held(RESULTS, say):
            return _clean(RESULTS, choices.keep_below)
    _list(RESULTS)
    return 0


def size(text: str) -> int:
    """Return a number of bytes from a size as people write it: `2GiB`, `500 MiB`, `1e6`, `1.5 GB`."""
    found = re.fullmatch(r"\s*([0-9.]+(?:e[0-9]+)?)\s*([kmgt]?)(i?)b?\s*", text, re.IGNORECASE | re.ASCII)
    try:
        if found is None:
            raise ValueError
        power = " KMGT".index(found[2].upper() or " ")
        return round(float(found[1]) * (1024.0 if found[3] else 1000.0) ** power)
    except (ValueError, OverflowError):
        raise argparse.ArgumentTypeError(f"{text!r} is no size; allowed are 500MiB, 2GiB, ...") from None


def _verify(results: Path) -> int:
    """Say of each kind of file how many are whole, and what is wrong with the others."""
    damaged = 0
    folders = list(_artefacts(results))
    kinds: dict[str, tuple[int, list[str]]] = {
        "artefacts": (len(folders), [fault for folder in folders if (fault := store.damage(folder)) is not None]),
    }
    manifests = _manifests(results)
    kinds["views"] = len(manifests), [fault for path in manifests for fault in _view_faults(results, path)]
    plans = _plans(results)
    kinds["plans"] = len(plans), [fault for path in plans if (fault := _plan_fault(path))]
    kept = [path for path in (results / "receipts").glob("*/*.json") if not path.name.startswith(".")]
    kinds["receipts"] = len(kept), list(receipts.faults(results))
    for kind, (count, faults) in kinds.items():
        for fault in faults:
            print(f"damaged: {fault}")
        wrong = len({fault.split(": ")[0] for fault in faults}) if kind == "views" else len(faults)
        print(f"{max(count - wrong, 0)} {kind} whole, {wrong} damaged")
        damaged += wrong
    if damaged:
        print("the run that made them makes them again: give its command once more, with --verify (or verify=true)")
    return 1 if damaged else 0


def _clean(results: Path, keep_below: int | None) -> int:
    temporary = list(store.abandoned(results))
    for path in temporary:
        store.remove(path)
    print(f"{len(temporary)} temporary files of ended processes removed")
    folders = list(_artefacts(results, unsealed=True))
    needed = _named_by_manifests(results)
    sizes = {folder: _size(folder) for folder in folders}
    if keep_below is None:
        unneeded = [folder for folder in folders if _name(folder) not in needed]
        why = "that no published run names"
    else:
        needed |= _named_by_plans(results).keys()
        free = sorted((one for one in folders if _name(one) not in needed), key=lambda one: one.stat().st_mtime)
        unneeded, total = [], sum(sizes.values())
        for folder in free:
            if total <= keep_below:
                break
            unneeded.append(folder)
            total -= sizes[folder]
        why = "that no plan names, the oldest ones,"
    for folder in unneeded:
        store.remove(folder)
    gone = receipts.forget(results, {_name(folder) for folder in unneeded})
    left = sum(sizes.values()) - sum(sizes[folder] for folder in unneeded)
    print(
        f"{len(unneeded)} artefacts {why} removed, {len(folders) - len(unneeded)} kept ({_readable(left)}); "
        f"{gone} receipts of theirs removed"
    )
    if keep_below is not None and left > keep_below:
        done = f"remove those in {results / 'plan'} that you are done with"
        print(f"still above {_readable(keep_below)}: plans or published runs name the rest; {done}")
    return 0


def _list(results: Path) -> None:
    """Print the artefacts of each step and study, the largest first."""
    named = _named_by_plans(results, damaged=say)
    groups: dict[tuple[str, str], list[Path]] = defaultdict(list)
    for folder in _artefacts(results):
        groups[folder.parent.name, ", ".join(sorted(named.get(_name(folder), ()))) or "no plan"].append(folder)
    sizes = {group: sum(map(_size, folders)) for group, folders in groups.items()}
    table = Table("step", "study", "artefacts", "size", "age", show_lines=False)
    now = time.time()
    for group in sorted(groups, key=lambda one: (-sizes[one], one)):
        ages = sorted(now - folder.stat().st_mtime for folder in groups[group])
        age = " to ".join(dict.fromkeys((_age(ages[0]), _age(ages[-1]))))
        table.add_row(*group, str(len(ages)), _readable(sizes[group]), age)
    console = Console(width=None if Console().is_terminal else 140)
    console.print(table)
    console.print(f"{sum(map(len, groups.values()))} artefacts, {_readable(sum(sizes.values()))}")
    quarantined = results / "quarantine"
    if quarantined.is_dir() and any(quarantined.iterdir()):
        console.print(f"and {_readable(_size(quarantined))} in {quarantined}, what was damaged; nothing needs it")


def _artefacts(results: Path, unsealed: bool = False) -> Iterator[Path]:
    for folder in sorted((results / "store").glob("*/*")):
        if not folder.name.startswith(".") and (unsealed or (folder / store.CONTENTS).is_file()):
            yield folder


def _name(folder: Path) -> str:
    return f"{folder.parent.name}/{folder.name}"


def _manifests(results: Path) -> list[Path]:
    return publish.manifests(results)


def _plans(results: Path) -> list[Path]:
    return sorted(path for path in (results / "plan").glob("*.json") if not path.name.startswith("."))


def _view_faults(results: Path, manifest: Path) -> Iterator[str]:
    try:
        listed = [
            (entry["path"], entry["sha256"]) for entry in json.loads(manifest.read_text(encoding="utf-8"))["artefacts"]
        ]
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        yield f"{manifest}: not a manifest ({error})"
        return
    for place, sha256 in listed:
        path = results.parent / place
        if not path.is_file():
            yield f"{path}: missing"
        elif digest.of_file(path) != sha256:
            yield f"{path}: not what {manifest.name} lists"


def _plan_fault(path: Path) -> str | None:
    try:
        planfile.load(path)
    except UserError as error:
        return str(error)
    return None


def _named_by_plans(results: Path, damaged: Any = None) -> dict[str, set[str]]:
    """Return step/key -> studies, of every node of every plan.

    Raises
    ------
    UserError : a plan is damaged, where nothing is given that takes the message.
    """
    found: dict[str, set[str]] = defaultdict(set)
    for path in _plans(results):
        try:
            plan = planfile.load(path)
        except UserError as error:
            if damaged is None:
                raise UserError(f"{error}; nothing is removed while it may name what would be") from None
            damaged(str(error))
            continue
        for run in plan["runs"]:
            for node in run["nodes"].values():
                found[f"{node['step']}/{node['key']}"].add(run["study"])
    return found


def _named_by_manifests(results: Path) -> set[str]:
    """Return step/key of every node of the runs that are published, whole or in part.

    Raises
    ------
    UserError : a manifest is damaged.
    """
    found: set[str] = set()
    for path in _manifests(results):
        try:
            manifest: Mapping[str, Any] = json.loads(path.read_text(encoding="utf-8"))
            found |= {f"{node['step']}/{node['key']}" for node in manifest["nodes"].values()}
        except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
            raise UserError(
                f"{path}: not a manifest ({error}); run its study again, which writes it anew, or remove it: "
                "nothing is removed while it may name what would be"
            ) from None
    return found


def _size(folder: Path) -> int:
    """Return the bytes of the files in a folder."""
    return sum(path.lstat().st_size for path in folder.rglob("*") if path.is_file())


def _readable(count: int) -> str:
    """Return a number of bytes as people read it."""
    unit = max((name for name, one in _UNITS.items() if count >= one), key=_UNITS.__getitem__, default="B")
    return f"{count} B" if unit == "B" else f"{count / _UNITS[unit]:.3g} {unit}"


def _age(seconds: float) -> str:
    for unit, length in (("d", 86400), ("h", 3600), ("min", 60)):
        if seconds >= 2 * length:
            return f"{seconds / length:.0f} {unit}"
    return f"{max(seconds, 0):.0f} s"
