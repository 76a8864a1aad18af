"""`python -m pipeline schema`: a JSON schema of the configuration, with which editors complete and check its YAML."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from pipeline.commands import Parser, as_typed, typed
from pipeline.config.schema import schema
from pipeline.kernel.store import RESULTS, write_json


def main(arguments: Sequence[str]) -> int:
    """Write the schema, or print it; return 0."""
    parser = Parser(prog=typed("schema"), description=as_typed(__doc__ or ""))
    parser.add_argument("-o", "--output", type=Path, default=RESULTS / "schema.json", help="file (%(default)s)")
    parser.add_argument("-p", "--print", action="store_true", help="print it instead")
    choices = parser.parse_args(arguments)
    if choices.print:
        print(json.dumps(schema(), indent=1))
        return 0
    write_json(choices.output, schema())
    print(f"{choices.output}: groups are under $defs; in an editor, point conf/battery/*.yaml to #/$defs/group:battery")
    return 0
