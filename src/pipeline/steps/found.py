"""The values a step found for others, which `{from: step, value: name}` asks for."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any


def write(values: Mapping[str, Any], output: Path) -> None:
    """Write found values where `store.found_value` reads them: numbers, or records as plain data."""
    text = json.dumps(dict(values), indent=1, sort_keys=True, allow_nan=False)
    (output / "found.json").write_text(text + "\n", encoding="utf-8")
