"""Results in a bucket: `make bucket-test` runs a study with moto's server on loopback in the place of S3.

A run is killed, another machine's folder goes on from what the bucket has, and every artefact is that of a local run.
"""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import psutil

from pipeline.commands import new
from pipeline.kernel import store
from tests.slurm.__main__ import Project, Wrong, _line, _must, _until

BUCKET = "charges"
STUDY = "resting_study"


@contextlib.contextmanager
def served() -> Iterator[str]:
    """Serve buckets on loopback; yields the address."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = int(free.getsockname()[1])
    words = [sys.executable, "-m", "moto.server", "-H", "127.0.0.1", "-p", str(port)]
    server = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        end = time.monotonic() + 60.0
        while True:
            with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port), timeout=1.0):
                break
            _must(time.monotonic() < end and server.poll() is None, "moto's server did not come up")
            time.sleep(0.2)
        yield f"http://127.0.0.1:{port}"
    finally:
        server.terminate()
        server.wait(timeout=20)


def _client(address: str) -> Any:
    import boto3

    words = {"aws_access_key_id": "test", "aws_secret_access_key": "test", "region_name": "us-east-1"}
    return boto3.client("s3", endpoint_url=address, **words)


def _names(client: Any) -> dict[str, str]:
    pages = client.get_paginator("list_objects_v2").paginate(Bucket=BUCKET)
    return {one["Key"]: one["ETag"] for page in pages for one in page.get("Contents", ())}


def _archives(client: Any) -> dict[str, str]:
    """Return the archives whose receipts are there too: what a job made whole."""
    names = _names(client)
    receipt = {name: str(Path(name.replace("archives", "receipts")).with_suffix(".json")) for name in names}
    return {name: tag for name, tag in names.items() if name.endswith(".tar") and receipt[name] in names}


def _project(folder: Path) -> Project:
    project = Project(folder)
    list(new.write("resting", folder))
    return project


def _words(address: str) -> list[str]:
    words = ["snakemake", "--cores", "1", STUDY, "--default-storage-provider", "s3"]
    words += ["--default-storage-prefix", f"s3://{BUCKET}", "--storage-s3-endpoint-url", address]
    words += ["--storage-s3-access-key", "test", "--storage-s3-secret-key", "test", "--storage-s3-region", "us-east-1"]
    return [*words, "--scheduler", "greedy"]


def _tested(folder: Path) -> None:
    local = _project(folder / "local")
    local.done(local.start("snakemake", "--cores", "1", STUDY))
    expected = local.artefacts()

    with served() as address:
        client = _client(address)
        client.create_bucket(Bucket=BUCKET)
        first = _project(folder / "first")
        process = first.start(*_words(address))
        _until(
            lambda: process.poll() is not None or sum(name.endswith(".tar") for name in _names(client)) >= 2, "archives"
        )
        _must(process.poll() is None, f"ended before it was killed:\n{first.printed()[-5000:]}")
        for one in [*psutil.Process(process.pid).children(recursive=True), psutil.Process(process.pid)]:
            with contextlib.suppress(psutil.NoSuchProcess):
                os.kill(one.pid, signal.SIGKILL)
        process.wait()
        kept = _archives(client)
        _line(f"killed with {len(kept)} archives in the bucket; another folder goes on")

        second = _project(folder / "second")
        second.done(second.start(*_words(address)))
        made = second.artefacts()
        differing = [name for name, files in made.items() if expected.get(name) != files]
        _must(not differing and made, f"artefacts that are not those of the local run: {differing}")
        now = _names(client)
        _must(all(now.get(name) == tag for name, tag in kept.items()), "an archive that was there was made again")
        again = [
            name for name in kept if (second.folder / name.replace("archives", "logs")).with_suffix(".log").exists()
        ]
        _must(not again, f"what the bucket had was computed again: {again}")
        _must((second.results / STUDY / "default" / "manifest.json").is_file(), "nothing is shown")
        size = sum(one["Size"] for one in client.list_objects_v2(Bucket=BUCKET)["Contents"])
        _line(
            f"{len(made)} artefacts, bytes as of the local run; {len(now)} objects of {size / 1e6:.1f} MB in the bucket"
        )
        again = second.done(second.start(*_words(address)))
        _must(
            "Nothing to be done" in again.split("results:")[-1] or "Nothing to be done" in again,
            "a third run did something",
        )


def main() -> int:
    """Run it; return 0, or 1 where something is otherwise."""
    folder = Path(tempfile.mkdtemp(prefix="bucket-"))
    try:
        _tested(folder)
    except (Wrong, subprocess.TimeoutExpired) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    finally:
        if "--keep" in sys.argv:
            _line(f"kept: {folder}")
        else:
            store.remove(folder)
    _line("all as it must be")
    return 0


if __name__ == "__main__":
    sys.exit(main())
