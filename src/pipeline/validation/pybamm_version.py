"""Which PyBaMM is installed; light, for the plan asks."""

from __future__ import annotations

from importlib import metadata


def version() -> str | None:
    """Return the version of PyBaMM, none without it; nothing of it is imported."""
    try:
        return metadata.version("pybamm")
    except metadata.PackageNotFoundError:
        return None
