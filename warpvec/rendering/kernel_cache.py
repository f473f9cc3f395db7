"""The folder in which Warp keeps compiled kernels, or a temporary folder if Warp's folder cannot be written."""

from __future__ import annotations

import atexit
import logging
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import warp as wp

from warpvec.errors import InputError
from warpvec.rendering.locked_folders import make_locked_folder

_ROOM_BYTES = 2**20
"""What the folder must have room for: more than the largest compiled kernel."""

_PREFIX = "warpvec-kernels-"

_HEADERS_PREFIX = "warpvec-headers-"


def init_warp() -> str | None:
    """Initialise Warp; return a message if its kernels have to be kept in a temporary folder."""
    message = None
    try:
        with _absolute_cache():
            wp.init()
        _check_room(Path(wp.config.kernel_cache_dir or "."))
    except OSError as error:
        message = _use_temporary_folder(Path(wp.config.kernel_cache_dir or "."), error.strerror or str(error))
    _keep_headers()
    return message


@contextmanager
def _absolute_cache() -> Iterator[None]:
    """Take an empty or relative XDG_CACHE_HOME for none in this block, as its specification wants.

    Warp would make its folder in the current one.
    """
    name = "XDG_CACHE_HOME"
    given = os.environ.get(name)
    if given is None or os.path.isabs(given):
        yield
        return
    del os.environ[name]
    try:
        yield
    finally:
        os.environ[name] = given


def _check_room(folder: Path) -> None:
    with tempfile.TemporaryFile(dir=folder, buffering=0) as file:
        if (written := file.write(bytes(_ROOM_BYTES))) < _ROOM_BYTES:
            file.write(bytes(_ROOM_BYTES - written))  # which says why


def _use_temporary_folder(folder: Path, reason: str) -> str | None:
    """Make a folder with the kernels of ``folder`` for this process and its children; return the message.

    There is no message if ``folder`` has kernels: somebody has compiled them for a place that cannot be written. If the
    kernels are of another version, the message comes at the end. They are used where they are if there is no place for
    another folder.

    Raises:
        InputError: there is no such place, and ``folder`` has no kernels.
    """
    try:
        base = make_locked_folder(_PREFIX)
    except OSError as error:
        if _kernels_in(folder):
            return None
        rule = "must name a folder for compiled kernels that can be written, as there is none for temporary files"
        value = f"{str(folder)!r} ({reason})"
        raise InputError("WARP_CACHE_PATH", rule, value, "set it to another folder") from error
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


class _HeaderFolders(dict[int, Any]):
    """Where each thread keeps the headers that Warp compiles first, in place of the folders that Warp makes.

    Warp's own folders stay when a signal ends the process, and need a folder for temporary files.
    """

    def __contains__(self, thread: object) -> bool:
        """Make the folder of ``thread`` if it has none: Warp looks here before it makes one."""
        if not super().__contains__(thread):
            self[thread] = SimpleNamespace(name=_make_header_folder())  # type: ignore[index]
        return True


def _make_header_folder() -> str:
    try:
        return make_locked_folder(_HEADERS_PREFIX)
    except OSError:
        return make_locked_folder(_HEADERS_PREFIX, wp.config.kernel_cache_dir)


def _keep_headers() -> None:
    """Let Warp keep its headers in folders of this program, unless it is a version that keeps them otherwise."""
    runtime: Any = wp._src.context.runtime
    if isinstance(getattr(runtime, "_pch_dirs", None), dict):
        runtime._pch_dirs = _HeaderFolders(runtime._pch_dirs)


def _link_kernels(folder: Path, temporary: Path) -> bool:
    """Link the compiled kernels of ``folder`` in ``temporary``; return whether there are any."""
    with suppress(OSError):  # the system has no links
        for module in _kernels_in(folder):
            (temporary / module.name).symlink_to(module)
    return any(temporary.iterdir())


def _kernels_in(folder: Path) -> list[Path]:
    """Return the folders of compiled kernels in ``folder``; none if it cannot be read."""
    try:
        return list(folder.glob("wp_*"))
    except OSError:
        return []


def _say_if_compiled(folder: Path, process: int, message: str) -> None:
    if process == os.getpid() and any(not module.is_symlink() for module in folder.glob("wp_*")):
        logging.getLogger("warpvec").warning("%s", message)
