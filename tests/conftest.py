"""Which tests go to one worker, so that what they compile is compiled once."""

from __future__ import annotations

from pathlib import Path

import pytest

# Those that charge; the rest of these folders goes along, which shares the work evenly between two workers.
ENGINE = ("charge", "day", "objective", "steps", "validation", "workflow", "experiments/trade_off")
KERNELS = ("converter", "grnn", "panel", "search", "tracker")
ROOT = Path(__file__).parent


@pytest.hookimpl(tryfirst=True)  # before xdist looks at the groups
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        place = item.path.relative_to(ROOT).as_posix()
        if place.startswith(ENGINE):
            item.add_marker(pytest.mark.xdist_group("engine"))
        elif place.startswith(KERNELS):
            item.add_marker(pytest.mark.xdist_group(place.split("/")[0]))
