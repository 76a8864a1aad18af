"""What comes of a benchmark: a JSON list of rows, lines for the terminal, and the tables of the documentation."""

from __future__ import annotations

import json
import os
import platform
import re
from collections.abc import Iterable
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from benchmarks.protocol import NOT_INSTALLED, Row

FOLDER = Path(__file__).parent / "results"
SPEED, METHOD = Path(__file__).parents[1] / "docs" / "speed.md", Path(__file__).parent / "README.md"
BEGIN, END = "<!-- benchmarks: begin -->", "<!-- benchmarks: end -->"


def facts(packages: Iterable[str]) -> dict[str, Any]:
    """Return versions and the machine's kind; neither its name nor any path."""
    found = {"python": platform.python_version()} | {name: _version(name) for name in packages}
    machine = {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "system": platform.system(),
        "load": [round(load, 1) for load in os.getloadavg()],
    }
    return {"versions": {name: text for name, text in found.items() if text}, "machine": machine}


def _version(package: str) -> str | None:
    if package == "ngspice":
        from benchmarks.peers import ngspice

        return ngspice.version() if ngspice.installed() else None
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _processor() -> str:
    try:
        said = Path("/proc/cpuinfo").read_text()
    except OSError:
        return platform.processor() or platform.machine()
    found = re.search(r"^model name\s*:\s*(.+)$", said, re.M)
    return found.group(1).strip() if found else platform.machine()


def as_dict(row: Row) -> dict[str, Any]:
    """Return a row as it is written: numbers to four digits, `None` where there is none."""
    return {
        "name": row.name,
        "peer": row.peer,
        "ours_s": rounded(row.ours_s),
        "peer_s": rounded(row.peer_s),
        "ratio_of": "ours over peer" if row.bound == "at most" else "peer over ours",
        "ratio_median": rounded(row.ratio),
        "ratio_range": [rounded(row.lowest), rounded(row.highest)],
        "processor_ratio": rounded(row.processor_ratio),
        "ratio_asked": None if row.figure is None else f"{row.figure.bound} {row.figure.ratio:g}",
        "ours_error": rounded(row.ours_error),
        "peer_error": rounded(row.peer_error),
        "error_means": row.error_means,
        "error_asked": rounded(row.error_asked),
        "status": row.status,
        "rounds": row.rounds,
        "note": row.note,
        "before_s": {side: rounded(seconds) for side, seconds in row.before_s.items()},
    }


def rounded(value: float | None) -> float | None:
    """Return four significant digits."""
    return None if value is None else float(f"{value:.3e}")


def save(name: str, rows: list[Row], about: dict[str, Any]) -> None:
    """Write the rows of a benchmark, each with the versions and the machine it was measured with."""
    write(name, [as_dict(row) | about for row in rows])


def write(name: str, rows: list[dict[str, Any]]) -> None:
    """Write rows to the file of a benchmark."""
    FOLDER.mkdir(exist_ok=True)
    (FOLDER / f"{name}.json").write_text(json.dumps(rows, indent=2) + "\n")


def read(name: str) -> list[dict[str, Any]]:
    """Return the rows on the file of a benchmark; none where it has not run."""
    file = FOLDER / f"{name}.json"
    found: list[dict[str, Any]] = json.loads(file.read_text()) if file.exists() else []
    return found


def shown(rows: list[Row]) -> str:
    """Return the rows as lines for a terminal."""
    lines = []
    for row in rows:
        if not row.installed:
            lines.append(f"{row.name} vs {row.peer}: {NOT_INSTALLED}")
            continue
        one = as_dict(row)
        line = f"{row.name} vs {row.peer}: {seconds(row.ours_s)} against {seconds(row.peer_s)}, {ratio(one)}"
        line += f", of processor time {short(row.processor_ratio or 0.0)} x"
        line += f"; errors {error(row.ours_error)} and {error(row.peer_error)}" if row.ours_error is not None else ""
        lines.append(f"{line}; {one['ratio_asked'] or 'nothing'} asked: {row.status}")
        lines += [f"    {row.note}"] if row.note else []
    return "\n".join(lines)


def seconds(value: float | None) -> str:
    """Return a time with its unit."""
    if value is None:
        return ""
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6)):
        if value >= size:
            return f"{value / size:.3g} {unit}"
    return f"{value / 1e-9:.3g} ns"


def error(value: float | None) -> str:
    """Return an error in one digit."""
    return "" if value is None else f"{value:.0e}" if value else "0"


def ratio(row: dict[str, Any]) -> str:
    """Return a written row's median ratio and range."""
    low, high = row["ratio_range"]
    return f"{short(row['ratio_median'])} x ({short(low)} to {short(high)})"


def short(value: float) -> str:
    """Return a ratio to three digits, thousands apart."""
    if value < 1000:
        return f"{value:.3g}"
    return f"{float(f'{value:.3g}'):,.0f}".replace(",", " ")


def table(names: Iterable[str], asked_only: bool = False) -> str:
    """Return the Markdown table of the results on file, in the order of the names."""
    lines = [
        "| work | peer | ours | peer | median ratio (range) | of processor time | asked | errors, ours and peer's | |",
        "|---" * 9 + "|",
    ]
    loads, machines = [], set()
    for name in names:
        for row in read(name):
            loads.append(row["machine"]["load"][0])
            machines.add(f"{row['machine']['processor']}, {row['machine']['cores']} cores")
            if row["ratio_asked"] or not asked_only or row["name"].endswith("whole process"):
                lines.append(_line(row))
    if loads:
        lines += ["", f"Measured on {' and '.join(sorted(machines))}, with a load of {min(loads):g} to {max(loads):g}."]
    return "\n".join(lines)


def write_tables(names: Iterable[str]) -> None:
    """Write the rows of which something is asked into docs/speed.md, every row into that of the benchmarks."""
    for file, asked_only in ((SPEED, True), (METHOD, False)):
        file.write_text(put(file.read_text(), table(names, asked_only)))


def _line(row: dict[str, Any]) -> str:
    asked = (row["ratio_asked"] or "").replace("at least", ">=").replace("at most", "<=")
    if row["status"] == NOT_INSTALLED:
        return f"| {row['name']} | {row['peer']} | | | {NOT_INSTALLED} | | {asked} | | |"
    errors = ", ".join(error(value) for value in (row["ours_error"], row["peer_error"]) if value is not None)
    status = "" if row["status"] == "measured" else row["status"]
    spent = f"{short(row['processor_ratio'])} x"
    times = f"{seconds(row['ours_s'])} | {seconds(row['peer_s'])}"
    return f"| {row['name']} | {row['peer']} | {times} | {ratio(row)} | {spent} | {asked} | {errors} | {status} |"


def put(text: str, lines: str, begin: str = BEGIN, end: str = END) -> str:
    """Return a text with the lines between its two markers."""
    if begin not in text or end not in text:
        raise ValueError(f"no {begin} ... {end} to put the table between")
    head, rest = text.split(begin, 1)
    _, tail = rest.split(end, 1)
    return f"{head}{begin}\n{lines}\n{end}{tail}"
