"""The JSON schema describes what the records read: every file of conf/ fits it, and mistakes do not."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from pipeline.config.compose import groups
from pipeline.config.inheritance import CONF, content
from pipeline.config.schema import schema

FILES = sorted(CONF.rglob("*.yaml"))


@cache
def _schema() -> dict[str, Any]:
    return schema()


def _validator(file: Path) -> Draft202012Validator:
    group = "study" if file.parent == CONF else file.parent.name
    return Draft202012Validator(_schema() | {"$ref": f"#/$defs/group:{group}"})


def _faults(file: Path, values: Any) -> list[str]:
    return [
        f"{'.'.join(map(str, error.path))}: {error.message[:200]}" for error in _validator(file).iter_errors(values)
    ]


def test_it_is_a_schema() -> None:
    Draft202012Validator.check_schema(_schema())
    assert {f"group:{name}" for name in groups()} <= set(_schema()["$defs"])


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.relative_to(CONF).as_posix())
def test_every_file_of_the_configuration_fits(file: Path) -> None:
    assert not _faults(file, content(file))


@pytest.mark.parametrize(
    ("file", "key", "value"),
    [
        ("battery/lead_acid_12v7ah.yaml", "capcity_ah", 7.0),
        ("battery/lead_acid_12v7ah.yaml", "capacity_ah", -7.0),
        ("panel/kc65t.yaml", "max_power_voltage_v", "high"),
        ("study/solar_reflex.yaml", "batery", {}),
        ("search/cpso.yaml", "replicates", 0),
    ],
)
def test_a_mistake_does_not(file: str, key: str, value: Any) -> None:
    assert _faults(CONF / file, {**content(CONF / file), key: value})
