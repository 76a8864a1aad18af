"""`python -m pipeline`: runs studies, compares and reports runs, validates the engine, keeps the store."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence

from pipeline.errors import UserError

COMMANDS = ("run", "compare", "report", "store", "validate")


def main(arguments: Sequence[str]) -> int:
    """Dispatch on the first word; `run` is the default. Return the exit code, 2 for a person's mistake."""
    words = list(arguments)
    name = words.pop(0) if words and words[0] in COMMANDS else "run"
    try:
        return _command(name)(words)
    except UserError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2


def _command(name: str) -> Callable[[Sequence[str]], int]:
    if name == "run":
        from pipeline.commands.run import main as command
    elif name == "compare":
        from pipeline.commands.compare import main as command
    elif name == "report":
        from pipeline.commands.report import main as command
    elif name == "validate":
        from pipeline.commands.validate import main as command
    else:
        from pipeline.commands.store import main as command
    return command


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
