"""The plan as a file: what the jobs and the workflow read; light, so that no job imports Hydra."""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pipeline import digest, store
from pipeline.errors import UserError

VERSION = 1
# The order of the steps; a chunk needs only chunks of earlier steps.
STEPS = (
    "panel", "supply", "tracking", "converters", "chaos", "objective", "tuning", "search",
    "surface", "network", "network_size", "network_kernels",
    "staging_search", "function_runs", "staging", "front", "functions",
    "engine", "charge", "switched", "ensemble", "trade_off", "validation", "weather", "daylight", "day", "verdicts",
    "figures", "page",
)  # fmt: skip
# Parts of a run that people can ask for, with the steps that make them.
TARGETS = {
    "panel": ("panel", "supply", "tracking", "converters"),
    "tuning": ("tuning",),
    "search": ("chaos", "objective", "search"),
    "network": ("surface", "network", "network_size", "network_kernels"),
    "staging": ("staging_search", "staging", "front"),
    "functions": ("function_runs", "functions"),
    "charges": ("charge", "switched", "trade_off"),
    "day": ("weather", "daylight", "day"),
    "figures": ("figures",),
}


def save(plan: Mapping[str, Any], results: Path) -> Path:
    """Write the plan under its digest, unless it is there; return the file."""
    path = results / "plan" / f"{digest.of_value(plan)[:16]}.json"
    if not path.is_file():
        store.write_text(path, json.dumps(plan, indent=1, ensure_ascii=False, allow_nan=False))
    return path


def load(path: Path) -> dict[str, Any]:
    """Read a plan; raise `UserError` where there is none."""
    try:
        plan: dict[str, Any] = json.loads(path.read_text())
    except FileNotFoundError:
        raise UserError(f"plan {path}: no such file") from None
    except ValueError as error:
        raise UserError(f"plan {path}: not JSON ({error})") from None
    if not isinstance(plan, dict) or plan.get("version") != VERSION or not {"runs", "nodes", "chunks"} <= set(plan):
        raise UserError(f"plan {path}: not a plan of version {VERSION}; make it anew with --config overrides=...")
    return plan


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


def studies() -> list[str]:
    """Return the names of all studies."""
    return sorted(path.stem for path in (digest.PROJECT / "conf" / "study").glob("*.yaml"))


def command(study: str, overrides: Sequence[str]) -> str:
    """Return the command that makes a run of a study."""
    if not overrides:
        return f"snakemake --cores 2 {study}"
    words = " ".join([f"study={study}", *(shlex.quote(word) for word in overrides)])
    return f"snakemake --cores 2 all --config overrides={shlex.quote(words)}"
