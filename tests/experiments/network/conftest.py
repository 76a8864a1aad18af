"""The network of the Ni-Cd study as it is shipped, and its surfaces."""

from tests.grnn.conftest import study, surfaces

__all__ = ["study", "surfaces"]
