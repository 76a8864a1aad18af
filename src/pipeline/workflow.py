"""What the Snakefile asks: which plan, which receipts, which command."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from pipeline import planfile, store
from pipeline.errors import UserError


class Workflow:
    """One plan as Snakemake sees it: receipts are the files, chunks the wildcard."""

    def __init__(
        self,
        config: Mapping[str, Any],
        results: Path = store.RESULTS,
        tidy: bool = True,
        asked: Collection[str] = (),
    ) -> None:
        """Open the plan that `config` names, or make it from its overrides.

        Arguments
        ---------
        config : Snakemake's `--config`: `plan=FILE`, or `overrides="..."`, or nothing for the default studies; and
            `tell=false` where whoever called tells the end itself.
        tidy : delete receipts that the store no longer honours; not when another process runs the workflow.
        asked : words of the command line; studies that none of its targets needs are not composed.
        """
        self.results = results
        self.tells = str(config.get("tell", True)).lower() != "false"
        self.file = _plan_file(config, results, asked)
        self.plan = planfile.load(self.file)
        for name in sorted({*planfile.TARGETS, *planfile.studies()} & set(asked)):
            planfile.target(self.plan, name)
        self.asked = [name for name in self.plan["targets"] if name in asked] or ["all"]
        if tidy:
            store.drop_broken_receipts(results, self.plan["chunks"])

    def target(self, name: str) -> list[str]:
        """Return the receipts a target stands for."""
        return [self._receipt(chunk) for chunk in self.plan["targets"].get(name, ())]

    def studies(self) -> list[str]:
        """Return the names of the plan's studies."""
        return sorted({run["study"] for run in self.plan["runs"]})

    def requests(self) -> list[str]:
        """Return the targets of the runs that `all` leaves out."""
        cards = [run["configuration"]["study"] for run in self.plan["runs"]]
        named = {target for card in cards for target in card.get("on_request", ())}
        return sorted(named & set(self.plan["targets"]))

    def tell(self) -> None:
        """Print which of the charges asked for missed all their goals, and where everything asked for is."""
        if not self.tells:
            return
        from pipeline.telling import tell

        for line in tell(self.plan, self.asked, self.results):
            print(line)

    def needs(self, chunk: str) -> list[str]:
        """Return the receipts that must be there before a chunk runs."""
        return [self._receipt(name) for name in self.plan["chunks"][chunk]["needs"]]

    def receipt(self, step: str) -> str:
        """Return the receipt of a step's chunks, with the wildcard `chunk`."""
        return str(store.receipt(self.results, step, "{chunk}"))

    def log(self, step: str) -> str:
        """Return the log file of a step's chunks, with the wildcard `chunk`."""
        return str(self.results / "logs" / step / "{chunk}.log")

    def benchmark(self, step: str) -> str:
        """Return the file of times and memory of a step's chunks, with the wildcard `chunk`."""
        return str(self.results / "benchmarks" / step / "{chunk}.tsv")

    def command(self, step: str) -> str:
        """Return the shell command of a step's chunks, with Snakemake's names in braces."""
        words = [sys.executable, "-m", "pipeline.steps", "--plan", str(self.file), "--step", step]
        line = f"{shlex.join(words)} --chunk {{wildcards.chunk:q}} {{params.again}}"
        return f"OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 {line} > {{log:q}} 2>&1"

    def _receipt(self, chunk: str) -> str:
        return str(store.receipt(self.results, self.plan["chunks"][chunk]["step"], chunk))


def open_workflow(config: Mapping[str, Any], tidy: bool = True) -> Workflow:
    """Open the workflow; a person's mistake ends with one message and exit code 2, nothing written.

    Which targets are asked for is read from the command line: Snakemake itself says so only after this file is read.
    """
    try:
        return Workflow(config, tidy=tidy, asked=frozenset(sys.argv[1:]))
    except UserError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(2)


def forced(rule: str, settings: Any) -> bool:
    """Tell whether Snakemake was asked to run a rule although its receipt is there (`-F`, or `-R` with its name)."""
    return bool(settings.forceall) or rule in {str(name) for name in settings.forcerun}


def _plan_file(config: Mapping[str, Any], results: Path, asked: Collection[str]) -> Path:
    unknown = set(config) - {"plan", "overrides", "tell"}
    if unknown:
        raise UserError(f'--config {", ".join(sorted(unknown))}: unknown; allowed are plan=FILE and overrides="..."')
    if config.get("plan"):
        return Path(str(config["plan"]))
    # Composition needs Hydra; a job that is handed a plan does without.
    from pipeline.config.compose import cards, expand
    from pipeline.plan import make_plan

    overrides = config.get("overrides")
    if overrides:
        return planfile.save(make_plan(expand(split_overrides(str(overrides))), asked), results)
    return planfile.save(make_plan([[f"study={name}"] for name in wanted(cards(), asked)], asked), results)


def wanted(cards: Mapping[str, Mapping[str, Any]], asked: Collection[str]) -> list[str]:
    """Return the studies to compose: those asked for where nothing else is, else all but those that stand apart.

    Arguments
    ---------
    cards : name of a study -> its card.
    asked : words of the command line; those that are no targets are passed over.
    """
    from pipeline.config.study import RESERVED

    requests = {target for card in cards.values() for target in card.get("on_request", ())}
    others = {word for word in asked if word in RESERVED | requests or "/" in word}
    named = [name for name in cards if name in asked]
    if named and not others:
        return named
    return [name for name, card in cards.items() if name in asked or not card.get("apart", False)]


def split_overrides(text: str) -> list[str]:
    """Split the words of `--config overrides="..."` as a shell would."""
    try:
        return shlex.split(text)
    except ValueError as error:
        raise UserError(f"--config overrides={text!r}: {error}") from None
