"""Verdicts: published statements and the artefacts that answer them in; a computed verdict on each out."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from pipeline.kernel.artefacts import Inputs, Output
from pipeline.kernel.experiment import kind_of
from pipeline.published.answer import Choice, answered
from pipeline.published.artefacts import Lookup, Sample
from pipeline.published.ensemble import NAME as ENSEMBLE
from pipeline.published.evaluate import evaluate
from pipeline.published.records import Statement, needs

SECOND = "second_charge"
"""First word of the names of the second battery's charges."""


def answered_by_charges(statements: Mapping[str, Statement]) -> dict[str, Statement]:
    """Return the statements that our charges answer, and nothing else of a run."""
    return {
        name: stated
        for name, stated in statements.items()
        if stated.basis == "model" and {kind_of(artefact) for artefact in needs(stated)} == {"charge"}
    }


def of_second(artefact: str) -> str:
    """Return the name of the second battery's charge that stands beside one of the first."""
    return artefact.replace("charge/", f"{SECOND}/", 1)


def in_place_of_the_first(inputs: Iterable[str]) -> dict[str, str]:
    """Return the names that the second battery's charges take from the first's -> their own."""
    return {f"charge/{name.partition('/')[2]}": name for name in inputs if kind_of(name) == SECOND}


def samples(inputs: Inputs, nominal: Lookup) -> list[Sample]:
    """Return the points of all ensembles, those that are the same point of several as one; none without an ensemble."""
    found: dict[tuple[str, int], dict[str, float | None]] = {}
    for name in inputs.of_kind(ENSEMBLE):
        data = inputs.table(name, "ensemble")
        columns = (data[column].tolist() for column in ("of", "point", "operand", "value", "possible"))
        for of, point, operand, value, possible in zip(*columns, strict=True):
            found.setdefault((of, point), {})[operand] = value if possible else None
    return [Sample(nominal, numbers, of) for (of, _), numbers in sorted(found.items())]


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Judge every statement, and those that charges answer on the second battery's charges too."""
    statements = {
        data["name"]: Statement.model_validate({key: value for key, value in data.items() if key != "name"})
        for data in settings["statements"]
    }
    calibrated, called = set(settings["calibrated"]), {one["name"]: one["words"] for one in settings["called"]}
    nominal = Lookup(inputs)
    points = samples(inputs, nominal)
    output.write("verdicts", evaluate(statements, nominal, calibrated, points, called))
    choices = {
        data["name"]: Choice.model_validate({key: value for key, value in data.items() if key != "name"})
        for data in settings["answer"]
    }
    output.write("answer", answered(choices, nominal, points))
    if settings["second_calibrated"] is not None:
        second = Lookup(inputs.renamed(in_place_of_the_first(inputs)))
        calibrated = set(settings["second_calibrated"])
        output.write("second", evaluate(answered_by_charges(statements), second, calibrated, called=called))
