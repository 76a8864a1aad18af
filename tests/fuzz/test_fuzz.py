"""The fuzzer is whole: every place that names a file and every word of the program are tried."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

from pipeline.__main__ import COMMANDS
from pipeline.config.schema import schema
from pipeline.record import OwnFile
from tests.fuzz import configurations, doors, files


def _subclasses(record: type) -> Iterator[str]:
    for one in record.__subclasses__():
        yield one.__name__
        yield from _subclasses(one)


def test_every_record_with_a_file_of_a_person_has_a_place() -> None:
    definitions = schema()["$defs"]
    named = {name for name, one in definitions.items() if "file" in one.get("properties", {}) and ":" not in name}
    # A source only tells from which file a value was fitted.
    assert named - {"Source"} == set(_subclasses(OwnFile))
    # A weather stands in two places, a load, a table and a measurement in one each.
    assert len(files.PLACES) == 2 + 1 + 1 + 1
    assert {name for name, one in definitions.items() if "table" in one.get("properties", {}) and _text(one)} == {
        "DataSettings"
    }


def _text(part: Mapping[str, Any]) -> bool:
    found = part["properties"]["table"]
    return "CSV" in found.get("description", "")


def test_every_word_of_the_program_is_a_door() -> None:
    assert {f"python -m pipeline {name}" for name in COMMANDS if name != "run"} <= set(doors.REAL)


@pytest.mark.parametrize("place", files.PLACES)
def test_the_right_file_is_taken(place: str, tmp_path: Path) -> None:
    file = tmp_path / "own.csv"
    file.write_text(files.TABLES[place])
    assert doors.checked([*files.PLACES[place], f"{place}={file}"]).word == "taken"


def test_the_schema_rules_out_what_it_says() -> None:
    number, word = [{"type": "number", "exclusiveMinimum": 0}], [{"type": "string"}]
    assert configurations.takes(number, 1.5)
    assert not any(configurations.takes(number, value) for value in (0, -1, True, "1", None, [1], {}))
    assert not any(configurations.takes(word, value) for value in (1, True, None, ["a"]))
    either = [{"type": ["object", "null"]}]
    assert configurations.takes(either, None)
    assert configurations.takes(either, {})
    assert not configurations.takes(either, 3)
    assert configurations.takes([{"enum": ["a", "b"]}], "b")
    assert not configurations.takes([{"enum": ["a", "b"]}], "c")


def test_a_new_field_is_tried_without_a_new_test() -> None:
    places = {path for path, _, _ in configurations.places({}, [schema()["$defs"]["ChargeSettings"]])}
    assert {"+initial_soc", "+ambient_c", "+sample_interval_s"} <= places


def test_a_bad_message_is_told() -> None:
    assert doors.fault(doors.Outcome("refused", "override a.b=1: a.b: too large"), "a.b=1") is None
    assert doors.fault(doors.Outcome("refused", "something is wrong"), "a.b=1")
    assert doors.fault(doors.Outcome("refused", "override a.b=1: Key 'b' full_key: a.b"), "a.b=1")
    assert doors.fault(doors.Outcome("broken", "KeyError: 'b'"), "a.b=1")
