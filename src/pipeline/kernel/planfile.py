"""The plan as a file: what the jobs and the workflow read; light, so that no job imports Hydra or an experiment."""

from __future__ import annotations

import json
import re
import shlex
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from pipeline.kernel import digest, kept, places, store
from pipeline.kernel.errors import UserError
from pipeline.kernel.last_resort import remedy

VERSION = 5
_MOST_KEPT = 64
_DIGEST = re.compile("[0-9a-f]{16}")


def remembered(question: Sequence[str], make: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    """Return a plan as an earlier process made it, where nothing that planning reads has changed since; else make it.

    Arguments
    ---------
    question : what was asked: the front door and its words.
    make : plans; every file of a person's that it reads has its digest taken by `digest.of_file`.
    """
    folders = [places.PACKAGE, *places.confs()]
    state = [[digest.of_folder(folder) for folder in folders], digest.of_lock(), sys.version, str(Path.cwd())]
    name = f"plans/{digest.of_value([list(question), state])}.json"
    found = kept.read(name)
    if found is not None and all(_is_still(Path(path), sha256) for path, sha256 in found["files"].items()):
        plan: dict[str, Any] = found["plan"]
        return plan
    with digest.recorded() as files:
        plan = make()
    kept.write(name, {"files": files, "plan": plan}, _MOST_KEPT)
    return plan


def _is_still(path: Path, sha256: str) -> bool:
    try:
        return digest.of_file(path) == sha256
    except OSError:
        return sha256 == digest.ABSENT


def save(plan: Mapping[str, Any], results: Path, say: Callable[[str], None] = lambda line: None) -> Path:
    """Write the plan under its digest, unless it is there as it should be; return the file.

    Arguments
    ---------
    say : takes a line where one was there that had been cut short or edited.

    Raises
    ------
    UserError : it cannot be written.
    """
    text = json.dumps(plan, indent=1, ensure_ascii=False, allow_nan=False)
    found = digest.of_value(json.loads(text))
    text = json.dumps({"digest": found, **plan}, indent=1, ensure_ascii=False, allow_nan=False)
    path = results / "plan" / f"{found[:16]}.json"
    try:
        store.own(results, path)
        there = path.is_file() and not path.is_symlink()
        if there and path.read_bytes() == text.encode():
            return path
        if there or path.is_symlink() or path.exists():
            say(f"plan {path}: changed since it was made; made anew")
            store.remove(path)
        store.write_text(path, text)
    except OSError as error:
        raise UserError(f"plan {remedy(error, path) or f'{path}: {error.strerror}'}") from None
    return path


def load(path: Path) -> dict[str, Any]:
    """Read a plan; raise `UserError` where there is none, or it is not as it was made."""
    anew = "remove it and make it anew with --config overrides=..."
    try:
        plan: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise UserError(f"plan {path}: no such file") from None
    except OSError as error:
        raise UserError(f"plan {path}: cannot be read ({error.strerror})") from None
    except (ValueError, RecursionError) as error:
        raise UserError(f"plan {path}: not JSON ({error}); {anew}") from None
    if not isinstance(plan, dict) or plan.get("version") != VERSION or not {"runs", "nodes", "chunks"} <= set(plan):
        raise UserError(f"plan {path}: not a plan of version {VERSION}; {anew}")
    said = plan.pop("digest", None)
    if digest.of_value(plan) != said or (_DIGEST.fullmatch(path.stem) and not said.startswith(path.stem)):
        raise UserError(f"plan {path}: changed since it was made; {anew}")
    return plan


def settings(plan: Mapping[str, Any], key: str) -> dict[str, Any]:
    """Return the settings of a node; what many nodes of a sweep have in common stands in the plan once."""
    node = plan["nodes"][key]
    if "parts" not in node:
        found: dict[str, Any] = node["settings"]
        return found
    return {name: plan["parts"][part] for name, part in node["parts"].items()}


def target(plan: Mapping[str, Any], name: str) -> list[str]:
    """Return the chunks that a target stands for.

    Raises
    ------
    UserError : the plan has no such target; those it has are named.
    """
    targets: dict[str, list[str]] = plan["targets"]
    if name in targets:
        return targets[name]
    planned = ", ".join(dict.fromkeys(run["study"] for run in plan["runs"]))
    if name in studies():
        raise UserError(f"target {name!r}: not planned, {planned} is; choose the study with study={name}")
    raise UserError(f"target {name!r}: {planned} has no such part; it has: {', '.join(targets)}")


def targets(plan: Mapping[str, Any]) -> list[str]:
    """Return the parts of a run that people can ask for, each step's target once."""
    return list(dict.fromkeys(step["target"] for step in plan["steps"].values() if step["target"] is not None))


def studies() -> list[str]:
    """Return the names of all studies."""
    return sorted({path.stem for conf in places.confs() for path in (conf / "study").glob("*.yaml")})


def command(study: str, overrides: Sequence[str]) -> str:
    """Return the command that makes a run of a study."""
    if not overrides:
        return f"snakemake --cores 2 {study}"
    words = " ".join([f"study={study}", *(shlex.quote(word) for word in overrides)])
    return f"snakemake --cores 2 all --config overrides={shlex.quote(words)}"


def remarks(plan: Mapping[str, Any]) -> list[str]:
    """Return what whoever makes a plan is told of its runs, each sentence once."""
    told = [f"note: {run['study']}: {line}" for run in plan["runs"] for line in run["remarks"]]
    return list(dict.fromkeys(told))
