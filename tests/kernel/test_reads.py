"""What a step reads is said once: its settings come through it, and nothing enters them beside it."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import pytest

from pipeline.config.compose import compose_tree, options
from pipeline.config.study import study_from
from pipeline.kernel import registry
from pipeline.kernel.draft import drafted, drafts
from pipeline.kernel.experiment import EVERYTHING, Draft, Node
from pipeline.kernel.scope import UndeclaredRead
from tests.experiments.own_battery.making import small_file

CASES = [(step.name, read) for step in registry.steps().values() for read in step.reads]


@cache
def _study(name: str) -> Any:
    file = [f"measured.file={small_file()}"] if name == "own_battery" else []
    return study_from(compose_tree([f"study={name}", *file]))


@cache
def _made(name: str) -> tuple[tuple[Node, ...], tuple[Draft, ...]]:
    """Return the nodes of a study as its experiments declare them, and as they are drafted."""
    study = _study(name)
    experiments = registry.experiments().values()
    makers = [one for one in experiments if one.alone(study)] or experiments
    nodes = [node for one in makers for node in one.nodes(study)]
    made = drafts(study)
    kept = {node.name for node in made}
    behind = [node for node in made if node.step not in ("verdicts", "figures", "page")]
    closing = [node for one in experiments if one.closing is not None for node in one.closing(study, behind)]
    return tuple(node for node in [*nodes, *closing] if node.name in kept), tuple(made)


def _nodes_of(step: str) -> list[tuple[str, Node]]:
    return [(study, node) for study in options("study") for node in _made(study)[0] if node.step.name == step]


@pytest.mark.parametrize(("step", "read"), CASES, ids=[f"{step}-{read}" for step, read in CASES])
def test_without_one_of_its_reads_a_step_is_not_planned(step: str, read: str) -> None:
    nodes = _nodes_of(step)
    assert nodes, f"no study has the step {step}"
    refused = 0
    for study, node in nodes:
        less = replace(node.step, reads=tuple(one for one in node.step.reads if one != read))
        try:
            drafted(replace(node, step=less), _study(study))
        except UndeclaredRead:
            refused += 1
    assert refused, f"{step} does without {read}: it need not declare it"


@pytest.mark.parametrize("study", options("study"))
def test_edges_are_those_that_steps_declare_to_take(study: str) -> None:
    _, made = _made(study)
    step_of = {node.name: node.step for node in made}
    for node in made:
        for maker in node.inputs.values():
            assert step_of[maker] in registry.takes(node.step), f"{node.name} takes {maker}"


def test_every_step_of_the_reporting_takes_from_every_other() -> None:
    assert EVERYTHING in registry.steps()["page"].takes
    assert {"charge", "verdicts", "figures"} <= set(registry.takes("page"))


def test_steps_come_after_those_they_take_from() -> None:
    order = list(registry.steps())
    for name in order:
        assert all(order.index(other) < order.index(name) for other in registry.takes(name))
