"""`python -m pipeline compare A B`: says whether two published runs hold the same artefacts, and which differ."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path

from pipeline.errors import UserError


def main(arguments: Sequence[str]) -> int:
    """Compare two runs, or every run of two results folders; return 0 where all artefacts are equal, else 1."""
    parser = argparse.ArgumentParser(prog="python -m pipeline compare", description=__doc__)
    parser.add_argument("first", type=Path, help="a run's folder with manifest.json, or a results folder")
    parser.add_argument("second", type=Path, help="the other one")
    options = parser.parse_args(arguments)
    first, second = artefacts(options.first), artefacts(options.second)
    differing = sorted(path for path in first.keys() & second.keys() if first[path] != second[path])
    for path in differing:
        print(f"differs   {path}")
    for name, here, there in ((options.first, first, second), (options.second, second, first)):
        for path in sorted(here.keys() - there.keys()):
            print(f"only in {name}: {path}")
    equal = len(first.keys() & second.keys()) - len(differing)
    print(f"{equal} artefacts equal, {len(differing)} differ, {len(first.keys() ^ second.keys())} on one side only")
    return 0 if first == second else 1


def artefacts(folder: Path) -> dict[str, str]:
    """Return place -> sha256 of every artefact that the manifests in a folder list, those of parts (`-t`) included."""
    own = sorted(folder.glob("manifest*.json"))
    manifests = own or sorted(folder.glob("*/*/manifest*.json"))
    if not manifests:
        raise UserError(f"{folder}: no manifest.json there; allowed is a run's folder or a results folder")
    single = bool(own)
    found: dict[str, str] = {}
    for path in manifests:
        manifest = json.loads(path.read_text())
        prefix = "" if single else f"{manifest['study']}/{manifest['run']}/"
        for entry in manifest["artefacts"]:
            place = Path(entry["path"])
            found[prefix + Path(place.parts[0], *place.parts[3:]).as_posix()] = entry["sha256"]
    return found
