"""`python -m pipeline readme [--check]`: what the README shows of the studies, from the cards of their pages.

A word of the project's own repository, whose README has lines between which this stands.
"""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from pipeline.commands import Parser, as_typed, typed
from pipeline.config.compose import cards
from pipeline.errors import UserError
from pipeline.kernel.places import PROJECT
from pipeline.kernel.store import REPORTS
from pipeline.published.words import WORDS

README = Path("README.md")
PICTURES = Path("docs") / "pictures"
BEGIN, END = "<!-- studies: begin -->", "<!-- studies: end -->"


def main(arguments: Sequence[str]) -> int:
    """Write the answers, counts and pictures of the shipped studies; return 1 where --check finds others."""
    parser = Parser(prog=typed("readme"), description=as_typed(__doc__ or ""))
    parser.add_argument("--check", action="store_true", help="write nothing; tell what would be written otherwise")
    choices = parser.parse_args(arguments)
    files = list(_files(_text(), list(_found(Path(REPORTS)))))
    stale = [path for path, content in files if not path.is_file() or path.read_bytes() != content]
    for path in stale:
        print(f"{path}: {'not as the runs of today have it' if choices.check else 'written'}")
    if choices.check:
        return int(bool(stale))
    shutil.rmtree(PROJECT / PICTURES, ignore_errors=True)
    for path, content in files:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    return 0


def _found(reports: Path) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield name and card of each study that `all` makes."""
    for name, study in cards().items():
        if study.get("apart"):
            continue
        card = reports / name / "default" / "card.json"
        if not card.is_file():
            raise UserError(f"{card}: not there; make the studies first: snakemake --cores 2 all")
        yield name, json.loads(card.read_text(encoding="utf-8"))


def _text() -> str:
    """Return the README.

    Raises
    ------
    UserError : none here, or one without the lines.
    """
    text = README.read_text(encoding="utf-8") if README.is_file() else None
    if text is None or not re.search(f"{BEGIN}\n.*{END}", text, re.DOTALL):
        missing = "no such file is here" if text is None else f"it has no lines {BEGIN} and {END} to write between"
        raise UserError(
            f"{README}: {missing}; readme writes what the studies found into the README of the project's own repository"
        )
    return text


def _files(text: str, found: Sequence[tuple[str, Mapping[str, Any]]]) -> Iterator[tuple[Path, bytes]]:
    told = "\n\n".join([_table(found), *(_shown(name, card) for name, card in found)])
    yield README, re.sub(f"{BEGIN}\n.*{END}", lambda _: f"{BEGIN}\n{told}\n{END}", text, flags=re.DOTALL).encode()
    for name, card in found:
        yield PICTURES / f"{name}.svg", (Path(REPORTS) / name / "default" / _picture(card)).read_bytes()


def _table(found: Sequence[tuple[str, Mapping[str, Any]]]) -> str:
    rows = [["study", *WORDS], ["---"] * (len(WORDS) + 1)]
    for name, card in found:
        counts = dict(card["counts"])
        rows.append([f"`{name}`", *(str(counts.get(word, 0)) for word in WORDS)])
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def _shown(name: str, card: Mapping[str, Any]) -> str:
    return (
        f"**{card['title']}.** {card['question']}\n{card['answer']}\n\n"
        f"![{card['title']}: the figure that shows it]({(PICTURES / name).as_posix()}.svg)"
    )


def _picture(card: Mapping[str, Any]) -> str:
    return str(Path(card["picture"]["file"]).with_suffix(".svg"))
