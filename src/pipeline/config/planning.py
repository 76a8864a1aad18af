"""From overrides to a plan: every run composed, validated, and handed to the kernel."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any

from pipeline.config.compose import compose_tree
from pipeline.config.effort import check_effort
from pipeline.config.naming import run_name
from pipeline.config.study import study_from
from pipeline.kernel import digest, plan, publish, registry, store
from pipeline.kernel.draft import drafts, plain


def make_plan(overrides: Iterable[Sequence[str]], asked: Collection[str] | None = None) -> dict[str, Any]:
    """Compose one run for each list of overrides and join their nodes into a plan.

    A study run without overrides brings the runs that it has on request; and takes over, under its own name, what one
    of them has computed already: its page then shows that answer for as long as the key is the same.

    Arguments
    ---------
    asked : words of the command line: targets whose runs on request are planned, all of them without; and files of
        the readable views.

    Raises
    ------
    UserError : a configuration that does not compose or validate, or two runs of one name.
    """
    runs = [run for words in overrides for run in _runs(words, asked)]
    return plan.make(runs, asked or ())


def run_of(words: Sequence[str]) -> plan.Run:
    """Compose one run."""
    composed = compose_tree(words)
    study = study_from(composed)
    made = drafts(study)
    check_effort(composed, study, made)
    kinds = {node.kind for node in made}
    return plan.Run(
        study.study.name,
        run_name(study.overrides),
        study.overrides,
        study.seed,
        study.configuration,
        plain(study.sources),
        tuple(made),
        remarks=tuple(line for one in registry.experiments().values() for line in one.remarks(study, kinds)),
    )


def _runs(words: Sequence[str], asked: Collection[str] | None) -> Iterator[plan.Run]:
    run = run_of(words)
    requests = run.configuration["study"].get("on_request", {}) if not run.overrides else {}
    wanted = []
    for target, more in requests.items():
        named = asked is None or target in asked or any(f"/{run.study}/{run_name(more)}/" in word for word in asked)
        once_made = digest.is_there(store.RESULTS / run.study / run_name(more) / publish.MANIFEST)
        if named or once_made:
            request = run_of([*words, *more])
            wanted += [replace(request, target=target)] * named
            if once_made and _all_made(request, run):
                run = replace(request, name=run.name, overrides=run.overrides)
    yield run
    yield from wanted


def _all_made(request: plan.Run, run: plan.Run) -> bool:
    """Tell whether the store holds that with which a run on request begins to be another; the rest is made of it."""
    other = {node.name for node in request.nodes if request.keys[node.name] not in run.keys.values()}
    first = [node for node in request.nodes if node.name in other and not other & set(node.inputs.values())]
    folders = [store.artefact(store.RESULTS, node.step, request.keys[node.name]) for node in first]
    return bool(folders) and all(digest.is_there(folder / store.CONTENTS) for folder in folders)
