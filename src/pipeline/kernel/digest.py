"""Digests that decide whether work is still valid: of configuration, of code, of files."""

from __future__ import annotations

import ast
import hashlib
import json
from functools import cache
from pathlib import Path
from typing import Any

PACKAGE = Path(__file__).resolve().parent.parent
_CLONE = PACKAGE.parent.parent
INSTALLED = (PACKAGE / "shipped").is_dir()
"""Whether the package was installed from a wheel, and is not a clone's."""
SHIPPED = PACKAGE / "shipped" if INSTALLED else _CLONE
"""Where conf/, workflow/, profiles/, Snakefile and lock file lie that come with the package."""


def _project() -> Path:
    """Return the folder of the project: a clone, or one that `init` made and that is worked in."""
    here = Path.cwd()
    made = (here / "conf").is_dir() and (here / "Snakefile").is_file() and not (here / "src" / "pipeline").is_dir()
    return here if INSTALLED or made else _CLONE


PROJECT = _project()


def place(name: str) -> Path:
    """Return a file or folder of the project, or the one that is shipped where the project has none of its own."""
    return PROJECT / name if (PROJECT / name).exists() else SHIPPED / name


def confs() -> tuple[Path, ...]:
    """Return the folders of configuration, the project's own first: what is in both is taken from there."""
    return tuple(dict.fromkeys(one / "conf" for one in (PROJECT, SHIPPED) if (one / "conf").is_dir()))


LOCK_FILE = place("requirements.lock")


def canonical(value: Any, ordered: bool = False) -> str:
    """Return JSON without spaces, one text for one value; NaN and infinity are refused.

    Arguments
    ---------
    ordered : keep the order of keys, for mappings in which it has a meaning (the phases of a mode); else sorted.
    """
    return json.dumps(value, sort_keys=not ordered, separators=(",", ":"), ensure_ascii=False, allow_nan=False)


def of_value(value: Any, ordered: bool = False) -> str:
    """Return the sha256 of a value's canonical JSON."""
    return hashlib.sha256(canonical(value, ordered).encode()).hexdigest()


def of_file(path: Path) -> str:
    """Return the sha256 of a file's content."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def of_code(module: str) -> str:
    """Return the digest of a first-party module and of all first-party modules it imports.

    Arguments
    ---------
    module : dotted name, e.g. `pipeline.steps.charge`.

    The digest is over syntax trees without docstrings: a comment, a blank line or a docstring changes nothing, a
    changed helper changes every module that imports it, at any depth and also from inside a function.
    """
    closure = sorted(_closure(module))
    return of_value([(name, _tree_digest(name)) for name in closure])


@cache
def of_lock() -> str:
    """Return the digest of the runtime lock file, comments and blank lines left out."""
    lines = (line.split("#")[0].strip() for line in LOCK_FILE.read_text().splitlines())
    return of_value([line for line in lines if line])


def _path(module: str) -> Path | None:
    base = PACKAGE.parent / Path(*module.split("."))
    for candidate in (base.with_suffix(".py"), base / "__init__.py"):
        if candidate.is_file():
            return candidate
    return None


def _closure(module: str) -> set[str]:
    found: set[str] = set()
    waiting = [module, *_parents(module)]
    while waiting:
        name = waiting.pop()
        if name in found:
            continue
        found.add(name)
        waiting.extend(_imports(name))
    return found


@cache
def _tree(module: str) -> ast.Module:
    """Return a module's syntax tree without docstrings and without what only type checkers read."""
    path = _path(module)
    if path is None:
        raise ModuleNotFoundError(f"no first-party module {module}")
    tree = ast.parse(path.read_text(encoding="utf-8"), filename=str(path))
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            node.body = [statement for statement in node.body if not _is_text(statement)] or [ast.Pass()]
    tree.body = [statement for statement in tree.body if not _for_type_checkers(statement)]
    return tree


@cache
def _imports(module: str) -> frozenset[str]:
    names: set[str] = set()
    for node in ast.walk(_tree(module)):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            if node.level:
                raise ImportError(f"{module}: relative imports are not followed; write the full name")
            origin = node.module or ""
            names.add(origin)
            names.update(f"{origin}.{alias.name}" for alias in node.names)
    root = PACKAGE.name
    inside = {name for name in names if name == root or name.startswith(root + ".")}
    parents = {parent for name in inside for parent in _parents(name)}
    return frozenset(name for name in inside | parents if _path(name) is not None)


def _parents(module: str) -> list[str]:
    """Return the packages a module lies in whose `__init__` runs when it is imported; a plain folder has none."""
    parents = (".".join(module.split(".")[:depth]) for depth in range(1, module.count(".") + 1))
    return [parent for parent in parents if _path(parent) is not None]


@cache
def _tree_digest(module: str) -> str:
    return hashlib.sha256(ast.dump(_tree(module)).encode()).hexdigest()


def _for_type_checkers(statement: ast.stmt) -> bool:
    """Tell whether a statement is `if TYPE_CHECKING:` without an `else`, which never runs."""
    named = isinstance(statement, ast.If) and isinstance(statement.test, ast.Name)
    return named and statement.test.id == "TYPE_CHECKING" and not statement.orelse  # type: ignore[attr-defined]


def _is_text(statement: ast.stmt) -> bool:
    return (
        isinstance(statement, ast.Expr)
        and isinstance(statement.value, ast.Constant)
        and isinstance(statement.value.value, str)
    )
