"""What may go wrong by somebody's hand, and what the program could not do."""

from __future__ import annotations


class UserError(Exception):
    """A mistake in what was asked for; printed as one message, exit code 2, no traceback."""


class EngineError(RuntimeError):
    """A computation could not be brought to its end; the message says where it stood. Exit code 1."""
