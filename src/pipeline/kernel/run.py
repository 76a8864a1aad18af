"""Runs the nodes of one chunk of a plan: `python -m pipeline.kernel.run --plan FILE --step charge --chunk NAME`."""

from __future__ import annotations

import argparse
import importlib
import signal
import sys
import time
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from pipeline.kernel import lock, planfile, publish, receipts, store
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.kernel.errors import EngineError, UserError
from pipeline.kernel.last_resort import last_resort
from pipeline.kernel.tables import TableFile


def main(arguments: Sequence[str]) -> int:
    """Run a chunk; return 0, or 2 for a person's mistake and 1 for what did not compute or came out different."""
    parser = argparse.ArgumentParser(prog="python -m pipeline.kernel.run", description=__doc__)
    parser.add_argument("--plan", type=Path, required=True, help="plan file, results/plan/<digest>.json")
    parser.add_argument("--step", required=True, help="the step to run, or publish")
    parser.add_argument("--chunk", required=True, help="name of the chunk in the plan")
    parser.add_argument("--results", type=Path, default=store.RESULTS, help="folder of the store (%(default)s)")
    parser.add_argument("--again", action="store_true", help="compute what is there already, and compare")
    options = parser.parse_args(arguments)
    try:
        with lock.at_work(options.results):
            _run(options)
    except UserError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except (store.StoreError, EngineError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    except Exception as error:  # the last resort: one line for a person, the rest for whoever mends the program
        print(f"error: {last_resort(error, options.results)}", file=sys.stderr)
        return 1
    return 0


def _run(options: argparse.Namespace) -> None:
    plan = planfile.load(options.plan)
    chunk = plan["chunks"].get(options.chunk)
    if chunk is None or chunk["step"] != options.step:
        raise UserError(f"plan {options.plan} has no {options.step} chunk {options.chunk!r}")
    if options.step == "publish":
        publish.publish(plan, options.chunk, options.results)
    else:
        run_chunk(plan, options.chunk, options.results, options.again)


def run_chunk(plan: Mapping[str, Any], name: str, results: Path, again: bool) -> None:
    """Make every artefact of a chunk that is not there, then the receipt."""
    chunk = plan["chunks"][name]
    step = chunk["step"]
    store.own(results, store.artefact(results, step, name))
    store.own(results, receipts.path_of(results, step, name))
    made: dict[str, dict[str, str]] = {}
    for position, key in enumerate(chunk["nodes"], start=1):
        begin = time.monotonic()
        made[key] = store.make(results, step, key, partial(_compute, plan, key, results), again)
        took = time.monotonic() - begin
        print(f"{step} {name} {position}/{len(chunk['nodes'])}: {key[:12]} in {took:.2f} s", flush=True)
    receipts.write(results, step, name, made, {})


def _compute(plan: Mapping[str, Any], key: str, results: Path, output: Path) -> None:
    node = plan["nodes"][key]
    makers = {name: plan["nodes"][maker]["step"] for name, maker in node["inputs"].items()}
    folders = {
        name: store.whole(results, makers[name], maker, f"input {name}") for name, maker in node["inputs"].items()
    }
    tables = {step: _tables(plan, step) for step in {node["step"], *makers.values()}}
    inputs = Inputs(folders, {name: tables[step] for name, step in makers.items()})
    module = importlib.import_module(plan["steps"][node["step"]]["module"])
    module.run(resolve(node["settings"], folders), inputs, Output(output, tables[node["step"]]))


def _tables(plan: Mapping[str, Any], step: str) -> dict[str, TableFile]:
    return {name: TableFile.of(found) for name, found in plan["steps"][step]["tables"].items()}


def resolve(settings: Any, inputs: Mapping[str, Path]) -> Any:
    """Put found values in the place of references `{from: step, value: name}`."""
    if isinstance(settings, Mapping):
        if set(settings) == {"from", "value"}:
            return store.found_value(inputs[settings["from"]], settings["value"])
        return {name: resolve(value, inputs) for name, value in settings.items()}
    if isinstance(settings, list):
        return [resolve(value, inputs) for value in settings]
    return settings


def _ended(number: int, frame: object) -> None:
    """End as after an error, so that what was half written is removed."""
    sys.exit(128 + number)


if __name__ == "__main__":
    signal.signal(signal.SIGTERM, _ended)
    try:
        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:
        sys.exit(128 + signal.SIGINT)
