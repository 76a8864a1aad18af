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
from types import ModuleType
from typing import Any, NamedTuple

from pipeline.kernel import archive, lock, nearby, planfile, publish, receipts, store
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.kernel.errors import EngineError, UserError
from pipeline.kernel.last_resort import last_resort
from pipeline.kernel.tables import TableFile

PATIENCE_S = 60.0
"""For how long the job of a cluster looks for an input that is not there yet, as Snakemake does for a receipt."""


class Task(NamedTuple):
    """What a step is to do for a node: the arguments of its `run`."""

    settings: Any
    inputs: Inputs
    output: Output


def main(arguments: Sequence[str]) -> int:
    """Run a chunk; return 0, or 2 for a person's mistake and 1 for what did not compute or came out different."""
    parser = argparse.ArgumentParser(prog="python -m pipeline.kernel.run", description=__doc__)
    parser.add_argument("--plan", type=Path, required=True, help="plan file, results/plan/<digest>.json")
    parser.add_argument("--step", required=True, help="the step to run, or publish")
    parser.add_argument("--chunk", required=True, help="name of the chunk in the plan")
    parser.add_argument("--results", type=Path, default=store.RESULTS, help="folder of the store (%(default)s)")
    parser.add_argument("--again", action="store_true", help="compute what is there already, and compare")
    parser.add_argument("--take", nargs="*", type=Path, default=[], help="receipts and archives of what it needs")
    parser.add_argument("--give", nargs="*", type=Path, default=[], help="where its receipt goes too, and its archive")
    options = parser.parse_args(arguments)
    try:
        with lock.at_work(options.results):
            if nearby.on_a_cluster():
                store.patience_s = PATIENCE_S
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
    for path in options.take:
        if path.suffix == archive.SUFFIX:
            archive.unpack(options.results, path)
    if options.step == "publish":
        publish.publish(plan, options.chunk, options.results)
    else:
        run_chunk(plan, options.chunk, options.results, options.again)
    for path in options.give:
        if path.suffix == archive.SUFFIX:
            archive.pack(options.results, options.step, chunk["nodes"], path)
        else:
            receipt = receipts.path_of(options.results, options.step, options.chunk)
            store.write_text(path, receipt.read_text(encoding="utf-8"))


def run_chunk(plan: Mapping[str, Any], name: str, results: Path, again: bool) -> None:
    """Make every artefact of a chunk that is not there, then the receipt."""
    chunk = plan["chunks"][name]
    step = chunk["step"]
    store.own(results, store.artefact(results, step, name))
    store.own(results, receipts.path_of(results, step, name))
    nearby.bring(plan["steps"][step]["module"])
    module = importlib.import_module(plan["steps"][step]["module"])
    size = getattr(module, "BATCH", 1) if hasattr(module, "run_many") else 1
    made: dict[str, dict[str, str]] = {}
    failed: list[Exception] = []
    for start in range(0, len(chunk["nodes"]), size):
        batch = chunk["nodes"][start : start + size]
        begin = time.monotonic()
        done = _made(plan, module, results, batch, again, failed)
        made |= done
        took = time.monotonic() - begin
        place, total = start + len(batch), len(chunk["nodes"])
        print(f"{step} {name} {place}/{total}: {', '.join(key[:12] for key in done)} in {took:.2f} s", flush=True)
    if failed:
        raise failed[0]
    nearby.give_back(plan["steps"][step]["module"])
    receipts.write(results, step, name, made, {})


def _made(
    plan: Mapping[str, Any],
    module: ModuleType,
    results: Path,
    keys: Sequence[str],
    again: bool,
    failed: list[Exception],
) -> dict[str, dict[str, str]]:
    """Make some artefacts at once; where one cannot be made, each alone, what fails being put to `failed`."""
    step, compute = plan["nodes"][keys[0]]["step"], partial(_compute, plan, module, results)
    try:
        return store.make_many(results, step, keys, compute, again)
    except (EngineError, UserError) as error:
        if len(keys) == 1:
            print(f"{step} {keys[0]}: {error}", flush=True)
            failed.append(error)
            return {}
    made: dict[str, dict[str, str]] = {}
    for key in keys:
        made |= _made(plan, module, results, [key], again, failed)
    return made


def _compute(plan: Mapping[str, Any], module: ModuleType, results: Path, outputs: Mapping[str, Path]) -> None:
    """Run the step for some of its nodes, each into a folder of its own."""
    whole: dict[str, Path] = {}
    declared: dict[str, dict[str, TableFile]] = {}
    tasks = [_task(plan, key, results, folder, whole, declared) for key, folder in outputs.items()]
    if hasattr(module, "run_many"):
        module.run_many(tasks)
    else:
        for task in tasks:
            module.run(*task)


def _task(
    plan: Mapping[str, Any],
    key: str,
    results: Path,
    output: Path,
    whole: dict[str, Path],
    declared: dict[str, dict[str, TableFile]],
) -> Task:
    """Return what a step is to do for a node; `whole` and `declared` keep what others of its job have looked up."""
    node = plan["nodes"][key]
    makers = {name: plan["nodes"][maker]["step"] for name, maker in node["inputs"].items()}
    for name, maker in node["inputs"].items():
        if maker not in whole:
            whole[maker] = store.whole(results, makers[name], maker, f"input {name}")
    for step in {node["step"], *makers.values()} - declared.keys():
        declared[step] = _tables(plan, step)
    folders = {name: whole[maker] for name, maker in node["inputs"].items()}
    inputs = Inputs(folders, {name: declared[step] for name, step in makers.items()})
    return Task(resolve(planfile.settings(plan, key), folders), inputs, Output(output, declared[node["step"]]))


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
