"""Temporary files beside the files that they replace, and the removal of those that dead processes have left.

A writer locks its temporary file (flock). The system releases the lock when the process ends, however it ends, so a
temporary file without a lock has no writer. Process ids would say less: numbers are used again, and two containers
have processes of the same number. All processes on one running kernel see each other's locks, and the name of the file
tells the kernel. Files of other kernels (of another machine on a network share, or from before a restart) and files
where the system has no locks are removed after a day.

Linux can also write a file without a name (O_TMPFILE), of which a killed process leaves nothing. That alone does not
do: a file needs a name before it can replace another, the encoders of videos write to names, and network file systems
have no such files.
"""

from __future__ import annotations

import os
import re
import stat
import threading
import time
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

_SAFE_AGE = 24 * 3600.0
"""Age in seconds at which a file is stale although its lock says nothing: no writer pauses for a day."""

_SWEEP_SECONDS = 0.5
"""Longest time to look for stale files: enough for 100,000 files on a local disk. A run does not wait longer."""

_SWEEP_PAUSE = 600.0
"""Time in seconds between two looks for stale files in one folder."""

_LAST_WAIT = 1.0
"""Longest time in seconds that an ending process waits for a file that is being created. A network may be gone."""

_NAME = re.compile(r"\.?warpvec-(?P<kernel>[0-9a-f]{8})-[0-9a-f]{16}\.tmp(\.[a-z0-9]{1,5})?")

# Temporary files that this process has created and not yet removed, and the handles that hold their locks.
_live: dict[Path, int | None] = {}

# Folder -> time (monotonic) at which this process last swept it.
_swept: dict[Path, float] = {}

# What else a process does before it ends without a word to Python.
_last_steps: list[Callable[[], None]] = []

# Held while a file is created, and for ever by a process that is about to end.
_creating = threading.Lock()


@contextmanager
def temporary_file(target: Path, suffix: str = "", *, mode: int = 0o666, is_hidden: bool = True) -> Iterator[Path]:
    """Yield the path of an empty file in the folder of ``target``, and remove it at the end unless it was moved.

    The first call for a folder in `_SWEEP_PAUSE` also removes the stale temporary files in it.

    Args:
        target: the file that the temporary one is to replace, with `os.replace`.
        suffix: end of the name, such as ".mp4", for writers that choose the format by it.
        mode: who may read and write the file, as far as the umask allows it.
        is_hidden: whether the name begins with a dot.

    Raises:
        OSError: the file cannot be created.
    """
    _sweep_at_times(target.parent)
    file = _TemporaryFile(target.parent, suffix, mode, "." if is_hidden else "")
    try:
        while not file.is_created():
            file.remove()
        yield file.path
    finally:
        file.remove()


def open_temporary_file(path: Path) -> BinaryIO:
    """Open a file that `temporary_file` has yielded for writing.

    It is the same open file that holds the lock: Windows shares refuse to write a locked file through another one.

    Raises:
        OSError: it cannot be opened.
    """
    handle = _live[path]
    return open(path, "r+b") if handle is None else os.fdopen(os.dup(handle), "r+b")


def _sweep_at_times(folder: Path) -> None:
    """Remove stale files from ``folder`` unless that was done less than ``_SWEEP_PAUSE`` ago."""
    now = time.monotonic()
    for other, swept in list(_swept.items()):
        if now - swept > _SWEEP_PAUSE:
            _swept.pop(other, None)
    if folder not in _swept:
        _swept[folder] = now
        remove_stale_files(folder)


def remove_stale_files(folder: Path) -> None:
    """Remove the temporary files of dead processes from ``folder``, as far as that is possible and quick."""
    end = time.monotonic() + _SWEEP_SECONDS
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            if (found := _NAME.fullmatch(entry.name)) is not None:
                with suppress(OSError):
                    _remove_if_stale(entry.path, is_of_this_kernel=found["kernel"] == _KERNEL)
            if time.monotonic() > end:
                return


def remove_live_files() -> None:
    """Remove the temporary files of this process, and let it create no others: it is about to end."""
    _creating.acquire(timeout=_LAST_WAIT)
    for step in list(_last_steps):
        with suppress(OSError):
            step()
    for path in list(_live):
        with suppress(OSError):
            path.unlink()


@contextmanager
def at_abrupt_end(step: Callable[[], None]) -> Iterator[None]:
    """Let `remove_live_files` also call ``step`` while this block lasts. It may do so from another thread."""
    _last_steps.append(step)
    try:
        yield
    finally:
        _last_steps.remove(step)


class _TemporaryFile:
    """A file with a name of its own, locked while it exists."""

    def __init__(self, folder: Path, suffix: str, mode: int, dot: str) -> None:
        self._folder, self._suffix, self._mode, self._dot = folder, suffix, mode, dot
        self._handle: int | None = None
        self._choose_name()

    def is_created(self) -> bool:
        """Create the file; return False if another process removed it before it was locked."""
        self._choose_name()
        with _creating:
            _live[self.path] = None
            self._handle = os.open(self.path, os.O_RDWR | os.O_CREAT | os.O_EXCL, self._mode)
            _live[self.path] = self._handle
        if fcntl is None:  # Windows cannot move a file that is open
            self._close()
            _live[self.path] = None
            return True
        has_lock = lock_file(self._handle)
        return has_lock is None or (has_lock and os.fstat(self._handle).st_nlink > 0)

    def remove(self) -> None:
        """Remove the file if it has not been moved, and release the lock."""
        with suppress(OSError):
            self.path.unlink()
        self._close()
        _live.pop(self.path, None)

    def _choose_name(self) -> None:
        self.path = self._folder / f"{self._dot}warpvec-{_KERNEL}-{os.urandom(8).hex()}.tmp{self._suffix}"

    def _close(self) -> None:
        handle, self._handle = self._handle, None
        if handle is not None:
            os.close(handle)


def _remove_if_stale(path: str, *, is_of_this_kernel: bool) -> None:
    """Remove ``path`` if it is a regular file of this user and its writer is dead; raise OSError if that fails."""
    facts = os.lstat(path)
    if not _is_own_file(facts):
        return
    is_old = time.time() - facts.st_mtime > _SAFE_AGE
    if fcntl is None:  # Windows cannot remove a file that is open
        if is_old:
            os.unlink(path)
        return
    # Network file systems want a file open for writing before they lock it. A link or a pipe that has taken the place
    # of the file meanwhile is neither followed nor waited for.
    handle = os.open(path, os.O_RDWR | os.O_NOFOLLOW | os.O_NONBLOCK)
    try:
        has_lock = lock_file(handle)
        is_stale = is_old if has_lock is None else has_lock and (is_of_this_kernel or is_old)
        if is_stale and _is_own_file(os.fstat(handle)):
            os.unlink(path)
    finally:
        os.close(handle)


def _is_own_file(facts: os.stat_result) -> bool:
    return stat.S_ISREG(facts.st_mode) and (not hasattr(os, "geteuid") or facts.st_uid == os.geteuid())


def lock_file(handle: int) -> bool | None:
    """Lock an open file; return False if it is locked already, None if the system or the file system has no locks."""
    if fcntl is None:
        return None
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return None
    return True


def _kernel() -> str:
    """Return eight digits that tell the running kernel from others."""
    try:
        name = Path("/proc/sys/kernel/random/boot_id").read_text()
    except OSError:  # not Linux
        name = os.uname().nodename if hasattr(os, "uname") else ""
    return f"{zlib.crc32(name.encode()):08x}"


_KERNEL = _kernel()
