"""`python -m pipeline`: runs, compares, reproduces and reports studies, validates the engine, keeps the store."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from importlib import import_module

from pipeline.commands import COMMANDS, as_typed
from pipeline.errors import UserError
from pipeline.kernel import store
from pipeline.kernel.last_resort import in_utf8, last_resort, refuse_other_bytes


def main(arguments: Sequence[str]) -> int:
    """Dispatch on the first word; `run` is the default. Return the exit code, 2 for a person's mistake."""
    words = list(arguments)
    name = words.pop(0) if words and words[0] in COMMANDS else "run"
    try:
        refuse_other_bytes(words)
        return _command(name)(words)
    except UserError as error:
        print(f"error: {as_typed(str(error))}", file=sys.stderr)
        return 2
    except BrokenPipeError:  # whoever reads what is printed has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except Exception as error:  # the last resort: one line for a person, the rest for whoever mends the program
        print(f"error: {last_resort(error, store.RESULTS)}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("ended by a signal; the same command goes on where it was", file=sys.stderr)
        return 130


def command() -> None:
    """Run as the command of a terminal: `charge-pipeline`, or `python -m pipeline`."""
    in_utf8()
    sys.exit(main(sys.argv[1:]))


def _command(name: str) -> Callable[[Sequence[str]], int]:
    module, _, function = COMMANDS[name].partition(".")
    command: Callable[[Sequence[str]], int] = getattr(import_module(f"pipeline.commands.{module}"), function)
    return command


if __name__ == "__main__":
    command()
