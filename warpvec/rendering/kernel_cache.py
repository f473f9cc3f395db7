"""The folder in which Warp keeps compiled kernels, or a temporary folder if Warp's folder cannot be written."""

from __future__ import annotations

import atexit
import logging
import os
import shutil
import stat
import tempfile
import time
from contextlib import ExitStack, suppress
from functools import partial
from pathlib import Path

import warp as wp

from warpvec.errors import InputError
from warpvec.temporary_files import at_abrupt_end, lock_file

_ROOM_BYTES = 2**20
"""What the folder must have room for: more than the largest compiled kernel."""

_PREFIX = "warpvec-kernels-"

_LOCKED_AFTER = 60.0
"""Age in seconds at which a temporary folder without a lock has no process, which takes the lock right at the start."""

# Removes the folder when a signal ends this process; it lasts as long as the process.
_removal = ExitStack()


def init_warp() -> str | None:
    """Initialise Warp; return a message if its kernels have to be kept in a temporary folder."""
    try:
        wp.init()
        _check_room(Path(wp.config.kernel_cache_dir or "."))
    except OSError as error:
        return _use_temporary_folder(Path(wp.config.kernel_cache_dir or "."), error.strerror or str(error))
    return None


def _check_room(folder: Path) -> None:
    with tempfile.TemporaryFile(dir=folder, buffering=0) as file:
        if (written := file.write(bytes(_ROOM_BYTES))) < _ROOM_BYTES:
            file.write(bytes(_ROOM_BYTES - written))  # which says why


def _use_temporary_folder(folder: Path, reason: str) -> str | None:
    """Make a folder with the kernels of ``folder`` for this process and its children; return the message.

    There is no message if ``folder`` has kernels: somebody has compiled them for a place that cannot be written. If the
    kernels are of another version, the message comes at the end.
    """
    base = _make_temporary_folder(folder, reason)
    os.environ["WARP_CACHE_PATH"] = wp.config.kernel_cache_dir = base
    wp.init()  # it has failed, or has been done with the other folder
    temporary = Path(base) / str(wp.config.version)  # as Warp names it
    temporary.mkdir(exist_ok=True)
    wp.config.kernel_cache_dir = str(temporary)
    message = (
        f"warpvec: the folder for compiled kernels, {str(folder)!r}, cannot be written ({reason}), so this run compiles"
        " its own; set WARP_CACHE_PATH to another folder"
    )
    if not _link_kernels(folder, temporary):
        return message
    atexit.register(_say_if_compiled, temporary, os.getpid(), message)  # before `_remove`, the last one comes first
    return None


def _make_temporary_folder(folder: Path, reason: str) -> str:
    """Make a folder that is removed at the end of this process, and remove those that killed processes have left.

    Raises:
        InputError: there is no place for it.
    """
    try:
        base = tempfile.mkdtemp(prefix=_PREFIX)
    except OSError as error:
        rule = "must name a folder for compiled kernels that can be written, as there is none for temporary files"
        value = f"{str(folder)!r} ({reason})"
        raise InputError("WARP_CACHE_PATH", rule, value, "set it to another folder") from error
    _lock(base)  # until this process and those that it forks have ended
    atexit.register(_remove, base, os.getpid())
    _removal.enter_context(at_abrupt_end(partial(_remove, base, os.getpid())))
    for other in Path(base).parent.glob(f"{_PREFIX}*"):
        with suppress(OSError):
            _remove_if_dead(other)
    return base


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


def _link_kernels(folder: Path, temporary: Path) -> bool:
    """Link the compiled kernels of ``folder`` in ``temporary``; return whether there are any."""
    with suppress(OSError):  # the folder cannot be read, or the system has no links
        for module in folder.glob("wp_*"):
            (temporary / module.name).symlink_to(module)
    return any(temporary.iterdir())


def _say_if_compiled(folder: Path, process: int, message: str) -> None:
    if process == os.getpid() and any(not module.is_symlink() for module in folder.glob("wp_*")):
        logging.getLogger("warpvec").warning("%s", message)


def _remove(folder: str, process: int) -> None:
    if process == os.getpid():  # a forked process still needs it
        shutil.rmtree(folder, ignore_errors=True)
