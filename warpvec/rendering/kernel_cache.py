"""The folder in which Warp keeps compiled kernels, and a temporary one where that cannot be written."""

from __future__ import annotations

import atexit
import os
import shutil
import tempfile
from contextlib import suppress
from pathlib import Path

import warp as wp

_ROOM_BYTES = 2**20
"""What the folder must have room for: more than the largest compiled kernel."""


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
    """Make a folder for this process and those it starts, with the kernels that ``folder`` has; return the message.

    There is no message if there were kernels: then somebody has compiled them for a place that nobody writes to.
    """
    base = tempfile.mkdtemp(prefix="warpvec-kernels-")
    atexit.register(_remove, base, os.getpid())
    os.environ["WARP_CACHE_PATH"] = wp.config.kernel_cache_dir = base
    wp.init()  # it has failed, or has been done with the other folder
    temporary = Path(base) / str(wp.config.version)  # as Warp names it
    temporary.mkdir(exist_ok=True)
    wp.config.kernel_cache_dir = str(temporary)
    if _link_kernels(folder, temporary):
        return None
    return (
        f"warpvec: the folder for compiled kernels, {str(folder)!r}, cannot be written ({reason}), so this run compiles"
        " its own; set WARP_CACHE_PATH to another folder"
    )


def _link_kernels(folder: Path, temporary: Path) -> bool:
    """Link the compiled kernels of ``folder`` in ``temporary``; return whether there are any."""
    with suppress(OSError):  # the folder cannot be read, or the system has no links
        for module in folder.glob("wp_*"):
            (temporary / module.name).symlink_to(module)
    return any(temporary.iterdir())


def _remove(folder: str, process: int) -> None:
    if process == os.getpid():  # a forked process still needs it
        shutil.rmtree(folder, ignore_errors=True)
