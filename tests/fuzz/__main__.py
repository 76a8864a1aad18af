"""`python -m tests.fuzz [--short] [--seed N]`: wrong input at every front door; counts by kind, 1 where one is not met.

Refused is: before any step, exit code 2, one message that begins with the override or the file, nothing written.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
import time
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import islice
from pathlib import Path

from pipeline.config.compose import CONF
from tests.fuzz import configurations, doors, files

Found = tuple[str, str, str, doors.Outcome, str | None]
"""Door, kind, word, outcome, and what is wrong with it."""
FULL = {"configurations": 1000, "whole": 60, "as files": 150, "files": 340, "commands": 40}
SHORT = {"configurations": 90, "whole": 4, "as files": 12, "files": 60, "commands": 1}


def wrong_configurations(count: int, seed: int) -> Iterator[Found]:
    """Yield what planning makes of values that are wrong, each put into a composed study."""
    made = (one for one in configurations.wrong(seed) if _is_value(one.word))
    for one in islice(made, count):
        yield _found("configuration", one.kind, one.word, doors.checked(one.words), one.sure)


def _is_value(word: str) -> bool:
    return not word.startswith(("+", "~")) and "." in word.split("=", 1)[0]


def whole_lines(count: int, seed: int) -> Iterator[Found]:
    """Yield what the doors of this process make of whole command lines."""
    for name, door in doors.INSIDE.items():
        for one in islice(configurations.wrong(seed + len(name)), count):
            yield _found(name, one.kind, one.word, door(one.words), one.sure)


def as_files(count: int, seed: int) -> Iterator[Found]:
    """Yield what the same values make of a YAML file."""
    with tempfile.TemporaryDirectory() as folder:
        conf = Path(shutil.copytree(CONF, Path(folder) / "conf"))
        made = (one for one in configurations.wrong(seed + 1) if _is_value(one.word) and "modes." not in one.word)
        for one in islice(made, count):
            yield _found("a YAML file", one.kind, one.word, doors.as_file(conf, one.word, one.study), False)


def wrong_files(count: int, seed: int) -> Iterator[Found]:
    """Yield what planning makes of wrong data files."""
    with tempfile.TemporaryDirectory() as folder:
        for number, one in enumerate(islice(files.wrong(seed), count)):
            place = Path(folder) / str(number)
            place.mkdir()
            one.make(place / one.name)
            words = one.words(place / one.name)
            yield _found(f"a file: {one.place}", one.kind, words[-1], doors.checked(words), one.sure)


def commands(count: int, seed: int) -> Iterator[Found]:
    """Yield what real commands make of wrong words, two at a time."""
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(2) as pool:
        jobs = []
        for place, door in enumerate(doors.REAL):
            made = (one for one in configurations.wrong(seed + 7 * place) if one.sure)
            for number, one in enumerate(islice(made, count)):
                here = Path(folder) / f"{place}-{number}"
                here.mkdir()
                jobs.append((door, one, pool.submit(doors.really, door, one.words, here)))
        for door, one, job in jobs:
            yield _found(door, one.kind, one.word, job.result(), sure=True, plain=door in PLAIN)


# Words that take no overrides refuse them as argparse does.
PLAIN = {door for door in doors.REAL if door.removeprefix("python -m pipeline ") in doors.COMMANDS}


def _found(door: str, kind: str, word: str, outcome: doors.Outcome, sure: bool, plain: bool = False) -> Found:
    fault = outcome.told if outcome.word == "broken" else None if plain else doors.fault(outcome, word)
    if sure and outcome.word == "taken":
        fault = "taken, and the schema rules it out"
    return door, kind.split(":")[0] if door.startswith("a file") else kind, word, outcome, fault


def run(sizes: dict[str, int], seed: int) -> list[Found]:
    """Run every part, print counts by door and kind as they come; return what was not met as it should."""
    faults: list[Found] = []
    parts = {
        "configurations": wrong_configurations,
        "whole": whole_lines,
        "as files": as_files,
        "files": wrong_files,
        "commands": commands,
    }
    for name, part in parts.items():
        began, counts = time.monotonic(), defaultdict[tuple[str, str], Counter[str]](Counter)
        for found in part(sizes[name], seed):
            door, kind, word, outcome, fault = found
            counts[door, kind][outcome.word if fault is None else "FAULT"] += 1
            if fault is not None:
                faults.append(found)
                _say(f"FAULT  {door}: {kind}: {word[:200]}\n       {fault}")
        _counted(name, counts, time.monotonic() - began)
    _say(f"{len(faults)} faults")
    return faults


def _say(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def _counted(name: str, counts: dict[tuple[str, str], Counter[str]], seconds: float) -> None:
    total = sum((one for one in counts.values()), Counter[str]())
    said = ", ".join(f"{count} {word}" for word, count in sorted(total.items()))
    _say(f"{name}: {sum(total.values())} tried, {said}; {seconds:.0f} s")
    for (door, kind), one in sorted(counts.items()):
        _say(f"  {door}: {kind}: " + ", ".join(f"{count} {word}" for word, count in sorted(one.items())))


def main(arguments: Sequence[str]) -> int:
    """Return 0, or 1 where wrong input was not met as it should."""
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    parser.add_argument("--short", action="store_true", help="about a minute")
    parser.add_argument("--seed", type=int, default=20150401, help="of the order in which input is tried")
    parser.add_argument("--only", choices=list(FULL), action="append", help="parts to run")
    chosen = parser.parse_args(arguments)
    sizes = SHORT if chosen.short else FULL
    return int(bool(run({part: size * (part in (chosen.only or FULL)) for part, size in sizes.items()}, chosen.seed)))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
