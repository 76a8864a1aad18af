"""The rooms of the house: arrows point down, nothing runs in a circle. Read from the imports, nothing is run.

Imports for type checkers count too: they tie modules together for whoever reads them.
"""

from __future__ import annotations

import ast
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

from pipeline.kernel.places import PACKAGE

# What stands under every room.
FOUNDATION = {"errors", "jit", "own_files", "quantity", "record"}
PHYSICS = {
    *("bus", "cell", "charge", "converter", "day", "files", "grnn", "objective", "panel", "search", "taguchi"),
    *("tracker", "weather"),
}
SHARED = {"config", "published", "report"}
# Room -> the rooms that it may import from, beside itself.
ALLOWED = {
    "kernel": set(),
    **{name: {"kernel", *FOUNDATION} for name in FOUNDATION},
    **dict.fromkeys(PHYSICS, PHYSICS | FOUNDATION),
    **{name: SHARED | PHYSICS | FOUNDATION | {"kernel"} for name in SHARED},
    "experiments": SHARED | PHYSICS | FOUNDATION | {"kernel"},
    "commands": SHARED | PHYSICS | FOUNDATION | {"kernel", "experiments", "notebook"},
    "notebook": SHARED | PHYSICS | FOUNDATION | {"kernel", "experiments"},
    "__main__": {"commands", "errors", "kernel"},
}


def _modules() -> dict[str, Path]:
    found = {}
    for path in PACKAGE.rglob("*.py"):
        name = ".".join(["pipeline", *path.relative_to(PACKAGE).with_suffix("").parts])
        found[name.removesuffix(".__init__")] = path
    return found


MODULES = _modules()


def _imports(name: str) -> set[str]:
    found: set[str] = set()
    for node in ast.walk(ast.parse(MODULES[name].read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            names = {f"{node.module}.{alias.name}" for alias in node.names}
            found |= {one if one in MODULES else str(node.module) for one in names}
    return {one for one in found if one in MODULES and one != name}


ARROWS = {name: _imports(name) for name in MODULES}


def room(name: str) -> str:
    """Return the room of a module: the part of its name behind that of the package."""
    return [*name.split("."), ""][1]


def test_every_room_is_known() -> None:
    assert {room(name) for name in MODULES} - {""} == set(ALLOWED)


@pytest.mark.parametrize("own", sorted(ALLOWED))
def test_arrows_point_down(own: str) -> None:
    wrong = [
        f"{name} -> {other}"
        for name, others in ARROWS.items()
        for other in others
        if room(name) == own and room(other) not in {"", own, *ALLOWED[own]}
    ]
    assert not wrong


def test_no_experiment_imports_another() -> None:
    inside = [name for name in MODULES if name.count(".") > 2 and room(name) == "experiments"]
    wrong = [
        f"{name} -> {other}"
        for name in inside
        for other in ARROWS[name]
        if room(other) == "experiments" and other.count(".") > 1 and other.split(".")[2] != name.split(".")[2]
    ]
    assert not wrong


def test_nothing_runs_in_a_circle() -> None:
    packages = {name for name, path in MODULES.items() if path.name == "__init__.py"}
    try:
        TopologicalSorter({name: others - packages for name, others in ARROWS.items()}).prepare()
    except CycleError as error:
        pytest.fail(" -> ".join(error.args[1]))


def test_modules_are_neither_crumbs_nor_books() -> None:
    lengths = {name: len(path.read_text(encoding="utf-8").splitlines()) for name, path in MODULES.items()}
    assert max(lengths.values()) <= 400
