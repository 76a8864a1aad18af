"""Engine: compiles every kernel once, so that charges that run side by side find them compiled."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pipeline.charge.simulate import warm_up
from pipeline.kernel.artefacts import Inputs, Output


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Compile and name the kernels."""
    (output.folder / "kernels.txt").write_text("".join(f"{name}\n" for name in sorted(warm_up())))
