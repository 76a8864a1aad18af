"""Sweep page: the table of a sweep in; a page with pictures and a table to sort and to filter out."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq

from pipeline.experiments.sweeps import pictures
from pipeline.experiments.sweeps.reading import TABLE, Outcome, outcomes
from pipeline.experiments.sweeps.reading import text as shown
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.report import pages, style, text

TEMPLATE = Path(__file__).with_name("sweep.html.j2")


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Draw the pictures and write the page."""
    table = pq.read_table(inputs["sweep"] / TABLE)
    columns = {name: table.column(name).to_pylist() for name in table.column_names}
    names = settings["names"]
    for one in settings["keys"]:
        columns[one["key"]] = [one["titles"].get(str(value), value) for value in columns[one["key"]]]
    keys = {
        one["key"]: style.label(_called(one["short"], names), text.symbols(one["unit"])) for one in settings["keys"]
    }
    found = outcomes(columns)
    comparisons: dict[str, list[Outcome]] = {}
    for one in found:
        comparison, _, mode = one.charge.rpartition(".")
        comparisons.setdefault(comparison, []).append(one._replace(charge=_called(mode, names)))
    drawn, sizes = [], []
    for comparison, own in comparisons.items() if keys else ():
        name = f"sweep_{comparison}" if comparison else "sweep"
        with style.active():
            style.save(pictures.draw(keys, own, columns), output.folder, name)
        size = pages.size_of((output.folder / f"{name}.svg").read_text(encoding="utf-8"))
        sizes.append(size)
        title = _called(comparison, names) if comparison else "The modes"
        drawn.append({"file": f"{name}.svg", "title": title, "size": size})
    missed = [name for name in columns if name.endswith(".missed") and any(columns[name])]
    page = pages.environment(TEMPLATE.parent).get_template(TEMPLATE.name)
    (output.folder / "index.html").write_text(
        page.render(
            study=settings["study"],
            name=settings["sweep"],
            title=settings["title"],
            keys=list(keys.values()),
            command=settings["command"],
            count=table.num_rows,
            pictures=drawn,
            heads=[
                "Run",
                *keys.values(),
                *(_head(one, names) for one in found),
                *(_called(one, names) for one in missed),
            ],
            rows=[
                [
                    _cell(columns["run"][row]),
                    *(_cell(columns[key][row]) for key in keys),
                    *(_cell(columns[one.column][row], one.factor) for one in found),
                    *(_cell(columns[name][row] or "") for name in missed),
                ]
                for row in range(table.num_rows)
            ],
            files=settings["files"],
        ),
        encoding="utf-8",
    )
    picture = (str(drawn[0]["file"]), sizes[0]) if drawn else None
    runs = f"{table.num_rows} run{'' if table.num_rows == 1 else 's'} over {', '.join(keys.values()) or 'the study'}"
    card = pages.short_card(f"{settings['title']}, sweep {settings['sweep']}", runs, picture=picture)
    (output.folder / "card.json").write_text(json.dumps(card, ensure_ascii=False, indent=1) + "\n", encoding="utf-8")


def _cell(value: Any, factor: float = 1.0) -> tuple[str, str]:
    """Return what a cell shows, and by what it is sorted where that is a number."""
    number = "" if isinstance(value, str | bool | None) else repr(factor * value)
    return shown(value, factor), number


def _head(one: Outcome, names: Mapping[str, str]) -> str:
    return style.label(f"{_called(one.charge, names)}: {one.title}", one.unit)


def _called(path: str, names: Mapping[str, str]) -> str:
    """Return a key path or the name of a charge in words, a unit at its end left out; a capital opens it."""
    first, *others = (names.get(part, text.label(part, False)) for part in path.split("."))
    others = [word if word[1:2].isupper() else word[:1].lower() + word[1:] for word in others]
    return " ".join([first[:1].upper() + first[1:], *others])
