"""`python -m tests.faults [--short]`: strikes, counts, prints a table; returns 1 where anything did not end right."""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import time
from pathlib import Path

from tests.faults.commands import strike_commands
from tests.faults.struck import Tally, strike_everywhere


def main() -> int:
    """Strike everywhere; print what was struck and how much of it ended right."""
    parser = argparse.ArgumentParser(prog="python -m tests.faults", description=__doc__)
    parser.add_argument("--short", action="store_true", help="the form of about two minutes, for every change")
    parser.add_argument("--instant", action="store_true", help="instant steps alone, no real command")
    parser.add_argument("--seed", type=int, default=1, help="of the random kills (%(default)s)")
    choices = parser.parse_args()
    tally = Tally()
    began = time.monotonic()
    # In memory where there is room: what is told to the disk does not matter to a process that is killed.
    memory = Path("/dev/shm")
    with tempfile.TemporaryDirectory(prefix="faults-", dir=memory if os.access(memory, os.W_OK) else None) as folder:
        tally.add(strike_everywhere(Path(folder) / "struck", 1 if choices.short else 3))
        print(f"instant steps: {time.monotonic() - began:.0f} s", flush=True)
        if not choices.instant:
            tally.add(strike_commands(Path(folder) / "commands", choices.short, choices.seed))
    print(f"{'kind':<60} {'struck':>6} {'right':>6}")
    for kind, count in sorted(tally.struck.items()):
        print(f"{kind:<60} {count:>6} {tally.right[kind]:>6}")
    print(f"{'all':<60} {tally.struck.total():>6} {tally.right.total():>6}   in {time.monotonic() - began:.0f} s")
    for fault in tally.wrong[:50]:
        print(f"wrong: {fault}")
    return 1 if tally.wrong else 0


if __name__ == "__main__":
    sys.exit(main())
