"""Engine: compiles every kernel once, so that charges that run side by side find them compiled."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pipeline.charge.simulate import warm_up


def run(settings: Mapping[str, Any], inputs: Mapping[str, Path], output: Path) -> None:
    """Compile and name the kernels."""
    (output / "kernels.txt").write_text("".join(f"{name}\n" for name in sorted(warm_up())))
