"""A digest changes with what counts and with nothing else."""

from __future__ import annotations

import importlib
import math
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline import digest

JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    max_leaves=12,
)


@given(st.dictionaries(st.text(), JSON))
def test_order_of_keys_does_not_count(value: dict[str, object]) -> None:
    assert digest.canonical(value) == digest.canonical(dict(reversed(list(value.items()))))


def test_not_a_number_is_refused() -> None:
    with pytest.raises(ValueError, match="JSON"):
        digest.canonical({"a": math.nan})


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[Path, ModuleType]]:
    """A package `toy` with a chain of imports, and the digest module looking at it."""
    root = tmp_path / "toy"
    root.mkdir()
    (root / "__init__.py").write_text("")
    (root / "step.py").write_text("def run():\n    from toy.helper import double\n    return double(1)\n")
    (root / "helper.py").write_text(
        '"""Helps."""\nfrom toy import deep\n\ndef double(x):\n    """Doc."""\n    return 2 * x + deep.ZERO\n'
    )
    (root / "deep.py").write_text("ZERO = 0\n")
    (root / "other.py").write_text("ONE = 1\n")
    monkeypatch.setattr(digest, "PACKAGE", root)
    yield root, digest
    for cached in (digest._tree, digest._imports, digest._tree_digest):
        cached.cache_clear()


def _digest() -> str:
    for cached in (digest._tree, digest._imports, digest._tree_digest):
        cached.cache_clear()
    return digest.of_code("toy.step")


@pytest.mark.parametrize(
    ("file", "text", "changes"),
    [
        (
            "helper.py",
            '"""Other words."""\nfrom toy import deep\n# why\n\n\ndef double(x):\n    """New."""\n    return 2*x + deep.ZERO\n',  # noqa: E501
            False,
        ),
        ("helper.py", "from toy import deep\n\ndef double(x):\n    return 3 * x + deep.ZERO\n", True),
        ("deep.py", "ZERO = 0.0\n", True),
        ("other.py", "ONE = 2\n", False),
        ("__init__.py", "VERSION = 1\n", True),
    ],
    ids=["comments and docstrings", "helper inside a function", "two imports away", "not imported", "package"],
)
def test_what_changes_the_digest_of_code(package: tuple[Path, ModuleType], file: str, text: str, changes: bool) -> None:
    before = _digest()
    (package[0] / file).write_text(text)
    assert (_digest() != before) == changes


def test_relative_imports_are_refused(package: tuple[Path, ModuleType]) -> None:
    (package[0] / "deep.py").write_text("from . import other\n")
    with pytest.raises(ImportError, match="relative"):
        _digest()


def test_no_module_of_ours_is_imported_behind_the_digests_back() -> None:
    """What a step really imports is inside the closure that its digest covers."""
    before = set(sys.modules)
    importlib.import_module("pipeline.steps.supply")
    loaded = {name for name in set(sys.modules) - before if name.split(".")[0] == "pipeline"}
    assert loaded <= digest._closure("pipeline.steps.supply")
