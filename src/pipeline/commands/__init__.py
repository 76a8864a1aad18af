"""The words that `python -m pipeline` understands, one module each."""

COMMANDS = (
    *("run", "compare", "reproduce", "report", "store", "validate", "steps", "modes", "schema", "new", "init"),
    *("readme", "completion"),
)
"""The words; each is a module of `pipeline.commands` with `main(arguments) -> exit code`."""
