"""`python -m pipeline store [list|verify|clean]`: what the store holds, whether it is whole, what no run needs."""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

from pipeline.kernel import store
from pipeline.kernel.store import RESULTS


def main(arguments: Sequence[str]) -> int:
    """List, verify or clean the store; return 1 where an artefact is damaged."""
    parser = argparse.ArgumentParser(prog="python -m pipeline store", description=__doc__)
    parser.add_argument("word", nargs="?", choices=("list", "verify", "clean"), default="list")
    word = parser.parse_args(arguments).word
    folders = list(_artefacts(RESULTS))
    if word == "verify":
        faults = [fault for folder in folders if (fault := store.damage(folder)) is not None]
        for fault in faults:
            print(f"damaged: {fault}")
        print(f"{len(folders) - len(faults)} artefacts whole, {len(faults)} damaged")
        return 1 if faults else 0
    if word == "clean":
        needed = _needed(RESULTS)
        unneeded = [folder for folder in folders if f"{folder.parent.name}/{folder.name}" not in needed]
        for folder in unneeded:
            store.remove(folder)
        print(f"{len(unneeded)} artefacts that no published run names removed, {len(folders) - len(unneeded)} kept")
        return 0
    for step, count in sorted(Counter(folder.parent.name for folder in folders).items()):
        print(f"{step:<12} {count:>6}")
    return 0


def _artefacts(results: Path) -> Iterator[Path]:
    for contents in sorted((results / "store").glob(f"*/*/{store.CONTENTS}")):
        if not contents.parent.name.startswith("."):
            yield contents.parent


def _needed(results: Path) -> set[str]:
    """Return step/key of every node of the runs that are published, whole or in part."""
    manifests = [json.loads(path.read_text()) for path in results.glob("*/*/manifest*.json")]
    return {f"{node['step']}/{node['key']}" for manifest in manifests for node in manifest["nodes"].values()}
