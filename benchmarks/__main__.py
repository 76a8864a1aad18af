"""`python -m benchmarks [NAME ...]`: measures what is named; `all`, all but the hour, without a name.

`table` writes the results on file into docs/speed.md and benchmarks/README.md.
Every row is measured before anything fails; then a row below half its figure, or with a larger error than asked,
makes the exit status 1.
"""

from __future__ import annotations

import importlib
import sys

from benchmarks import results
from benchmarks.protocol import Row

WITH_ROWS = ("edge", "averaged", "hour", "switched", "maximum_power", "chemistry", "day", "sweep", "own_fit")
OWN_OUTPUT = ("bound", "instructions", "genetic", "searches")
SLOW = ("hour", "instructions")


def main(arguments: list[str]) -> int:
    """Measure; return the exit status."""
    quick = [name for name in (*WITH_ROWS, *OWN_OUTPUT) if name not in SLOW]
    known = (*WITH_ROWS, *OWN_OUTPUT, "all", "table")
    for name in arguments:
        if name not in known:
            print(f"unknown benchmark {name!r}; known are: {', '.join(known)}", file=sys.stderr)
            return 2
    named = [one for name in arguments or ["all"] for one in (quick if name == "all" else [name])]
    failed: list[Row] = []
    for name in named:
        print(f"\n{name}", flush=True)
        if name == "table":
            results.write_tables(WITH_ROWS)
            continue
        module = importlib.import_module(f"benchmarks.{name}")
        if name in OWN_OUTPUT:
            module.main()
            continue
        about = results.facts(module.PACKAGES)
        rows = module.rows()
        results.save(name, rows, about)
        print(results.shown(rows), flush=True)
        failed += [row for row in rows if row.status == "fails"]
    for row in failed:
        print(f"FAILS: {row.name} vs {row.peer}", file=sys.stderr)
    return int(bool(failed))


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
