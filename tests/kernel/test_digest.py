"""A digest changes with what counts and with nothing else."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.kernel import code, digest, places, registry
from pipeline.kernel.code import of_code

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
    monkeypatch.setattr(places, "PACKAGE", root)
    monkeypatch.setenv("CHARGE_PIPELINE_CACHE", str(tmp_path / "cache"))
    yield root, digest
    _forget()


def _forget() -> None:
    """Be another process: what this one holds is gone, what it wrote is there."""
    for cached in (code.closure, code.facts, code._kept, code._path, code._imports):
        cached.cache_clear()


def _digest() -> str:
    _forget()
    return of_code("toy.step")


def test_a_folder_without_init_counts_for_nothing(package: tuple[Path, ModuleType]) -> None:
    root, _ = package
    (root / "figures").mkdir()
    (root / "figures" / "curve.py").write_text("from toy.helper import double\n")
    (root / "figures" / "more.py").write_text("from toy.figures import curve\n")
    assert code.closure("toy.figures.more") == {
        "toy",
        "toy.figures.more",
        "toy.figures.curve",
        "toy.helper",
        "toy.deep",
    }
    assert len(of_code("toy.figures.more")) == 64


def test_every_figure_is_found_and_has_a_digest() -> None:
    figures = registry.figures()
    assert {"energy", "charger", "circuit"} <= set(figures)
    assert all(len(of_code(module)) == 64 for module in figures.values())


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


@pytest.mark.parametrize("step", ["supply", "charge", "verdicts", "figures", "page"])
def test_no_module_of_ours_is_imported_behind_the_digests_back(step: str) -> None:
    """What a step really imports is inside the closure that its digest covers."""
    module = registry.module(step)
    told = f"import sys, {module}; print(*(name for name in sys.modules if name.split('.')[0] == 'pipeline'))"
    done = subprocess.run([sys.executable, "-c", told], capture_output=True, text=True, check=True)
    assert set(done.stdout.split()) <= code.closure(module)


def test_what_only_type_checkers_read_does_not_count(package: tuple[Path, ModuleType]) -> None:
    before = _digest()
    helper = package[0] / "helper.py"
    seen = "from typing import TYPE_CHECKING\n\nif TYPE_CHECKING:\n    from toy import other\n"
    helper.write_text(helper.read_text() + seen)
    (package[0] / "other.py").write_text("ONE = 3\n")
    first = _digest()
    (package[0] / "other.py").write_text("ONE = 4\n")
    assert _digest() == first != before


def test_another_process_parses_nothing_again(
    package: tuple[Path, ModuleType], monkeypatch: pytest.MonkeyPatch
) -> None:
    first = _digest()
    monkeypatch.setattr(code, "_tree", lambda text, path: pytest.fail(f"parsed {path}"))
    assert _digest() == first


@pytest.mark.parametrize("harm", [lambda text: text.replace(b'"', b"'", 1), lambda text: text[:-40], lambda text: b""])
def test_damaged_facts_count_for_nothing(package: tuple[Path, ModuleType], harm: Callable[[bytes], bytes]) -> None:
    first = _digest()
    kept = places.cache_root() / "code.json"
    kept.write_bytes(harm(kept.read_bytes()))
    assert _digest() == first


def test_facts_that_are_another_texts_count_for_nothing(package: tuple[Path, ModuleType]) -> None:
    """An edit that leaves time and size as they were is seen: a text is known by its content."""
    first = _digest()
    deep = package[0] / "deep.py"
    status = deep.stat()
    deep.write_text("ZERO = 9\n")
    os.utime(deep, ns=(status.st_atime_ns, status.st_mtime_ns))
    assert _digest() != first


def test_a_cache_that_cannot_be_written_costs_time_alone(
    package: tuple[Path, ModuleType], monkeypatch: pytest.MonkeyPatch
) -> None:
    first = _digest()
    monkeypatch.setenv("CHARGE_PIPELINE_CACHE", str(package[0] / "step.py" / "cache"))
    assert _digest() == first
