"""One run at a time in a results folder; what waits says for whom, and no death leaves a lock behind."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from pipeline.kernel import lock
from pipeline.kernel.errors import UserError

HOLDER = """
import os, subprocess, sys, time
from pathlib import Path
from pipeline.kernel import lock

results = Path(sys.argv[1])
with getattr(lock, sys.argv[2])(results, *([print] if sys.argv[2] == "held" else [])) as descriptor:
    if "hand" in sys.argv:
        # The one that it is handed on to takes it at once; after this process' end it is still held.
        env = os.environ | {lock.HANDED_ON: str(descriptor)}
        subprocess.Popen([sys.executable, "-c", "INNER", str(results)], env=env, pass_fds=[descriptor])
    print("held", flush=True)
    time.sleep(60)
""".replace(
    "INNER",
    "import sys, time, pathlib; from pipeline.kernel import lock; "
    "lock.take(pathlib.Path(sys.argv[1]), print); print('inner', flush=True); time.sleep(3)",
)


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Callable[..., subprocess.Popen[str]]]:
    """Start processes that hold a lock; they are ended with the test."""
    started: list[subprocess.Popen[str]] = []

    def begin(*words: str) -> subprocess.Popen[str]:
        environment = os.environ | {"PYTHONPATH": str(Path(lock.__file__).parents[2])}
        command = [sys.executable, "-c", HOLDER, str(tmp_path), *words]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment)
        assert process.stdout is not None
        while process.stdout.readline() != "held\n":
            assert process.poll() is None
        started.append(process)
        return process

    yield begin
    for process in started:
        process.kill()
        process.wait()
        if process.stdout is not None:
            process.stdout.close()


def _end_soon(process: subprocess.Popen[str]) -> None:
    # The lock is being waited for by then.
    threading.Timer(1.0, process.kill).start()


def test_a_second_run_waits_and_says_for_whom(start: Callable[..., subprocess.Popen[str]], tmp_path: Path) -> None:
    holder = start("held")
    _end_soon(holder)
    said: list[str] = []
    with lock.held(tmp_path, said.append):
        assert holder.wait() == -signal.SIGKILL
    assert len(said) == 1
    when = re.escape(time.strftime("%Y-%m-%d"))
    assert re.search(rf"in use by process {holder.pid} on \S+ since {when} .*waiting until it ends", said[0])


def test_jobs_that_outlive_their_run_are_waited_for(
    start: Callable[..., subprocess.Popen[str]], tmp_path: Path
) -> None:
    job = start("at_work")
    _end_soon(job)
    said: list[str] = []
    with lock.held(tmp_path, said.append):
        assert job.wait() == -signal.SIGKILL
    assert len(said) == 1
    assert "still at work" in said[0]
    assert str(job.pid) in said[0]


def test_a_run_does_not_wait_for_its_own_jobs(tmp_path: Path) -> None:
    with lock.held(tmp_path, pytest.fail), lock.at_work(tmp_path), lock.at_work(tmp_path):
        pass


def test_the_same_process_holds_it_once(tmp_path: Path) -> None:
    with lock.held(tmp_path, pytest.fail):
        with lock.held(tmp_path, pytest.fail):
            pass
        descriptor = lock.take(tmp_path, pytest.fail)
        assert lock.take(tmp_path, pytest.fail) == descriptor
    with lock.held(tmp_path, pytest.fail):
        pass


def test_handed_on_it_outlives_the_first_holder(start: Callable[..., subprocess.Popen[str]], tmp_path: Path) -> None:
    holder = start("held", "hand")
    assert holder.stdout is not None
    assert holder.stdout.readline() == "inner\n", "no dead-lock between the two"
    holder.kill()
    holder.wait()
    said: list[str] = []
    began = time.monotonic()
    with lock.held(tmp_path, said.append):
        assert time.monotonic() > began
    assert len(said) == 1
    assert f"process {holder.pid} " not in said[0], "the one that holds it now is named"


def test_a_lock_whose_file_was_removed_is_taken_anew(tmp_path: Path) -> None:
    with lock.held(tmp_path, pytest.fail):
        (tmp_path / lock.RUN).unlink()
    with lock.held(tmp_path, pytest.fail):
        assert (tmp_path / lock.RUN).is_file()


def test_a_foreign_descriptor_is_not_believed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    other = os.open(tmp_path / "other", os.O_RDWR | os.O_CREAT)
    try:
        monkeypatch.setenv(lock.HANDED_ON, str(other))
        with lock.held(tmp_path, pytest.fail) as descriptor:
            assert descriptor != other
    finally:
        os.close(other)


def test_where_nothing_can_be_written_one_message_says_so(tmp_path: Path) -> None:
    (tmp_path / "results").write_text("")
    with pytest.raises(UserError, match="a file is where a folder belongs"):
        lock.take(tmp_path / "results", pytest.fail)
