"""Temporary folders that last as long as this process, and the removal of those that killed processes have left.

A folder is locked (flock) until its process and all that were forked from it have ended, however they end.
"""

from __future__ import annotations

import atexit
import os
import shutil
import stat
import tempfile
import time
from contextlib import ExitStack, suppress
from functools import partial
from pathlib import Path

from warpvec.temporary_files import at_abrupt_end, lock_file

_LOCKED_AFTER = 60.0
"""Age in seconds at which a temporary folder without a lock has no process, which takes the lock right at the start."""

_ATTEMPTS = 3
"""Times that a folder is removed: a thread that compiles may put a file into it meanwhile."""

# Removes the folders when a signal ends this process; it lasts as long as the process.
_removal = ExitStack()


def make_locked_folder(prefix: str, parent: str | None = None) -> str:
    """Make a folder that is removed at the end of this process, and remove those of this ``prefix`` without a process.

    Args:
        prefix: the beginning of its name; only folders of this program begin like this.
        parent: the folder to make it in; the one for temporary files if None.

    Raises:
        OSError: it cannot be made.
    """
    made = tempfile.mkdtemp(prefix=prefix, dir=parent)
    _lock(made)
    atexit.register(_remove, made, os.getpid())
    _removal.enter_context(at_abrupt_end(partial(_remove, made, os.getpid())))
    for other in Path(made).parent.glob(f"{prefix}*"):
        with suppress(OSError):
            _remove_if_dead(other)
    return made


def _remove_if_dead(folder: Path) -> None:
    facts = folder.lstat()
    is_own = stat.S_ISDIR(facts.st_mode) and hasattr(os, "geteuid") and facts.st_uid == os.geteuid()
    if is_own and time.time() - facts.st_mtime > _LOCKED_AFTER and (handle := _lock(folder)) is not None:
        shutil.rmtree(folder, ignore_errors=True)
        os.close(handle)


def _lock(folder: str | Path) -> int | None:
    """Return an open handle that locks ``folder``; None if another has the lock or the system has no such locks."""
    if os.name == "nt":  # it opens no folders
        return None
    handle = os.open(folder, os.O_RDONLY | os.O_NOFOLLOW)
    if lock_file(handle):
        return handle
    os.close(handle)
    return None


def _remove(folder: str, process: int) -> None:
    if process != os.getpid():  # a forked process still needs it
        return
    for _ in range(_ATTEMPTS):
        shutil.rmtree(folder, ignore_errors=True)
        if not os.path.exists(folder):
            return
