"""The commands and the code of the README and of docs/ are those that work."""

from __future__ import annotations

import importlib.util
import re
import shlex
from pathlib import Path
from typing import Any

import matplotlib
import pytest
import yaml

from pipeline.commands import COMMANDS
from pipeline.config.compose import compose_tree, expand
from pipeline.config.study import study_from
from pipeline.kernel import registry

ROOT = Path(__file__).resolve().parents[1]
# What docs/adding.md has is run in a copy of the project, by tests/workflow/test_readme.py.
PAGES = sorted({ROOT / "README.md", *(ROOT / "docs").glob("*.md")} - {ROOT / "docs" / "adding.md"})
TEXTS = {page.name: page.read_text(encoding="utf-8") for page in PAGES}
CODE = [
    (name, code) for name, text in TEXTS.items() for code in re.findall(r"^```python\n(.*?)^```$", text, re.M | re.S)
]
LINES = [
    line
    for text in TEXTS.values()
    for block in re.findall(r"^```\n(.*?)^```$", text, re.M | re.S)
    for line in block.replace("\\\n", " ").splitlines()
]
TYPED = sorted({line.split("#")[0].strip() for line in LINES if line.startswith(("python -m pipeline", "snakemake"))})
MADE_UP = ("NAME", "FILE", "OTHER", "FOLDER")


@pytest.mark.parametrize(("page", "code"), CODE)
def test_code_runs(page: str, code: str) -> None:
    matplotlib.use("Agg")
    names: dict[str, Any] = {}
    exec(compile(code, page, "exec"), names)


def _words(line: str) -> list[str]:
    if line.startswith("snakemake"):
        given = re.search(r'overrides="([^"]*)"', line)
        return shlex.split(given[1]) if given else []
    return [word for word in shlex.split(line)[3:] if not word.startswith("-")]


@pytest.mark.parametrize("line", TYPED)
def test_a_command_is_understood(line: str) -> None:
    words = _words(line)
    if words and (words[0] in COMMANDS or any(name in line for name in MADE_UP)):
        assert words[0] in COMMANDS or any("=" in word for word in words)
        return
    for run in expand(words):
        study_from(compose_tree(run))


@pytest.mark.parametrize("line", [line for line in TYPED if line.startswith("snakemake")])
def test_a_target_is_there(line: str) -> None:
    words = shlex.split(line)[1:]
    target = next(word for word in words if not word.startswith("-") and not word.isdecimal())
    studies = {path.stem for path in (ROOT / "conf" / "study").glob("*.yaml")}
    assert target in {"all", *registry.targets(), *studies} or target.split("/")[0] in ("results", "reports")


@pytest.fixture(scope="module")
def generate() -> Any:
    """Return the script that makes pages of the documentation from the project itself."""
    spec = importlib.util.spec_from_file_location("generate", ROOT / "docs" / "generate.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_gallery_has_every_figure_with_the_yaml_that_draws_it(generate: Any, tmp_path: Path) -> None:
    """A picture where a report was made here, its card and caption alone where not."""
    drawn = tmp_path / "reports" / "nicd_grnn" / "default" / "figures" / "trade_off.svg"
    drawn.parent.mkdir(parents=True)
    drawn.write_text("<svg/>", encoding="utf-8")
    page = generate.gallery(tmp_path / "made", tmp_path / "reports")
    cards = {}
    for block in re.findall(r"^```yaml title=.*?$\n(.*?)^```$", page, re.M | re.S):
        cards |= yaml.safe_load(block)
    for file in sorted((ROOT / "conf" / "report").glob("*.yaml")):
        for name, card in yaml.safe_load(file.read_text(encoding="utf-8")).items():
            assert cards[name].keys() == card.keys()
            assert f"#{file.stem}-{name} " in page
    assert (tmp_path / "made" / "pictures" / "nicd_grnn" / "trade_off.svg").is_file()
    assert re.findall(r"\]\((pictures/[^)]*)\)", page) == ["pictures/nicd_grnn/trade_off.svg"]
    assert {name for name in registry.figures() if f"#draws-{name} " in page} == set(registry.figures())


def test_the_reference_has_key_unit_range_default_and_source(generate: Any) -> None:
    studies = {name: generate._study(name) for name in generate.STUDIES}
    rows = [
        [cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
        for line in generate.keys(studies).splitlines()
        if line.startswith("| `")
    ]
    found = {row[0].strip("`"): row[1:] for row in rows}
    assert found["battery.capacity_ah"][1:4] == ["Ah", r"\> 0", ""]
    assert found["battery.capacity_ah"][4].startswith("published (lfp")
    assert found["charge.sample_interval_s"][1] == "s"
    assert found["ensemble.points"][2:4] == ["≥ 0, ≤ 8192", "128"]
    assert not [row for row in rows if len(row) not in (5, 6)]
    shown = generate.parameters(studies)
    for root in studies.values():
        assert all(f"| `{path}` |" in shown for path in root.sources)


def test_the_words_of_a_notebook_have_their_docstrings(generate: Any) -> None:
    page = generate.notebook()
    for word in ("charge", "compare", "sweep", "battery", "mode"):
        assert f"## cp.{word} " in page
    assert "- `supply_power_w`: power that the supply gives" in page
    assert page.count("```pycon") >= 3
    assert "----" not in page


def test_the_pages_that_are_made_are_those_of_the_contents(generate: Any) -> None:
    source = (ROOT / "docs" / "generate.py").read_text(encoding="utf-8")
    listed = re.findall(r"generated/(\w+\.md)", (ROOT / "mkdocs.yml").read_text(encoding="utf-8"))
    assert listed
    assert sorted(listed) == sorted(re.findall(r'^        "(\w+\.md)":', source, re.M))
