"""`python -m pipeline licences`: the licence of every package that a run needs, as their metadata say it."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from importlib import metadata
from pathlib import Path
from typing import Any, NamedTuple

from packaging.requirements import Requirement

from pipeline.commands import Parser, as_typed, typed
from pipeline.commands.terminal import table_lines
from pipeline.errors import UserError
from pipeline.kernel.places import INSTALLED, LOCK_FILE, PROJECT
from pipeline.kernel.store import write_text

DOCS = Path("docs") / "licences.md"
BEGIN, END = "<!-- licences: begin -->", "<!-- licences: end -->"
SERVES = {
    "pymoo": "two baselines of the searches (genetic algorithm, particle swarm) and the front of the staging",
}
"""Package of our own choice -> what it is here for, told where it brings one under a copyleft."""
BUILD = "the build of the package"
_PINNED = re.compile(r"^([A-Za-z0-9][A-Za-z0-9._-]*)==([^\s;\\]+)", re.MULTILINE)
# Words of a licence -> what its copyleft covers; the first that fits counts.
_COPYLEFT = (
    (r"\bAGPL|Affero", "copyleft"),
    (r"\bLGPL|Lesser General Public|Library General Public", "copyleft of the library"),
    (r"\bMPL|Mozilla Public|\bEPL|Eclipse Public|\bCDDL", "copyleft of its files"),
    (r"\bGPL|General Public", "copyleft"),
)
# How the text of a licence begins, or what stands in it -> its identifier; for packages whose metadata name none.
_TEXTS = (
    ("Apache License", "Apache-2.0"),
    ("GNU LESSER GENERAL PUBLIC LICENSE", "LGPL"),
    ("GNU AFFERO", "AGPL"),
    ("GNU GENERAL PUBLIC LICENSE", "GPL"),
    ("Mozilla Public License", "MPL-2.0"),
    ("Permission is hereby granted, free of charge", "MIT"),
    ("Neither the name of", "BSD-3-Clause"),
    ("Redistribution and use in source and binary forms", "BSD-2-Clause"),
)
_LONGEST = 60


class Licence(NamedTuple):
    """The licence of a package.

    `copyleft` says what its copyleft covers, empty where it has none; `through` is what brings the package in.
    """

    package: str
    licence: str
    copyleft: str
    through: str


def main(arguments: Sequence[str]) -> int:
    """Print the licences, at the end those with a copyleft again, or write the table of the documentation; return 0.

    Raises
    ------
    UserError : a package is missing that a run needs; the others are printed before, nothing is written.
    """
    parser = Parser(prog=typed("licences"), description=as_typed(__doc__ or ""))
    parser.add_argument("--write", action="store_true", help=f"write the table in {DOCS}")
    write = parser.parse_args(arguments).write
    found, missing, left_out = licences()
    if not write:
        _print(found, [] if missing else left_out)
    if missing:
        raise UserError(_told_missing(missing))
    if write:
        path = PROJECT / DOCS
        if not path.is_file():
            raise UserError(f"{DOCS}: not there; the table belongs to a clone of the project")
        write_text(path, written(path.read_text(encoding="utf-8"), found))
        print(f"{DOCS}: written")
    return 0


def _print(found: Sequence[Licence], left_out: Sequence[str]) -> None:
    for line in table_lines([("package", "licence", "copyleft", "through"), *found]):
        print(line)
    print(f"\n{len(found)} packages of {LOCK_FILE.name}; copyleft:")
    for line in told(found):
        print(f"  {line}")
    if left_out:
        print(f"left out, since not installed and no run needs them: {', '.join(left_out)}")


class Packages(NamedTuple):
    """Packages of the lock file: licences of those that are installed, and names of the others.

    `missing` is what a run needs; `left_out` is of the build alone, of another platform, or of what is missing.
    """

    found: list[Licence]
    missing: list[str]
    left_out: list[str]


def licences() -> Packages:
    """Return the packages of the lock file, in its order, then what a newer installed package asks for beside it."""
    locked = list(_locked())
    brought = _through()
    known = {_plain(name) for name in locked}
    names = [*locked, *(name for name in brought if name not in known)]
    installed = {name: package for name in names if (package := _installed(name)) is not None}
    absent = [name for name in names if name not in installed]
    missing = [name for name in absent if not brought or _plain(name) in brought]
    # What a missing package asks for is not known: the rest may be its own, and not of the build.
    other = "" if missing else BUILD
    found = []
    for name, package in installed.items():
        licence = licence_of(package)
        found.append(Licence(name, licence, copyleft_of(licence), brought.get(_plain(name), other)))
    return Packages(found, missing, [name for name in absent if name not in missing])


def _installed(name: str) -> metadata.Distribution | None:
    try:
        return metadata.distribution(name)
    except metadata.PackageNotFoundError:
        return None


def _locked() -> dict[str, str]:
    """Return package -> version of the lock file."""
    return dict(_PINNED.findall(LOCK_FILE.read_text(encoding="utf-8")))


def _told_missing(missing: Sequence[str]) -> str:
    """Say what is not installed, and what installs it: there is no Makefile where the package came as a wheel."""
    versions = _locked()
    words = [f"{name}=={versions[name]}" if name in versions else name for name in missing]
    remedy = f"python -m pip install {' '.join(words)}" if INSTALLED else "make setup"
    return f"{LOCK_FILE.name}: {', '.join(missing)} {'is' if len(missing) == 1 else 'are'} not installed; {remedy}"


def licence_of(package: metadata.Distribution) -> str:
    """Return the licence of an installed package: its expression, its classifiers, its own words, or its text."""
    about: Any = package.metadata
    if about.get("License-Expression"):
        return str(about["License-Expression"])
    classifiers = [one.split(" :: ")[-1] for one in about.get_all("Classifier") or [] if one.startswith("License ::")]
    classified = " or ".join(one for one in classifiers if one != "OSI Approved")
    if classified:
        return classified
    own = (about.get("License") or "").strip().splitlines()
    if own and len(own[0]) <= _LONGEST and not re.match(r"Copyright|\W", own[0]):
        return own[0]
    return next(_of_texts(package), "not said")


def copyleft_of(licence: str) -> str:
    """Return what the copyleft of a licence covers, empty where it has none, or another may be chosen."""
    kind = next((covers for words, covers in _COPYLEFT if re.search(words, licence)), "")
    choices = re.split(r"\s+(?:or|OR)\s+(?!later)", licence)
    free = len(choices) > 1 and any(not copyleft_of(one) for one in choices)
    return f"{kind} in part, or by choice" if kind and free else kind


def told(found: Sequence[Licence]) -> Iterator[str]:
    """Yield a line for each package under a copyleft: what it covers, who brings it, and for what."""
    for one in found:
        if one.copyleft:
            through = f", through {one.through}" if one.through else ""
            purposes = [why for name, why in SERVES.items() if one.through.split(" > ")[0] == name]
            serves = f", which serves only {purposes[0]}" if purposes and through else ""
            yield f"{one.package}: {one.licence} ({one.copyleft}){through}{serves}"


def written(text: str, found: Sequence[Licence]) -> str:
    """Return a page of the documentation with the table between its marks.

    Raises
    ------
    UserError : no marks there.
    """
    if not re.search(f"{BEGIN}\n.*{END}", text, re.DOTALL):
        raise UserError(f"{DOCS}: no lines {BEGIN} and {END} to write between")
    rows = [("package", "licence", "copyleft", "through"), ("---",) * 4, *found]
    table = "\n".join(f"| {' | '.join(row)} |" for row in rows)
    listed = "\n".join(f"- {line}" for line in told(found))
    return re.sub(f"{BEGIN}\n.*{END}", lambda _: f"{BEGIN}\n{listed}\n\n{table}\n{END}", text, flags=re.DOTALL)


def _of_texts(package: metadata.Distribution) -> Iterator[str]:
    """Yield what the files of a package's licence are by their words."""
    for file in package.files or ():
        if file.name.upper().startswith(("LICENSE", "LICENCE", "COPYING")) and ".dist-info" in str(file):
            text = " ".join(file.read_text(encoding="utf-8").split())
            yield from (name for words, name in _TEXTS if words.lower() in text.lower())


def _through() -> Mapping[str, str]:
    """Return package -> the way from what the project itself asks for to it, `pymoo > moocore` but for its own end."""
    waiting = list(_asked("charge-pipeline"))
    ways = dict.fromkeys((name for name, _ in waiting), "")
    seen = set(waiting)
    for name, extras in waiting:
        for other, its_extras in _asked(name, extras):
            ways.setdefault(other, f"{ways[name]} > {name}".removeprefix(" > "))
            if (other, its_extras) not in seen:
                seen.add((other, its_extras))
                waiting.append((other, its_extras))
    return ways


def _asked(name: str, extras: frozenset[str] = frozenset()) -> Iterator[tuple[str, frozenset[str]]]:
    """Yield the packages, each with its extras, that an installed one asks for here, with these of its extras."""
    try:
        asked = metadata.requires(name) or []
    except metadata.PackageNotFoundError:
        return
    for one in map(Requirement, asked):
        if one.marker is None or any(one.marker.evaluate({"extra": extra}) for extra in ("", *sorted(extras))):
            yield _plain(one.name), frozenset(one.extras)


def _plain(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()
