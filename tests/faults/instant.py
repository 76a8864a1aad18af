"""A plan whose steps take no time: two of them in a row, and the publishing of what they make."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pipeline.kernel import digest, planfile
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.kernel.tables import Column, Table, TableFile

TABLE = TableFile("numbers.parquet", Table("numbers", "Numbers", (Column("number", "1", "a number"),)))


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Write a table, what was found, and a text in a folder."""
    before = [float(one) for name in inputs for one in inputs.table(name, "numbers")["number"]]
    output.write("numbers", {"number": [*before, *range(int(settings["numbers"]))]})
    output.found({"last": settings["numbers"]})
    folder = output.folder / "part"
    folder.mkdir()
    (folder / "text.txt").write_text("text\n" * 9, encoding="utf-8")


def plan(numbers: int = 50) -> dict[str, Any]:
    """Return the plan; another count of numbers is another run under the same name."""
    steps = {
        name: {
            "module": __name__,
            "rule": name,
            "message": name,
            "target": name,
            "priority": 0,
            "tables": {"numbers": TABLE.plain()},
        }
        for name in ("first", "second")
    }
    keys = {name: digest.of_value([name, numbers]) for name in steps}
    nodes = {
        keys[name]: {
            "step": name,
            "settings": {"numbers": numbers},
            "inputs": {"first": keys["first"]} if name == "second" else {},
        }
        for name in steps
    }
    view = [
        {"step": name, "key": keys[name], "file": file, "place": f"{name}/{file}", "room": room}
        for name in steps
        for file, room in (("numbers.parquet", "results"), ("part/text.txt", "reports"))
    ]
    run = {"study": "instant", "name": "default", "overrides": [], "seed": 1, "configuration": {"numbers": numbers}}
    run |= {"sources": {}, "view": view, "nodes": {name: {"step": name, "key": keys[name]} for name in steps}}
    run["digest"] = digest.of_value(run)
    chunks: dict[str, Any] = {
        f"{name}-{numbers}": {"step": name, "nodes": [keys[name]], "needs": [f"first-{numbers}"] * (name == "second")}
        for name in steps
    }
    published = {"step": "publish", "part": "all", "steps": list(steps), "runs": [0], "needs": [f"second-{numbers}"]}
    chunks[f"all-{numbers}"] = published
    return {
        "version": planfile.VERSION,
        "runs": [run],
        "steps": steps,
        "nodes": nodes,
        "chunks": chunks,
        "targets": {"all": [f"all-{numbers}"]},
        "tells": [],
    }
