"""Pages of the documentation that are made from the project itself: gallery, reference, notebook.

`make docs` runs it before the pages are built: `python docs/generate.py [FOLDER]`, by default docs/generated. Pictures
are those of the reports that were made here; a figure without one shows its card and caption alone.
"""

from __future__ import annotations

import inspect
import re
import shutil
import sys
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import yaml

ROOT = Path(__file__).resolve().parents[1]
STUDIES = sorted(file.stem for file in (ROOT / "conf" / "published").glob("*.yaml"))
_UNIT = re.compile(r"\s*\[([^\[\]]+)\]$")
_NOTE = "<!-- Made by docs/generate.py: whatever is written here is lost. -->\n\n"
# Of a page with wide tables.
_WIDE = "---\nhide: [navigation]\n---\n\n"
# Of the root: what a study is told in has its own pages.
_APART = (
    "published",
    "figures",
    "answer",
    "captions",
    "called",
    "not_drawn",
    "sources",
    "defaults",
    "run",
    "overrides",
)
# What is looked for first.
_FIRST = ("battery", "modes", "comparisons", "charge", "panel", "weather", "converter", "load", "day", "search")
Row = tuple[str, str, str, str, str]
Rows = Iterable[tuple[Any, ...]]


def main(target: Path, reports: Path = ROOT / "reports") -> None:
    """Write all pages below a folder, which is emptied first."""
    shutil.rmtree(target, ignore_errors=True)
    target.mkdir(parents=True)
    studies = {name: _study(name) for name in STUDIES}
    pages = {
        "gallery.md": gallery(target, reports),
        "keys.md": keys(studies),
        "parameters.md": parameters(studies),
        "notebook_reference.md": notebook(),
    }
    for name, text in pages.items():
        head = _WIDE if name in ("keys.md", "parameters.md") else ""
        (target / name).write_text(head + _NOTE + text.rstrip() + "\n", encoding="utf-8")


def gallery(target: Path, reports: Path) -> str:
    """Return every figure of the configuration with the YAML that draws it; pictures are copied where there are any."""
    told = ["# Gallery", "Every figure that a study draws, with the card in `conf/report` that draws it. Options not"]
    told[-1] += " given have the defaults below.\n"
    kinds: dict[str, list[str]] = defaultdict(list)
    for file in sorted((ROOT / "conf" / "report").glob("*.yaml")):
        cards = _cards(file)
        told.append(f"## {_title(file.stem)}\n")
        for name, (card, written) in cards.items():
            kinds[card["draw"]].append(f"[{_text(card['title'])}](#{file.stem}-{name})")
            paper = f"{card['paper']}: " if card.get("paper") else ""
            told.append(f"### {paper}{_text(card['title'])} {{: #{file.stem}-{name} }}\n")
            picture = reports / file.stem / "default" / "figures" / f"{name}.svg"
            if picture.is_file():
                own = target / "pictures" / file.stem
                own.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(picture, own / picture.name)
                told.append(f"![{_text(card['title'])}](pictures/{file.stem}/{picture.name}){{ loading=lazy }}\n")
            told.append(f"{_text(card['caption'])}\n")
            told.append(f'```yaml title="conf/report/{file.name}"\n{written}\n```\n')
    return "\n".join([*told, *_kinds(kinds)])


def _cards(file: Path) -> dict[str, tuple[dict[str, Any], str]]:
    """Return the cards of a file by name, each with the lines in which it is written."""
    text = file.read_text(encoding="utf-8")
    read = yaml.safe_load(text) or {}
    blocks = re.split(r"^(?=[\w@]+:)", text, flags=re.M)
    written = {block.partition(":")[0]: re.sub(r"\n\s*(#[^\n]*\s*)*$", "", block) for block in blocks}
    return {name: (card, written[name]) for name, card in read.items() if isinstance(card, dict) and "draw" in card}


def _kinds(kinds: Mapping[str, list[str]]) -> Iterator[str]:
    """Yield what can be chosen of each kind of figure, and where it is drawn."""
    from importlib import import_module

    from pipeline.kernel import registry

    yield "## Kinds of figures\n"
    yield "`draw:` names a module in the folder `figures` of an experiment; `options:` are its own.\n"
    for name, module in sorted(registry.figures().items()):
        drawing = import_module(module)
        yield f"### {name} {{: #draws-{name} }}\n"
        yield _text((inspect.getdoc(drawing) or "").split("\n\n")[0].replace("\n", " ")) + "\n"
        yield f"Experiment `{module.split('.')[2]}`. Drawn as: {', '.join(kinds.get(name, [])) or 'nothing yet'}.\n"
        schema = drawing.Options.model_json_schema()
        found = _Walk(schema.get("$defs", {})).rows(schema, "")
        if found:
            yield _table(("option", "meaning", "unit", "allowed", "default"), found)


def keys(studies: Mapping[str, Any]) -> str:
    """Return every key of the configuration: meaning, unit, what is allowed, default, where its values come from."""
    from pipeline.config.schema import schema

    whole = schema()
    definitions = whole["$defs"]
    kinds: dict[str, dict[str, list[str]]] = defaultdict(lambda: defaultdict(list))
    for study, root in studies.items():
        for path, source in root.sources.items():
            kinds[path][str(source.kind).replace("_", " ")].append(study)
    told = ["# Keys of the configuration", _intro(), ""]
    walk, sections = _Walk(definitions), definitions["group:study"]["properties"]
    for name in dict.fromkeys([*_FIRST, *sections]):
        if name in _APART or name not in sections:
            continue
        part = sections[name]
        found = [(*row, _origin(row[0], kinds)) for row in walk.rows(part, name)]
        if found:
            told += [f"## {name} {{: #{name} }}\n", _text(part.get("description", "")) + "\n"]
            told.append(_table(("key", "meaning", "unit", "allowed", "default", "source in the studies"), found))
        if name == "modes":
            told += _waveforms()
    return "\n".join(told)


def _waveforms() -> Iterator[str]:
    """Yield what each waveform of a phase takes."""
    from pipeline.charge.waveforms import WAVEFORMS

    yield "A phase names its waveform; what that takes is a number or the name of a knob of the mode:\n"
    for name, waveform in WAVEFORMS.items():
        yield f"### {name} {{: #waveform-{name} }}\n"
        yield _text((inspect.getdoc(waveform) or "").split("\n\n")[0]) + "\n"
        schema = waveform.model_json_schema()
        found = _Walk(schema.get("$defs", {})).rows(schema, "")
        if found:
            yield _table(("key", "meaning", "unit", "allowed", "default"), found)


def _intro() -> str:
    return (
        "Made from the records that validate the configuration. `NAME` stands for a name of your own. A key without a "
        "default must be given by a file or an override. The last column says what kind of source the value has in "
        "the three studies; the values stand under [parameters](parameters.md). `python -m pipeline schema` writes "
        "the same as a JSON schema for editors."
    )


def _origin(path: str, kinds: Mapping[str, Mapping[str, list[str]]]) -> str:
    """Return the kinds of sources that a key has, each with the studies."""
    pattern = re.sub(r"\bNAME\b", "*", path)
    found: dict[str, set[str]] = defaultdict(set)
    for known, own in kinds.items():
        if fnmatchcase(known, pattern) or fnmatchcase(known, f"{pattern}.*"):
            for kind, where in own.items():
                found[kind].update(where)
    return "; ".join(f"{kind} ({', '.join(sorted(where))})" for kind, where in sorted(found.items()))


class _Walk:
    """The leaves of a schema as rows: key, meaning, unit, allowed, default; a record that comes again is named alone.

    Arguments
    ---------
    definitions : the records of the schema by name.
    """

    def __init__(self, definitions: Mapping[str, Any]) -> None:
        self._definitions = definitions
        self._told: dict[str, str] = {}

    def rows(self, part: Mapping[str, Any], path: str) -> list[Row]:
        """Return the rows of a part; forms of a value that share a key and what is allowed are one row."""
        found = {(row[0], row[3]): row for row in reversed(list(self._leaves(part, path, "")))}
        return list(reversed(found.values()))

    def _leaves(self, part: Mapping[str, Any], path: str, told: str) -> Iterator[Row]:
        told = part.get("description", told)
        default, part, name = part.get("default", ...), self._resolved(part), part.get("$ref", "").rpartition("/")[2]
        if name in self._told and self._is_record(part):
            unit, again = _UNIT.search(told), f"as under `{self._told[name]}`"
            yield (
                path,
                "; ".join(filter(None, (_UNIT.sub("", told), again))),
                unit[1] if unit else "",
                "",
                _default(default),
            )
            return
        if name and self._is_record(part):
            self._told[name] = path
        forms = [one for one in part.get("anyOf", [part]) if one.get("type") != "null" and not _is_reference(one)]
        leaf = [one for one in forms if not self._is_record(one)]
        for one in forms:
            if self._is_record(one):
                yield from self._inside(one, path, told)
        if leaf:
            told = told or next((one["description"] for one in leaf if "description" in one), "")
            default = next((one["default"] for one in leaf if "default" in one), default)
            unit = _UNIT.search(told)
            yield path, _UNIT.sub("", told), unit[1] if unit else "", _allowed(leaf), _default(default)

    def _inside(self, part: Mapping[str, Any], path: str, told: str) -> Iterator[Row]:
        """Yield the rows of what a record, a mapping or a choice of records holds."""
        if "$ref" in part or "anyOf" in part:
            yield from self._leaves(part, path, told)
            return
        for name, one in part.get("properties", {}).items():
            if name not in ("sources", "defaults"):
                yield from self._leaves(one, f"{path}.{name}".lstrip("."), "")
        if isinstance(part.get("additionalProperties"), dict):
            yield from self._leaves(part["additionalProperties"], f"{path}.NAME", told)

    def _resolved(self, part: Mapping[str, Any]) -> Mapping[str, Any]:
        return self._definitions[part["$ref"].rpartition("/")[2]] if "$ref" in part else part

    def _is_record(self, part: Mapping[str, Any]) -> bool:
        part = self._resolved(part)
        inner = part.get("additionalProperties")
        forms = any(self._is_record(one) for one in part.get("anyOf", []))
        return forms or "properties" in part or (isinstance(inner, dict) and self._is_record(inner))


def _is_reference(part: Mapping[str, Any]) -> bool:
    """Tell whether a form of a value is what stands for another value, `${...}`: it may stand anywhere."""
    return "$" in str(part.get("pattern", ""))


_KINDS = {"string": "text", "boolean": "true, false", "array": "list", "object": "mapping", "integer": "whole number"}
_FAR = 1e6
_BOUNDS = (("exclusiveMinimum", "> "), ("minimum", "≥ "), ("exclusiveMaximum", "< "), ("maximum", "≤ "))


def _allowed(forms: Iterable[Mapping[str, Any]]) -> str:
    """Return what a value may be, in words; a bound that no value comes near is left out."""
    told = []
    for one in forms:
        if "anyOf" in one:
            told.append(_allowed(inner for inner in one["anyOf"] if not _is_reference(inner)))
            continue
        near = {name: one[name] for name, _ in _BOUNDS if name in one and abs(one[name]) < _FAR}
        bounds = ", ".join(f"{sign}{near[name]:g}" for name, sign in _BOUNDS if name in near)
        given = ", ".join(str(value) for value in one.get("enum", [one["const"]] if "const" in one else []))
        kinds = one.get("type", "number")
        kinds = [kind for kind in ([kinds] if isinstance(kinds, str) else kinds) if kind != "null"]
        kind = " or ".join(_KINDS.get(kind, kind) for kind in kinds)
        told.append(given or bounds or kind)
    return " or ".join(dict.fromkeys(filter(None, told)))


def _default(value: Any) -> str:
    if value is ...:
        return ""
    if value is None:
        return "none"
    told = {True: "true", False: "false"}.get(value, value) if isinstance(value, bool) else value
    return f"{told:g}" if isinstance(told, float) else "empty" if told in ([], {}, "") else str(told)


def parameters(studies: Mapping[str, Any]) -> str:
    """Return every parameter of the studies that has a source: value, unit, range of the estimate, source."""
    from pipeline.config.units import unit_of

    told = ["# Parameters of the studies", "Where every number comes from, as the files of `conf/` say it.\n"]
    for study, root in studies.items():
        told.append(f"## {_title(study)} {{: #{study} }}\n")
        values = {path: value for part in root.parameter_sections() for path, value in root.parameters(part)}
        rows = [
            (
                path, _default(values.get(path, "")), unit_of(root, path).removeprefix("1"),
                "" if source.range is None else f"{source.range[0]:g} to {source.range[1]:g}",
                str(source.kind).replace("_", " "), source.ref,
            )
            for path, source in root.sources.items()
        ]  # fmt: skip
        told.append(_table(("key", "value", "unit", "range", "source", "reference"), rows))
    return "\n".join(told)


def notebook() -> str:
    """Return the words of a notebook, from their docstrings."""
    import pipeline
    from pipeline.notebook.outcome import NotebookCharge, Summary

    told = ["# Words of a notebook", "`import pipeline as cp`; how they are used: [in a notebook](../notebook.md).\n"]
    for name in ("charge", "compare", "sweep", "battery", "mode"):
        word = pipeline._word(name)
        told.append(f"## cp.{name} {{: #{name} }}\n")
        told.append(f"```python\n{name}{inspect.signature(word)}\n```\n")
        told.append(_docstring(word))
    for record in (NotebookCharge, Summary):
        told.append(f"## {record.__name__} {{: #{record.__name__.lower()} }}\n\n{_docstring(record)}")
        for name, member in vars(record).items():
            if not name.startswith("_") and inspect.getdoc(member):
                shown = "" if not callable(member) else str(inspect.signature(member)).replace("self, ", "")
                told.append(f"### {record.__name__}.{name} {{: #{record.__name__.lower()}-{name} }}\n")
                told.append(f"`{name}{shown.replace('(self)', '()')}`\n\n{_docstring(member)}")
    return "\n".join(told)


def _docstring(of: Any) -> str:
    """Return a docstring as Markdown: underlined words as headings, arguments as a list, examples as code."""
    told = []
    for block in (inspect.getdoc(of) or "").split("\n\n"):
        lines = block.splitlines()
        if lines[0].startswith(">>>"):
            told.append("\n".join(["```pycon", *lines, "```"]))
            continue
        if len(lines) > 1 and re.fullmatch("-{3,}", lines[1]):
            told.append(f"**{lines[0]}**")
            lines = lines[2:]
        entries = re.split(r"\n(?! )", "\n".join(lines))
        named = [entry.partition(" : ") for entry in entries]
        if all(between for _, between, _ in named):
            told.append("\n".join(f"- `{names}`: {_text(meaning)}" for names, _, meaning in named))
        else:
            told.append(_text(" ".join(lines)))
    return "\n\n".join(told) + "\n"


def _study(name: str) -> Any:
    from pipeline.config.compose import compose_tree
    from pipeline.config.study import study_from

    return study_from(compose_tree([f"study={name}"]))


def _title(name: str) -> str:
    file = ROOT / "conf" / "study" / f"{name}.yaml"
    card = yaml.safe_load(file.read_text(encoding="utf-8")).get("study", {}) if file.is_file() else {}
    return str(card.get("title", name))


def _table(head: tuple[str, ...], rows: Rows) -> str:
    from pipeline.report.text import prose

    lines = [" | ".join(head), " | ".join("---" for _ in head)]
    for key, *cells in rows:
        lines.append(" | ".join([f"`{key}`", *(_text(prose(str(cell))) for cell in cells)]))
    return "\n".join(f"| {line} |" for line in lines) + "\n"


def _text(text: str) -> str:
    """Return a text that Markdown leaves as it is, in one line; what stands between backticks stays code."""
    parts = " ".join(text.split()).split("`")
    for place in range(0, len(parts), 2 if len(parts) % 2 else 1):
        parts[place] = re.sub(r"([\\*_{}\[\]<>|])", r"\\\1", parts[place])
    return ("`" if len(parts) % 2 else "\\`").join(parts)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs" / "generated")
