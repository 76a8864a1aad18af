"""What the jobs of each step took: `python -m tests.slurm.measured RESULTS ...` writes it from benchmark files.

Memory [MB] and processor time [s], of the largest job of each step that any of the folders has.
"""

from __future__ import annotations

import csv
import json
import sys
from pathlib import Path

TABLE = Path(__file__).with_name("measured.json")


def read(results: Path) -> dict[str, dict[str, float]]:
    """Return step -> `memory_mb` and `time_s` of the largest job in a results folder."""
    found: dict[str, dict[str, float]] = {}
    for path in sorted((results / "benchmarks").glob("*/*.tsv")):
        with path.open(encoding="utf-8") as file:
            for row in csv.DictReader(file, delimiter="\t"):
                if "NA" in (row["max_rss"], row["cpu_time"]):  # ended before it was looked at
                    continue
                step = found.setdefault(path.parent.name, {"memory_mb": 0.0, "time_s": 0.0})
                step["memory_mb"] = max(step["memory_mb"], float(row["max_rss"]))
                step["time_s"] = max(step["time_s"], float(row["cpu_time"]))
    return found


def main(folders: list[str]) -> None:
    table: dict[str, dict[str, float]] = json.loads(TABLE.read_text(encoding="utf-8")) if TABLE.exists() else {}
    for folder in folders:
        for step, took in read(Path(folder)).items():
            known = table.get(step, {})
            table[step] = {name: max(value, known.get(name, 0.0)) for name, value in took.items()}
    TABLE.write_text(json.dumps(table, indent=1, sort_keys=True) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
