"""`python -m pipeline report [RUN]`: a run in the terminal, its verdicts or its charges in numbers, and its page.

A run of a sweep, which keeps its numbers alone, is made whole first.
"""

from __future__ import annotations

import base64
import json
import re
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pipeline.commands import Parser, as_typed, typed
from pipeline.commands.compare import shortened
from pipeline.commands.terminal import say, table_lines
from pipeline.config.naming import run_name
from pipeline.errors import UserError, best_matches
from pipeline.experiments.charges import telling as of_charges
from pipeline.experiments.sweeps import telling as of_sweep
from pipeline.kernel import planfile, publish, tables
from pipeline.kernel.store import REPORTS, RESULTS
from pipeline.published.answer import ANSWER
from pipeline.published.evaluate import VERDICTS
from pipeline.published.words import counted
from pipeline.report import text
from pipeline.report.pages import TRACES


def main(arguments: Sequence[str]) -> int:
    """Print a run's verdicts, or its charges where nothing is published, or write its page as one file; return 0."""
    parser = Parser(prog=typed("report"), description=as_typed(__doc__ or ""))
    words = "study/run (the study of conf/config.yaml, its default run), a sweep, or a run of one"
    parser.add_argument("run", nargs="?", help=words)
    parser.add_argument("--single-file", type=Path, metavar="FILE", help="write the page with all it shows in one file")
    options = parser.parse_args(arguments)
    run = shortened(options.run or _default())
    swept = _of_sweep(run)
    if swept is not None:
        study, overrides = swept
        # The runner of the workflow is needed for this alone.
        from pipeline.commands.run import main as make

        code = make([f"study={study}", *overrides])
        if code:
            return code
        run = f"{study}/{run_name(overrides)}"
    run = run if "/" in run else f"{run}/default"
    if options.single_file is not None:
        return _single(run, options.single_file)
    published = RESULTS / run / "published"
    answer, verdicts = published / "answer.parquet", published / "verdicts.parquet"
    if not verdicts.is_file() and not (RESULTS / run / publish.MANIFEST).is_file():
        raise UserError(_unpublished(run))
    if answer.is_file():
        _tell(tables.read(ANSWER, answer))
    if verdicts.is_file():
        _print(tables.read(VERDICTS, verdicts))
    else:
        _print_charges(json.loads((RESULTS / run / publish.MANIFEST).read_text(encoding="utf-8")))
    page = Path(REPORTS) / run / "index.html"
    print(f"\nthe page: {page}" if page.is_file() else "\nno page is here")
    return 0


def _default() -> str:
    """Return the study that a run without words makes: that of conf/config.yaml."""
    from pipeline.config.compose import compose_tree
    from pipeline.config.study import study_from

    return str(study_from(compose_tree([])).study.name)


def _single(run: str, target: Path) -> int:
    folder = Path(REPORTS) / run
    if not (folder / "index.html").is_file():
        raise UserError(_unpublished(run))
    try:
        target.write_text(single_file(folder), encoding="utf-8")
    except OSError as error:
        raise UserError(f"{target}: {error.strerror}") from None
    print(f"the page: {target}, {target.stat().st_size / 1e6:.1f} MB")
    return 0


def single_file(folder: Path) -> str:
    """Return the page in a folder with its figures and scripts in it; what leads to other pages is left out."""
    kinds = {".svg": "image/svg+xml", ".png": "image/png"}

    def picture(found: re.Match[str]) -> str:
        file = folder / found[2]
        data = base64.b64encode(file.read_bytes()).decode()
        return f'{found[1]}="data:{kinds[file.suffix]};base64,{data}"'

    def script(found: re.Match[str]) -> str:
        file = folder / found[1]
        text = file.read_text(encoding="utf-8") if file.is_file() and ".." not in found[1] else ""
        return f"<script>\n{text}</script>" if text else ""

    page = (folder / "index.html").read_text(encoding="utf-8")
    page = re.sub(r'(src)="(figures/[^"]+)"', picture, page)
    page = re.sub(r'<a (?:class="\w+" )?href="(?:figures|tables|\.\.)/[^"]*">(.*?)</a>', r"\1", page, flags=re.DOTALL)
    traces = folder / TRACES
    if traces.is_file():
        page = page.replace("</main>", f"</main>\n<script>{traces.read_text(encoding='utf-8')}</script>", 1)
    return re.sub(r'<script src="([^"]+)" defer></script>\n?', script, page)


def _of_sweep(run: str) -> tuple[str, list[str]] | None:
    """Return study and overrides of a run of a sweep; none where the words name none.

    Arguments
    ---------
    run : name of the run, perhaps with the folder of its sweep before it: `study/sweeps/name/run`.

    Raises
    ------
    UserError : runs of several studies have this name.
    """
    found = {}
    for path in sorted(RESULTS.glob("*/sweeps/*/manifest.json")):
        folder = path.parent.relative_to(RESULTS).as_posix()
        manifest = json.loads(path.read_text(encoding="utf-8"))
        for name, one in (manifest.get("sweep") or {}).items():
            if run in (name, f"{folder}/{name}"):
                found[manifest["study"], tuple(one["overrides"])] = f"{folder}/{name}"
    if len(found) > 1:
        raise UserError(f"run {run!r}: several sweeps have one of this name: {', '.join(sorted(found.values()))}")
    return next(((study, list(overrides)) for study, overrides in found), None)


def _unpublished(run: str) -> str:
    """Say what of a run is missing, only parts of it were made or nothing, and what to type."""
    parts = sorted((RESULTS / run).glob("manifest.*.json"))
    study = run.partition("/")[0]
    if not parts:
        known = {path.parent.relative_to(RESULTS).as_posix() for path in publish.manifests(RESULTS)}
        known = {name for name in known if (RESULTS / name / publish.MANIFEST).is_file()}
        if run == f"{study}/default" and study in planfile.studies():
            return f"run {run!r}: not published here; to make it: {typed(f'study={study}')}"
        return f"run {run!r}: not published here; {best_matches(run, known)}"
    manifest = json.loads(parts[0].read_text(encoding="utf-8"))
    made = ", ".join(path.name.split(".", 1)[1].removesuffix(".json") for path in parts)
    whole = typed(shlex.join([f"study={study}", *manifest.get("overrides", ())]))
    return f"run {run!r}: only parts of it are here ({made}); to make all of it: {whole}"


def _print_charges(manifest: Mapping[str, Any]) -> None:
    """Print the charges of a run in numbers, a column a mode, or the runs of a sweep; in a pipe a line a row."""
    if manifest.get("sweep"):
        run = {"study": manifest["study"], "name": manifest["run"], "sweep": manifest["sweep"]}
        for line in of_sweep.lines(run | {"view": manifest["artefacts"]}, {"sweep"}, RESULTS):
            print(line)
        return
    for place, table in enumerate(of_charges.in_numbers(manifest, RESULTS.parent)):
        print("\n" * (place > 0), end="")
        say(table.title, bold=True)
        rows = [(str(name), text.unit(str(unit)), *map(text.number, cells)) for name, unit, *cells in table.rows]
        for line in table_lines([table.header, *rows]):
            print(line)
    run = {"study": manifest["study"], "name": manifest["run"], "nodes": manifest["nodes"]}
    for line in of_charges.lines(run, {"charge"}, RESULTS):
        say(line)


def _tell(answer: Mapping[str, Any]) -> None:
    """Print what the study recommends; in a pipe a line a sentence."""
    for place, sentence in enumerate(answer["sentence"]):
        say(f"{'  ' * (place > 0)}{sentence}", bold=place == 0)
    print()


def _print(verdicts: Mapping[str, Any]) -> None:
    """Print the verdicts as wide as the terminal; in a pipe a line a statement."""
    columns = [list(verdicts[name]) for name in ("statement", "verdict", "where", "explanation")]
    rows = [[" ".join(str(cell).split()) for cell in row] for row in zip(*columns, strict=True)]
    for line in table_lines([("statement", "verdict", "where", "why"), *rows]):
        print(line)
    found = counted(verdicts)
    print()
    say(_told(found["statements"]))
    if found["arithmetic"]:
        say(f"arithmetic of the paper alone, counted apart: {_told(found['arithmetic'])}")


def _told(counts: Sequence[tuple[str, int]]) -> str:
    return ", ".join(f"{count} {word}" for word, count in counts)
