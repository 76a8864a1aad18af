"""The words that `python -m pipeline` understands."""

import re
import sys
from pathlib import Path

COMMANDS = {
    **{name: f"{name}.main" for name in ("run", "compare", "reproduce", "report", "store", "validate", "steps")},
    "compare-modes": "compare_modes.main",
    **{name: f"listing.{name}" for name in ("batteries", "modes", "panels")},
    **{name: f"{name}.main" for name in ("schema", "new", "init", "readme", "licences")},
    "completion": "looking.main",
}
"""Word -> its function in a module here, `function(arguments) -> exit code`."""

OF_THE_REPOSITORY = ("new", "readme")
"""Words that change the project's own repository, and do nothing in a project that `init` made."""


def typed(word: str = "") -> str:
    """Return how a person types a word here: with the installed command, or with Python where that was typed."""
    command = "charge-pipeline" if Path(sys.argv[0]).stem == "charge-pipeline" else "python -m pipeline"
    return f"{command} {word}".rstrip()


def as_typed(text: str) -> str:
    """Return a text with the commands in it as a person types them here."""
    return re.sub(r"python -m pipeline(?![\w.])", typed(), text)
