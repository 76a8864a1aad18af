"""What publishing writes about a run beside its page: when and by which commit; and the page that leads to all others.

None of it is keyed, listed in a manifest or compared: it tells of circumstances.
"""

from __future__ import annotations

import fcntl
import json
import os
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from pipeline.kernel import store
from pipeline.kernel.publish import view_folder
from pipeline.report.pages import front

RUN, FRONT, OTHERS = "run.js", "index.html", "reports.js"
_TOLD = ("command", "commit", "digest", "seed", "versions")


def published(run: Mapping[str, Any], manifest: Mapping[str, Any], results: Path) -> None:
    """Write the script beside a run's page, then the front page of the reports.

    Arguments
    ---------
    run : a run of the plan, which was just published, whole or in part.
    manifest : what its manifest says.
    results : folder of the store; the reports are beside it.
    """
    reports, folder = results.parent / store.REPORTS, view_folder(results, run, store.REPORTS)
    if (folder / "index.html").is_file():
        told = {name: manifest[name] for name in _TOLD} | {"made": time.strftime("%Y-%m-%d %H:%M UTC", time.gmtime())}
        place = json.dumps(folder.relative_to(reports).as_posix())
        text = f"window.RUN = {json.dumps(told, ensure_ascii=False)};\n"
        store.write_text(folder / RUN, f"{text}window.RUNS = {{ ...window.RUNS, [{place}]: window.RUN }};\n")
    else:
        (folder / RUN).unlink(missing_ok=True)
    if reports.is_dir():
        lead_to_all(reports)


def lead_to_all(reports: Path) -> None:
    """Write the front page of the reports in a folder anew, and the script of their places."""
    with _one_at_a_time(reports):
        found = list(cards(reports))
        listed = [{"place": one["place"], "title": one["title"]} for one in found]
        store.write_text(reports / FRONT, front(found))
        store.write_text(reports / OTHERS, f"window.REPORTS = {json.dumps(listed, ensure_ascii=False)};\n")


def cards(reports: Path) -> Iterator[dict[str, Any]]:
    """Yield the card of every page under a folder with its place there, by their places; a damaged one is left out."""
    for path in sorted(path for pattern in ("*/*", "*/sweeps/*") for path in reports.glob(f"{pattern}/card.json")):
        try:
            card = json.loads(path.read_text(encoding="utf-8"))
            fields = ("title", "question", "answer", "counts", "picture", "departs")
            found = {name: card[name] for name in fields}
        except (OSError, ValueError, KeyError, TypeError):
            continue
        if (path.parent / "index.html").is_file():
            yield found | {"place": path.parent.relative_to(reports).as_posix(), "run": (path.parent / RUN).is_file()}


@contextmanager
def _one_at_a_time(folder: Path) -> Iterator[None]:
    """Let jobs that publish at the same time write one after the other, so that the last one has seen all pages."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        with suppress(OSError):  # a file system without locks
            fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)
