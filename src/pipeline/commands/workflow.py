"""What the Snakefile asks: which plan, which receipts, which command."""

from __future__ import annotations

import contextlib
import io
import shlex
import sys
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any, Literal

from pipeline.commands.terminal import printed
from pipeline.errors import UserError
from pipeline.kernel import archive, lock, planfile, publish, receipts, store
from pipeline.kernel.last_resort import in_utf8, last_resort, refuse_other_bytes
from pipeline.kernel.publish import view_folder

MOST_RUNS = 8


def tell(plan: Mapping[str, Any], targets: Iterable[str], results: Path) -> Iterator[str]:
    """Yield what there is to say of the runs that some targets of a plan made, whole or in part."""
    made = _made(plan, targets)
    for run, steps in made:
        for module in plan["tells"]:
            yield from import_module(module).lines(run, steps, results)
    for run, steps in made[:MOST_RUNS]:
        yield f"results: {view_folder(results, run, 'results')}"
        if any(item["step"] in steps and item["room"] == store.REPORTS and not item["place"] for item in run["view"]):
            yield f"the page: {view_folder(results, run, 'reports') / 'index.html'}"
    if len(made) > MOST_RUNS:
        yield f"and {len(made) - MOST_RUNS} more runs beside them"


def _made(plan: Mapping[str, Any], targets: Iterable[str]) -> list[tuple[Mapping[str, Any], set[str]]]:
    """Return each run that some targets make, with the steps of it that they publish."""
    steps: dict[int, set[str]] = {}
    for name in targets:
        for chunk in (plan["chunks"][chunk] for chunk in plan["targets"][name]):
            for number in chunk["runs"]:
                steps.setdefault(number, set()).update(chunk["steps"])
    return [(plan["runs"][number], steps[number]) for number in sorted(steps)]


CHUNK = "{wildcards.chunk}"
"""How Snakemake's messages name the job."""
STALE = "~"
"""Behind the name of a chunk whose receipt is there but would be deleted by a run: to a dry run it is missing."""
BESIDE_MB = 400
"""Memory of the two processes of Snakemake that run a job on another machine [MB]."""
_PLAN_IN_MEMORY = 6.0  # of its size as a file, in every process that reads it
Purpose = Literal["run", "look", "job"]
# Options of Snakemake with which it makes nothing.
_LOOKING = (
    *("dryrun", "lint", "list_target_rules", "list_rules", "print_compilation", "containerize", "generate_unit_tests"),
    *("dag", "rulegraph", "filegraph", "d3dag", "unlock", "cleanup_metadata", "list_conda_envs", "list_changes"),
    *("report", "list_input_changes", "list_params_changes", "list_untracked", "summary", "detailed_summary"),
)


class Workflow:
    """One plan as Snakemake sees it: receipts are the files, chunks the wildcard."""

    def __init__(
        self,
        config: Mapping[str, Any],
        results: Path = store.RESULTS,
        purpose: Purpose = "run",
        asked: Collection[str] = (),
    ) -> None:
        """Open the plan that `config` names, or make it from its overrides.

        Arguments
        ---------
        config : Snakemake's `--config`: `plan=FILE`, or `overrides="..."`, or nothing for the default studies; and
            `tell=false` where whoever called tells the end itself; `verify=true` to read every file made before.
        purpose : `run` takes the folder's lock and deletes receipts that the store no longer honours; `look` shows them
            as missing and changes nothing; `job` is a part of a run that another process has begun.
        asked : words of the command line; studies that none of its targets needs are not composed.
        """
        self.results = results
        self.tells = str(config.get("tell", True)).lower() != "false"
        self.file = _plan_file(config, results, asked)
        self.plan = planfile.load(self.file)
        for name in sorted({*planfile.targets(self.plan), *planfile.studies()} & set(asked)):
            planfile.target(self.plan, name)
        self.asked = [name for name in self.plan["targets"] if name in asked] or ["all"]
        self._stale: set[str] = set()
        if purpose == "job":
            return
        for line in planfile.remarks(self.plan) if not config.get("plan") else ():
            say(line)
        publish.own(self.plan, results)
        if purpose == "run":
            lock.take(results, say)
        verify = str(config.get("verify", False)).lower() == "true"
        look = purpose == "look"
        dropped = receipts.drop_broken(results, self.plan["chunks"], verify, say, look)
        outdated = publish.drop_outdated(self.plan, results, self.files(), look)
        self._stale = {*dropped, *outdated} if look else set()

    def target(self, name: str) -> list[str]:
        """Return the receipts a target stands for."""
        return [self._receipt(chunk) for chunk in self.plan["targets"].get(name, ())]

    def targets(self) -> list[str]:
        """Return the parts of a run that people can ask for, the report among them."""
        return [*planfile.targets(self.plan), "report"]

    def steps(self) -> dict[str, dict[str, Any]]:
        """Return name -> declaration of every step, the publishing of runs last; its rule, its message."""
        publishing = {"rule": "publish_run", "message": "Publishing: {chunk}", "priority": 0}
        declared = {**self.plan["steps"], "publish": publishing}
        return {name: one | {"message": one["message"].format(chunk=CHUNK)} for name, one in declared.items()}

    def files(self) -> dict[str, str]:
        """Return the files of the readable views that are asked for by their paths -> the chunk that places each."""
        return {path: names[0] for path, names in self.plan["targets"].items() if "/" in path}

    @staticmethod
    def word(chunk: str) -> str:
        """Return the name of a chunk as a part of the name of a rule."""
        return "".join(letter if letter.isalnum() else "_" for letter in chunk)

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
        from pipeline.commands.workflow import tell

        for line in tell(self.plan, self.asked, self.results):
            print(line)

    def needs(self, chunk: str, carried: bool = False) -> list[str]:
        """Return the receipts that must be there before a chunk runs.

        Arguments
        ---------
        carried : what jobs make is carried from machine to machine: their archives too.
        """
        chunks = self.plan["chunks"]
        names = chunks[chunk.removesuffix(STALE)]["needs"]
        archives = [one.format(chunk=name) for name in names for one in self.archives(chunks[name]["step"], carried)]
        return [*(self._receipt(name) for name in names), *archives]

    def archives(self, step: str, carried: bool) -> list[str]:
        """Return the archive that a step's chunks make, with the wildcard `chunk`; none where nothing is carried."""
        return (
            [str(self.results / "archives" / step / f"{{chunk}}{archive.SUFFIX}")]
            if carried and step != "publish"
            else []
        )

    def placed(self, path: str, chunk: str) -> list[str]:
        """Return a file that is asked for by its path; one that would be placed anew, with what is missing of it."""
        return [path, *([self._receipt(chunk)] if chunk in self._stale else [])]

    def told(self, path: str) -> str:
        """Return what a figure that is asked for by its path shows, for the caption in a report of Snakemake's own;
        nothing for any other file.
        """
        _, study, name, *inside = path.split("/")
        runs = [run for run in self.plan["runs"] if (run["study"], run["name"]) == (study, name)]
        cards = [run["configuration"].get("figures", {}) for run in runs if inside[:1] == ["figures"]]
        card = next((found[Path(path).stem] for found in cards if Path(path).stem in found), None)
        return "" if card is None else f"{card.get('paper') or ''} {card['title']}. {card['caption']}".strip()

    def receipt(self, step: str) -> str:
        """Return the receipt of a step's chunks, with the wildcard `chunk`."""
        return str(receipts.path_of(self.results, step, "{chunk}"))

    def log(self, step: str) -> str:
        """Return the log file of a step's chunks, with the wildcard `chunk`."""
        return str(self.results / "logs" / step / "{chunk}.log")

    def benchmark(self, step: str) -> str:
        """Return the file of times and memory of a step's chunks, with the wildcard `chunk`."""
        return str(self.results / "benchmarks" / step / "{chunk}.tsv")

    def takes(self, chunk: str, what: str, attempt: int = 1, elsewhere: bool = False) -> int:
        """Return what a job is to be given.

        Arguments
        ---------
        what : `threads`, `mem_mb` or `runtime` [min].
        attempt : of the second on, twice the memory and the time of the one before.
        elsewhere : not on this machine: with the job run two processes of Snakemake.
        """
        found: int = self.plan["chunks"][chunk.removesuffix(STALE)]["resources"][what]
        if what == "mem_mb":
            in_memory_mb = round(_PLAN_IN_MEMORY * self.file.stat().st_size / 1e6)
            found += BESIDE_MB + 3 * in_memory_mb if elsewhere else in_memory_mb
        return found if what == "threads" else found * 2 ** (attempt - 1)

    def handed_on(self) -> list[str]:
        """Return the `--config` of the processes that Snakemake starts for jobs elsewhere: the plan."""
        return [f"plan={self.file}", "tell=false"]

    def command(
        self, step: str, chunk: str, again: bool = False, take: Sequence[str] = (), give: Sequence[str] = ()
    ) -> str:
        """Return the shell command of a job.

        Arguments
        ---------
        again : compute what is there already, and compare.
        take, give : files that were carried here, and those to be carried on.
        """
        chunk = chunk.removesuffix(STALE)
        words = [sys.executable, "-m", "pipeline.kernel.run", "--plan", str(self.file), "--step", step]
        words += ["--chunk", chunk, *(["--again"] if again else [])]
        line = shlex.join([*words, *(["--take", *take] if take else []), *(["--give", *give] if give else [])])
        log = shlex.quote(self.log(step).format(chunk=chunk))
        return f"OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 {line} > {log} 2>&1"

    def _receipt(self, chunk: str) -> str:
        name = f"{chunk}{STALE}" if chunk in self._stale else chunk
        return str(receipts.path_of(self.results, self.plan["chunks"][chunk]["step"], name))


def open_workflow(config: Mapping[str, Any], main_process: bool = True) -> Workflow:
    """Open the workflow; a person's mistake ends with one message and exit code 2, nothing written.

    Which targets are asked for is read from the command line: Snakemake itself says so only after this file is read.

    Arguments
    ---------
    main_process : not one that Snakemake has started for a job.
    """
    if main_process:
        in_utf8()
    words = sys.argv[1:]
    purpose: Purpose = "job" if not main_process else "look" if only_looks(words) else "run"
    try:
        refuse_other_bytes(words)
        return Workflow(config, purpose=purpose, asked=frozenset(words))
    except UserError as error:
        say(f"error: {error}")
        sys.exit(2)
    except KeyboardInterrupt:
        say("ended by a signal; the same command goes on where it was")
        sys.exit(130)
    except Exception as error:  # the last resort: one line for a person, the rest for whoever mends the program
        say(f"error: {last_resort(error, store.RESULTS)}")
        sys.exit(1)


def only_looks(words: Sequence[str]) -> bool:
    """Tell whether a command line of Snakemake makes nothing: `-n`, `--list-rules`, `--dag` and their like."""
    from snakemake.cli import get_argument_parser

    with contextlib.redirect_stderr(io.StringIO()):
        try:
            chosen = vars(get_argument_parser().parse_known_args(list(words))[0])
        except SystemExit:
            return False
    return any(chosen.get(name) not in (None, False, [], "") for name in _LOOKING)


def say(line: str) -> None:
    """Tell a person what is going on, beside what was asked for."""
    print(printed(line), file=sys.stderr, flush=True)


def forced(rule: str, settings: Any) -> bool:
    """Tell whether Snakemake was asked to run a rule although its receipt is there (`-F`, or `-R` with its name)."""
    return bool(settings.forceall) or rule in {str(name) for name in settings.forcerun}


def _plan_file(config: Mapping[str, Any], results: Path, asked: Collection[str]) -> Path:
    unknown = set(config) - {"plan", "overrides", "tell", "verify"}
    if unknown:
        raise UserError(f'--config {", ".join(sorted(unknown))}: unknown; allowed are plan=FILE and overrides="..."')
    if config.get("plan"):
        return Path(str(config["plan"]))
    overrides = as_typed(str(config.get("overrides") or ""), sys.argv)
    question = ["snakemake", overrides, *sorted(asked)]
    return planfile.save(planfile.remembered(question, lambda: _planned(overrides, asked)), results, say)


def _planned(overrides: str, asked: Collection[str]) -> dict[str, Any]:
    # Composition needs Hydra; who is handed a plan, or has made it before, does without.
    from pipeline.config.compose import cards, expand
    from pipeline.config.planning import make_plan

    runs = expand(split_overrides(overrides)) if overrides else [[f"study={name}"] for name in wanted(cards(), asked)]
    return make_plan(runs, asked)


def wanted(cards: Mapping[str, Mapping[str, Any]], asked: Collection[str]) -> list[str]:
    """Return the studies to compose: those asked for where nothing else is, else all but those that stand apart.

    Arguments
    ---------
    cards : name of a study -> its card.
    asked : words of the command line; those that are no targets are passed over.
    """
    from pipeline.config.study import reserved

    requests = {target for card in cards.values() for target in card.get("on_request", ())}
    others = {word for word in asked if word in reserved() | requests}
    # A file of a readable view says by its path which study makes it.
    of_files = {word.split("/")[1] for word in asked if word.split("/")[0] in ("results", "reports") and "/" in word}
    # One that names no study, as a file of the store, may belong to any.
    others |= of_files - set(cards)
    asked = {*asked, *of_files}
    named = [name for name in cards if name in asked]
    if named and not others:
        return named
    return [name for name, card in cards.items() if name in asked or not card.get("apart", False)]


def as_typed(overrides: str, typed: Sequence[str]) -> str:
    """Return the words of `--config overrides=` as they were typed: Snakemake strips quotes, and comments of YAML.

    Arguments
    ---------
    overrides : as Snakemake hands them on.
    typed : words of the command line, which go before any file; where none of them is it, they stay as they are.
    """
    given = [word.removeprefix("overrides=") for word in typed if word.startswith("overrides=")]
    return given[-1] if given and overrides else overrides


def split_overrides(text: str) -> list[str]:
    """Split the words of `--config overrides="..."` as a shell would."""
    try:
        return shlex.split(text)
    except ValueError as error:
        raise UserError(f"--config overrides={text!r}: {error}") from None
