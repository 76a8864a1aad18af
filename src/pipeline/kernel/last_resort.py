"""The last resort where something fails that nobody foresaw, and what a person can do about an error of the system.

Also how a command gets to UTF-8, whatever the locale: names of folders and files are the same everywhere.
"""

from __future__ import annotations

import errno
import os
import sys
import tempfile
import time
import traceback
from collections.abc import Iterable
from pathlib import Path

from pipeline.kernel import store
from pipeline.kernel.errors import UserError

# What a person can do about an error of the system; others are left to the log file.
_REMEDIES = {
    errno.ENOSPC: "make room and run again",
    errno.EDQUOT: "make room within the quota and run again",
    errno.EFBIG: "raise the limit of a file's size (ulimit -f) and run again",
    errno.EROFS: "let it be written to, or run in another folder",
    errno.EACCES: "let this user write there, or run in another folder",
    errno.EPERM: "let this user write there, or run in another folder",
    errno.EEXIST: "a file is where a folder belongs: move it away and run again",
    errno.ENOTDIR: "a file is where a folder belongs: move it away and run again",
    errno.EISDIR: "a folder is where a file belongs: move it away and run again",
    errno.ELOOP: "a symbolic link leads in a circle: remove it and run again",
    errno.ENAMETOOLONG: "choose shorter names",
}


def remedy(error: OSError, path: Path | None = None) -> str | None:
    """Return the message for an error of the system that a person can do something about, else None.

    Arguments
    ---------
    path : what was to be written; without, what the error names.
    """
    if error.errno not in _REMEDIES:
        return None
    return f"{path or error.filename or 'a file'}: {error.strerror}; {_REMEDIES[error.errno]}"


def in_utf8() -> None:
    """Start the command of this process anew in Python's UTF-8 mode, unless its names of files are in UTF-8 already."""
    if sys.getfilesystemencoding() == "utf-8" or sys.flags.utf8_mode:
        return
    sys.stdout.flush()
    sys.stderr.flush()
    os.execve(sys.executable, [sys.executable, *sys.orig_argv[1:]], os.environ | {"PYTHONUTF8": "1"})


def refuse_other_bytes(words: Iterable[str]) -> None:
    """Raise `UserError` for a word of the command line that is not UTF-8."""
    for word in words:
        if any("\udc80" <= letter <= "\udcff" for letter in word):
            raise UserError(f"{os.fsencode(word)!r}: not UTF-8; give the words of the command line in UTF-8")


def last_resort(error: Exception, results: Path) -> str:
    """Return one line that says what failed: what a person can do about it, or else which file has the details.

    Arguments
    ---------
    error : being handled; its traceback goes to `results/logs/`, or to the folder of temporary files where nothing
        can be written there.
    """
    if isinstance(error, OSError) and (told := remedy(error)):
        return told
    said = f"{type(error).__name__}: {' '.join(str(error).split())[:300]}"
    name = f"error-{time.strftime('%Y%m%dT%H%M%S')}-{os.getpid()}.log"
    problem = None
    for folder in (results / "logs", Path(tempfile.gettempdir())):
        try:
            store.write_text(folder / name, traceback.format_exc())
        except OSError as hindrance:
            problem = hindrance.strerror
            continue
        return f"{said} (unexpected; details in {folder / name})"
    return f"{said} (unexpected; no log file: {problem})"
