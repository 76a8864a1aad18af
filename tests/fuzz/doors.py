"""The front doors: whatever takes a person's words or files, in this process and as real commands."""

from __future__ import annotations

import contextlib
import os
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

from pipeline.__main__ import COMMANDS
from pipeline.commands.workflow import Workflow
from pipeline.config import yaml_file
from pipeline.config.choices import parse
from pipeline.config.compose import Composed, compose_tree, expand
from pipeline.config.effort import check_effort
from pipeline.config.planning import make_plan
from pipeline.config.study import study_from
from pipeline.errors import UserError
from pipeline.kernel.draft import drafts

ROOT = Path(__file__).resolve().parents[2]
LONGEST = 4000


@dataclass(frozen=True)
class Outcome:
    """What a door made of wrong input.

    Arguments
    ---------
    word : `refused`, `taken`, or `broken`.
    told : the message, or what broke.
    """

    word: str
    told: str = ""


def _judged(run: Callable[[], object]) -> Outcome:
    try:
        run()
    except UserError as error:
        return Outcome("refused", str(error))
    except Exception as error:
        return Outcome("broken", f"{type(error).__name__}: {error}"[:300])
    return Outcome("taken")


def planned(words: Sequence[str]) -> Outcome:
    """Plan, as `python -m pipeline` does before it calls Snakemake."""
    return _judged(lambda: make_plan(expand(words)))


def workflow(words: Sequence[str]) -> Outcome:
    """Open the workflow, as the Snakefile does with `--config overrides=`."""
    with tempfile.TemporaryDirectory() as folder:
        results = Path(folder) / "results"
        outcome = _judged(lambda: Workflow({"overrides": shlex.join(words)}, results=results, purpose="look"))
        if outcome.word == "refused" and results.exists():
            return Outcome("broken", f"results/ was written before it was refused: {outcome.told}")
        return outcome


@cache
def _composed(words: tuple[str, ...]) -> Composed:
    return compose_tree(words)


def checked(words: Sequence[str]) -> Outcome:
    """Validate a composed study with one value put in, and estimate its effort: planning without its slow parts."""
    *before, word = words
    if any(sign in word for sign in ("${", "???", "range(")):
        return planned(words)  # what Hydra and OmegaConf make of it is what is asked

    def run() -> None:
        (override,) = parse([word])
        value = override.value()
        whole = _composed(tuple(before))
        tree = deepcopy(whole.tree)
        *parents, last = override.key_or_group.split(".")
        here: Any = tree
        for key in parents:
            here = here[key]
        here[last] = getattr(value, "text", value)
        one = replace(whole, tree=tree, overrides=tuple(words))
        study = study_from(one)
        check_effort(one, study, drafts(study))

    return _judged(run)


INSIDE: Mapping[str, Callable[[Sequence[str]], Outcome]] = {"make_plan": planned, "Snakefile": workflow}
"""Doors in this process, by name; each takes the words of a command line."""
REAL: Mapping[str, Callable[[Sequence[str]], list[str]]] = {
    "python -m pipeline run -n": lambda words: ["pipeline", "run", "-n", *words],
    "python -m pipeline --cfg": lambda words: ["pipeline", "--cfg", *words],
    "python -m pipeline -m -n": lambda words: ["pipeline", "-m", "-n", *words],
    "snakemake -n --config overrides=": lambda words: [
        *("snakemake", "-n", "--cores", "1", "--snakefile", str(ROOT / "Snakefile"), "all"),
        *("--config", f"overrides={shlex.join(words)}"),
    ],
    **{
        f"python -m pipeline {name}": (lambda words, name=name: ["pipeline", name, *words])  # type: ignore[misc]
        for name in COMMANDS
        if name != "run"
    },
    "python -m pipeline compare-modes": lambda words: [
        *("pipeline", "compare-modes", "--battery", "lead_acid_12v7ah", "--panel", "kc65t", "--modes", "cc_cv"),
        *words,
    ],
}
"""Real commands, by name: words -> arguments of `python -m`. A new word of the program is one of them by itself."""


def really(door: str, words: Sequence[str], folder: Path) -> Outcome:
    """Run a command in an empty folder; refused is exit code 2, one message, and nothing written."""
    kept = {key: value for key, value in os.environ.items() if not key.startswith(("PYTEST", "SNAKEMAKE"))}
    done = subprocess.run(
        [sys.executable, "-m", *REAL[door](words)],
        cwd=folder,
        env=kept | {"PYTHONPATH": str(ROOT / "src")},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
        timeout=300,
    )
    told = done.stdout
    written = [str(path.relative_to(folder)) for room in ("results", "reports") for path in folder.glob(f"{room}/**/*")]
    if "Traceback" in told:
        return Outcome("broken", told[-600:])
    if done.returncode == 0:
        return Outcome("taken", told)
    if done.returncode != 2:
        return Outcome("broken", f"exit code {done.returncode}: {told[-600:]}")
    if written:
        return Outcome("broken", f"refused, and written: {written[:5]}")
    lines = told.strip().splitlines()
    errors = [line for line in lines if line.startswith("error: ") or ": error: " in line]
    if len(errors) != 1:
        return Outcome("broken", f"{len(errors)} messages: {told[-600:]}")
    return Outcome("refused", "\n".join(lines[lines.index(errors[0]) :]).split("error: ", 1)[1])


def fault(outcome: Outcome, word: str) -> str | None:
    """Return what is wrong with a refusal's message: it begins with the override or a file, and is no raw text."""
    if outcome.word == "broken":
        return outcome.told
    if outcome.word != "refused":
        return None
    lines = outcome.told.splitlines()
    key = word.split("=", 1)[0]
    begins = (f"override {key}", "override ", "conf/", "parameters without a source")
    if not lines or not lines[0].startswith(begins) or any(raw in outcome.told for raw in _RAW):
        return f"message: {outcome.told[:300]}"
    return f"message of {len(outcome.told)} letters" if len(outcome.told) > LONGEST else None


_RAW = ("full_key", "object_type", "DictConfig", "ListConfig", "omegaconf", "pydantic", "Traceback", "NoneType")


def as_file(conf: Path, word: str, study: str) -> Outcome:
    """Put the value of an override into a YAML file of a study in another folder of groups, and validate that."""
    key, _, value = word.lstrip("+~").partition("=")
    lines = [f"{'  ' * depth}{part}:" for depth, part in enumerate(key.split("."))]
    text = "\n".join(["# @package _global_", f"defaults: [{study}, _self_]", *lines]) + f" {value}\n"
    file = conf / "study" / "odd.yaml"
    with contextlib.suppress(FileNotFoundError):
        file.unlink()
    file.write_text(text)
    outcome = _judged(lambda: study_from(compose_tree(["study=odd"], conf)))
    here = yaml_file.shown(conf)
    return replace(outcome, told=outcome.told.replace(here, "conf"))


def files_below(folder: Path) -> Iterator[str]:
    """Yield every file below a folder."""
    yield from sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))
