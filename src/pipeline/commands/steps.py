"""`python -m pipeline steps`: every step with what it reads, takes and makes, and its rule, from panel to report."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from pipeline.commands import Parser, as_typed, typed
from pipeline.kernel import registry
from pipeline.kernel.experiment import EVERYTHING, FOUND, Step

_WORDS = {FOUND: "found values", EVERYTHING: "all that it shows"}


def main(arguments: Sequence[str]) -> int:
    """Print the steps in the order in which they can run; return 0."""
    parser = Parser(prog=typed("steps"), description=as_typed(__doc__ or ""))
    parser.add_argument("step", nargs="?", choices=list(registry.steps()), metavar="STEP", help="this step alone")
    parser.add_argument("-s", "--short", action="store_true", help="a line a step: what it takes, and its rule")
    options = parser.parse_args(arguments)
    chosen = options.step
    if options.short:
        print("\n".join(chain()))
        return 0
    for name, step in registry.steps().items():
        if chosen in (None, name):
            print("\n".join(lines(step)), end="\n\n")
    return 0


def chain() -> Iterator[str]:
    """Yield a line for each step: its name, its rule, the steps it takes from."""
    yield f"{'step':<20}{'rule':<34}takes from"
    for name, step in registry.steps().items():
        yield f"{name:<20}{step.rule:<34}{', '.join(_WORDS.get(one, one) for one in step.takes)}".rstrip()


def lines(step: Step) -> Iterator[str]:
    """Yield what a step declares, a line for each part of it that there is."""
    yield f"{step.name}  ({registry.owners()[step.name]})"
    parts = {
        "reads": ", ".join(step.reads),
        "takes": ", ".join(_WORDS.get(name, name) for name in step.takes),
        "makes": ", ".join([*step.tables, *(["found.json"] if step.finds else [])]),
        "files": ", ".join(step.files),
        "rule": step.rule,
        "target": step.target or "",
        "runs": registry.module(step.name),
    }
    for word, told in parts.items():
        if told:
            yield f"  {word:<7}{told}"
