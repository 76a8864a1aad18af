"""The words that `python -m pipeline` understands."""

COMMANDS = {
    **{name: f"{name}.main" for name in ("run", "compare", "reproduce", "report", "store", "validate", "steps")},
    "compare-modes": "compare_modes.main",
    **{name: f"listing.{name}" for name in ("batteries", "modes", "panels")},
    **{name: f"{name}.main" for name in ("schema", "new", "init", "readme", "licences")},
    "completion": "looking.main",
}
"""Word -> its function in a module here, `function(arguments) -> exit code`."""
