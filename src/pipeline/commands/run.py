"""`python -m pipeline [run] [key=value ...]`: one run, or with -m a sweep, as one plan and one workflow."""

from __future__ import annotations

import argparse
import contextlib
import itertools
import os
import re
import signal
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from pipeline.commands import COMMANDS, OF_THE_REPOSITORY, Parser, profiles, typed
from pipeline.commands.progress import shown, through
from pipeline.commands.terminal import QUIET
from pipeline.commands.workflow import say, tell
from pipeline.errors import UserError, best_matches, closest
from pipeline.kernel import lock, planfile, publish, registry, store
from pipeline.kernel.places import place

CFG = ("job", "hydra", "all")
"""What --cfg prints: the composed configuration, what is used of Hydra, or both."""
_GROUPS = "conf/ of a project (charge-pipeline init) comes before the shipped one; study=NAME chooses the study"
INSTEAD = {
    **dict.fromkeys(("--config-name", "-cn", "--config-path", "-cp", "--config-dir", "-cd"), _GROUPS),
    **dict.fromkeys(("--shell-completion", "-sc"), "charge-pipeline completion bash, zsh or fish prints it"),
    **dict.fromkeys(("--hydra-help", "--version"), "--help tells the words and groups, --info the versions and files"),
    **dict.fromkeys(("--run", "-r"), "a run is what happens without -m"),
    "--experimental-rerun": "the same command goes on where it was; a manifest.json has the command of its run",
}
"""Option of Hydra that is none here -> what takes its place."""
_QUIET = ["--quiet", *QUIET]
EXAMPLES = {
    "": "the default study",
    "battery=lead_acid_12v18ah": "another battery",
    "modes.cv_reflex.frequency_hz=50": "another pulse frequency",
    "'modes.run=[cc_cv,cv_reflex]'": "two modes only",
    "-m battery=lead_acid_12v7ah,lead_acid_12v18ah": "a sweep: one plan, shared steps once",
}


def main(arguments: Sequence[str]) -> int:
    """Compose, plan and run; return Snakemake's exit code."""
    for word in (word for word in arguments if word.split("=", 1)[0] in INSTEAD):
        raise UserError(f"option {word}: {INSTEAD[word.split('=', 1)[0]]}")
    parser = _parser(listing=bool({"-h", "--help"} & set(arguments)))
    options_, overrides = parser.parse_known_intermixed_args(_with_kind(arguments))
    _refuse_mistyped(arguments[:1])
    unknown = [word for word in overrides if word.startswith("-")]
    if unknown:
        raise UserError(f"option {unknown[0]}: unknown; see {typed('--help')}{parser.nearest(unknown[0])}")
    if not options_.cfg:
        for name in (name for name in ("resolve", "package") if getattr(options_, name)):
            raise UserError(f"option --{name}: of what --cfg prints; give --cfg beside it")
    words = [*options_.overrides, *overrides]
    _refuse_mistyped(words)
    alone = [word for word in words if word.startswith("sweep.")]
    if alone and (not options_.multirun or options_.target != "all"):
        raise UserError(f"override {alone[0]}: of a sweep alone: -m, and no part of it by -t")
    if options_.cfg or options_.info:
        for run in _expanded([word for word in words if word not in alone], options_.multirun):
            print(_look(run, options_), end="")
        return 0
    swept = options_.multirun and options_.target == "all"
    profile = profiles.opened(options_.profile)
    plan = swept_plan(words, options_.cores, profile) if swept else planned(words, options_.multirun)
    for line in planfile.remarks(plan):
        say(line)
    planfile.target(plan, options_.target)
    file = planfile.save(plan, store.RESULTS, say)
    count = sum(len(run.get("sweep", [run])) for run in plan["runs"])
    print(
        f"plan {file}: {count} run{'s' * (count != 1)}, {len(plan['nodes'])} artefacts, "
        f"{len(plan['chunks'])} jobs at most",
        flush=True,
    )
    words = [options_.target, "--cores", str(options_.cores)]
    words += ["--forceall"] * options_.force
    words += ["--keep-going"] * options_.keep_going
    words += _QUIET * options_.quiet
    words += ["--printshellcmds"] * options_.verbose
    words += ["--config", f"plan={file}", "tell=false", *["verify=true"] * options_.verify]
    if options_.dry_run:
        return snakemake(["--dry-run", *words], profile=profile)
    publish.own(plan, store.RESULTS)
    with lock.held(store.RESULTS, say) as descriptor:
        code = _swept(plan, words, descriptor, profile) if swept else snakemake(words, descriptor, profile=profile)
        if code == 0:
            # Snakemake itself would say nothing where nothing was to be done.
            for line in tell(plan, [options_.target], store.RESULTS):
                print(line)
    return code


def _refuse_mistyped(words: Sequence[str]) -> None:
    """Refuse a word that is no override and looks like one of the command, a study or a part of one."""
    for word in (word for word in words if re.fullmatch(r"[A-Za-z][\w.-]*", word)):
        if word in COMMANDS:
            raise UserError(f"{word}: stands before all else: {typed(word)} ...")
        known = [*COMMANDS, *(f"study={name}" for name in planfile.studies())]
        known += [f"-t {name}" for name in ("all", *registry.targets(), "report")]
        if closest(word, known):
            raise UserError(f"{word}: no word of {typed()}; {best_matches(word, known)}; a run takes key=value")


def _swept(plan: Mapping[str, Any], words: Sequence[str], descriptor: int | None, profile: profiles.Profile) -> int:
    """Run the workflow of a sweep, showing how far it is."""
    quiet = _QUIET if sys.stderr.isatty() else []
    verbose = "--printshellcmds" in words
    with shown(plan, store.RESULTS) as made:
        code = snakemake([*words, *([] if verbose else quiet)], descriptor, once=True, profile=profile)
    runs, nodes = made.done
    if code:
        say(f"{runs} of {made.runs} runs, {nodes} of {made.nodes} artefacts are kept; the same command goes on there")
    return code


def planned(words: Sequence[str], multirun: bool = False) -> dict[str, Any]:
    """Return the plan of a command's words, as an earlier process made it where nothing has changed since.

    Raises
    ------
    UserError : a configuration that does not compose or validate, or a sweep without -m.
    """

    def made() -> dict[str, Any]:
        from pipeline.config.planning import make_plan

        return make_plan(_expanded(words, multirun))

    return planfile.remembered(["run", str(multirun), *words], made)


def _with_kind(arguments: Sequence[str]) -> list[str]:
    """Return the arguments with `job` behind a --cfg that is followed by something else than its own words."""
    both = itertools.pairwise([*arguments, ""])
    return ["--cfg=job" if word == "--cfg" and after not in CFG else word for word, after in both]


def _look(run: Sequence[str], choices: argparse.Namespace) -> str:
    from pipeline.commands import looking

    if choices.info:
        return "".join(f"{line}\n" for line in looking.told(run))
    return looking.shown(run, choices.cfg, choices.package)


def swept_plan(words: Sequence[str], cores: str, profile: profiles.Profile = profiles.DEFAULT) -> dict[str, Any]:
    """Return the plan of a sweep: of every run its charges, of all runs one table.

    Arguments
    ---------
    words : Hydra's overrides, some with several values; `sweep.name=NAME`, `sweep.keep=[...]`, `sweep.job_s=S` are
        of the sweep.
    cores : jobs at a time, as Snakemake takes them.
    profile : how Snakemake runs them; its jobs at a time and the work of a job go before the cores.

    Raises
    ------
    UserError : as `planned`.
    """
    count = profile.jobs or (int(cores) if cores.isdecimal() else os.cpu_count() or 1)

    def made() -> dict[str, Any]:
        from pipeline.config.sweep import asked, make_sweep

        own, wanted = asked(words)
        if wanted.job_s is None:
            wanted = replace(wanted, job_s=profile.job_s)
        return make_sweep(own, wanted, count, through)

    return planfile.remembered(["sweep", str(count), str(profile.job_s), *words], made)


def _expanded(words: Sequence[str], multirun: bool) -> list[list[str]]:
    # Composition needs Hydra; a plan that is remembered does without.
    from pipeline.config.compose import expand

    runs = expand(words)
    if len(runs) > 1 and not multirun:
        raise UserError(f"{' '.join(words)}: {len(runs)} runs; a sweep needs -m")
    return runs


def snakemake(
    words: Sequence[str],
    descriptor: int | None = None,
    once: bool = False,
    profile: profiles.Profile = profiles.DEFAULT,
) -> int:
    """Run Snakemake with the project's workflow and profile; return its exit code.

    A signal that ends this command is handed on, and Snakemake waited for: it ends its jobs first.

    Arguments
    ---------
    descriptor : of the lock of the results folder, held for Snakemake too.
    once : Ctrl-C of a terminal reaches Snakemake and its jobs through this command alone, not twice.
    profile : how Snakemake runs the jobs.
    """
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(place("Snakefile"))]
    command += [*profile.words(), *words]
    handed_on = () if descriptor is None else (descriptor,)
    environment = os.environ | ({} if descriptor is None else {lock.HANDED_ON: str(descriptor)})
    group = 0 if once else None
    process = subprocess.Popen(command, env=environment, pass_fds=handed_on, process_group=group)

    def hand_on(number: int, frame: object) -> None:
        if once:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, number)
        else:
            process.send_signal(number)

    before = {number: signal.signal(number, hand_on) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        code = process.wait()
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    return code if code >= 0 else 128 - code


def _parser(listing: bool) -> Parser:
    available = ""
    if listing:
        from pipeline.config.compose import groups, options

        available = "\n".join(f"  {group:<12} {', '.join(options(group))}" for group in groups())
    examples = "\n".join(f"  {typed(words):<66} {meaning}" for words, meaning in EXAMPLES.items())
    parser = Parser(
        prog=typed(),
        description=f"Battery charging studies. Other words: {', '.join(COMMANDS)}; each has --help.\n"
        f"Of the project's own repository alone: {', '.join(OF_THE_REPOSITORY)}.",
        epilog=f"examples:\n{examples}\n\nconfiguration groups (group=option):\n{available}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("overrides", nargs="*", metavar="key=value", help="Hydra overrides of conf/")
    parser.add_argument("-m", "--multirun", action="store_true", help="sweep over comma-separated values")
    parser.add_argument("-c", "--cores", type=cores, default="2", help="cores Snakemake may use (%(default)s)")
    parser.add_argument(
        "--profile",
        default=profiles.DEFAULT.name,
        help=f"how the jobs are run: {', '.join(profiles.names())}, or a folder (%(default)s)",
    )
    parser.add_argument("-n", "--dry-run", action="store_true", help="show what would run")
    parser.add_argument("-F", "--force", action="store_true", help="compute everything again and compare")
    parts = ", ".join(["all", *registry.targets(), "report"])
    parser.add_argument("-v", "--verbose", action="store_true", help="print all that Snakemake says, not a line a job")
    parser.add_argument("--verify", action="store_true", help="read every file made before, not only its size and time")
    parser.add_argument("-t", "--target", default="all", help=f"a part of the study: {parts}")
    parser.add_argument("-k", "--keep-going", action="store_true", help="go on with what a failed job does not touch")
    parser.add_argument("-q", "--quiet", action="store_true", help="print results, warnings and errors alone")
    parser.add_argument(
        "--cfg",
        nargs="?",
        const="job",
        choices=CFG,
        help="print the composed configuration, what is used of Hydra, or both, and stop",
    )
    parser.add_argument("-p", "--package", metavar="KEY", help="with --cfg: only what stands at a key path")
    parser.add_argument("--resolve", action="store_true", help="with --cfg; values are resolved always")
    parser.add_argument("--info", action="store_true", help="print versions, search path and files, and stop")
    return parser


def cores(text: str) -> str:
    """Return a number of cores as Snakemake takes it; with none it would wait for ever."""
    if text != "all" and not (text.isdecimal() and int(text) > 0):
        raise argparse.ArgumentTypeError(f"{text!r} cores; allowed are 1 or more, or all")
    return text
