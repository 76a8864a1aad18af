"""The words that `python -m pipeline` understands."""

import argparse
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NoReturn

from pipeline.errors import closest

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


class Parser(argparse.ArgumentParser):
    """Options of a word of the command; one that is unknown is told with those that look like it."""

    def error(self, message: str) -> NoReturn:
        """End with usage and message, code 2."""
        option = re.match(r"unrecognized arguments: .*?(--[\w-]+)", message)
        super().error(message + (self.nearest(option[1]) if option else ""))

    def nearest(self, word: str) -> str:
        """Return which options look like a word, as the end of a message; nothing where none does."""
        near = closest(word.split("=", 1)[0], self._options()) if word.startswith("--") else []
        return f"; best matches are: {', '.join(near)}" if near else ""

    def _options(self) -> Iterator[str]:
        """Yield the long options, with those of the words that have parsers of their own."""
        for action in self._actions:
            yield from (option for option in action.option_strings if option.startswith("--"))
            for parser in action.choices.values() if isinstance(action.choices, dict) else ():
                yield from parser._options()
