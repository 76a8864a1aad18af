"""The digest of code: of a module and all that it imports, so that a changed helper makes anew what it made."""

from __future__ import annotations

import ast
import hashlib
import sys
from functools import cache
from pathlib import Path
from typing import NamedTuple

from pipeline.kernel import kept, places
from pipeline.kernel.digest import of_value

_KEPT_FILE = "code.json"


class Facts(NamedTuple):
    """What counts of a module: the digest of its syntax tree, and the names it imports of its own package."""

    digest: str
    names: tuple[str, ...]


def of_code(module: str) -> str:
    """Return the digest of a first-party module and of all first-party modules it imports.

    Arguments
    ---------
    module : dotted name, e.g. `pipeline.charge.simulate`.

    The digest is over syntax trees without docstrings: a comment, a blank line or a docstring changes nothing, a
    changed helper changes every module that imports it, at any depth and also from inside a function.
    """
    found = of_value([(name, facts(name).digest) for name in sorted(closure(module))])
    _keep()
    return found


@cache
def closure(module: str) -> frozenset[str]:
    """Return the names of a first-party module and of all first-party modules it imports, their packages too."""
    found: set[str] = set()
    waiting = [module, *_parents(module)]
    while waiting:
        name = waiting.pop()
        if name not in found:
            found.add(name)
            waiting.extend(_imports(name))
    return frozenset(found)


@cache
def facts(module: str) -> Facts:
    """Return what counts of a module, kept from an earlier process where its text is the same.

    Raises
    ------
    ModuleNotFoundError : no first-party module of that name.
    ImportError : it imports relatively, which is not followed.
    """
    path = _path(module)
    if path is None:
        raise ModuleNotFoundError(f"no first-party module {module}")
    text = path.read_bytes()
    identity = hashlib.sha256(text + _reader()).hexdigest()
    found = _kept().get(module)
    if found is None or found[0] != identity:
        tree = _tree(text, path)
        made = Facts(hashlib.sha256(ast.dump(tree).encode()).hexdigest(), _names(tree, module))
        found = _kept()[module] = (identity, made)
        _NEW.add(module)
    return found[1]


_NEW: set[str] = set()


@cache
def _kept() -> dict[str, tuple[str, Facts]]:
    """Return what earlier processes found."""
    listed = kept.read(_KEPT_FILE) or {}
    return {name: (sha, Facts(digest, tuple(names))) for name, (sha, digest, names) in listed.items()}


def _keep() -> None:
    if _NEW:
        kept.write(_KEPT_FILE, {name: (sha, *made) for name, (sha, made) in sorted(_kept().items())})
        _NEW.clear()


@cache
def _reader() -> bytes:
    """Return what the facts depend on beside a module's text: this module and the parser."""
    return Path(__file__).read_bytes() + sys.version.encode()


@cache
def _path(module: str) -> Path | None:
    base = places.PACKAGE.parent / Path(*module.split("."))
    for candidate in (base.with_suffix(".py"), base / "__init__.py"):
        if candidate.is_file():
            return candidate
    return None


@cache
def _imports(module: str) -> frozenset[str]:
    names = facts(module).names
    parents = {parent for name in names for parent in _parents(name)}
    return frozenset(name for name in parents.union(names) if _path(name) is not None)


def _parents(module: str) -> list[str]:
    """Return the packages a module lies in whose `__init__` runs when it is imported; a plain folder has none."""
    parents = (".".join(module.split(".")[:depth]) for depth in range(1, module.count(".") + 1))
    return [parent for parent in parents if _path(parent) is not None]


def _tree(text: bytes, path: Path) -> ast.Module:
    """Return a module's syntax tree without docstrings and without what only type checkers read."""
    tree = ast.parse(text, filename=str(path))
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            node.body = [statement for statement in node.body if not _is_text(statement)] or [ast.Pass()]
    tree.body = [statement for statement in tree.body if not _for_type_checkers(statement)]
    return tree


def _names(tree: ast.Module, module: str) -> tuple[str, ...]:
    names: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            if node.level:
                raise ImportError(f"{module}: relative imports are not followed; write the full name")
            origin = node.module or ""
            names.add(origin)
            names.update(f"{origin}.{alias.name}" for alias in node.names)
    root = places.PACKAGE.name
    return tuple(sorted(name for name in names if name == root or name.startswith(root + ".")))


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
