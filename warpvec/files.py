"""Writing the result: found impossible before the fit, whole or not at all after it."""

from __future__ import annotations

import gzip
import os
import secrets
from contextlib import suppress
from pathlib import Path

from warpvec.errors import InputError

GZIP_LEVEL = 9
"""A file is written once and read often; at these sizes the slowest level takes milliseconds."""


def check_writable(path: str | os.PathLike[str], name: str) -> None:
    """Check that `write_atomic` can write ``path``, before work is spent on what goes there.

    Args:
        path: the file to be written; it need not exist.
        name: what the caller calls the argument, for the message.

    Raises:
        InputError: the path is a folder or no possible file name, its folder is missing or is a file, or it is
            not allowed to be written.
    """
    target = _resolved(path, name)
    folder = target.parent
    if target.is_dir() or os.fspath(path).endswith(("/", os.sep)):
        raise InputError(f"{name} must name a file, got the folder {os.fspath(path)!r}; add a file name to it")
    if not folder.exists():
        raise InputError(f"{name} must be in an existing folder, got {os.fspath(path)!r}; create {str(folder)!r} first")
    if not folder.is_dir():
        raise InputError(f"{name} must be in a folder, got {os.fspath(path)!r}; {str(folder)!r} is a file")
    _check_permission(target, name)


def make_folder(path: str | os.PathLike[str], name: str, given: str | None = None) -> None:
    """Makes the folder ``path``, and those it is in, where it is not there yet.

    Args:
        name: what the caller calls the argument, for the message.
        given: what it was given, where ``path`` was made of that.

    Raises:
        InputError: the folder cannot be made, or may not be written to.
    """
    given = os.fspath(path) if given is None else given
    try:
        Path(path).mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        rule = f"{name} must be a folder or a name for one, got {given!r} ({reason})"
        raise InputError(f"{rule}; choose another") from error
    if not os.access(path, os.W_OK | os.X_OK):
        raise InputError(f"{name} must be a folder you may write to, got {given!r}; choose another")


def write_atomic(path: str | os.PathLike[str], data: bytes) -> None:
    """Write ``data`` to ``path`` so that any reader finds the old file or the whole new one.

    A temporary file in the same folder takes the data, then its place; on failure it is removed. A symbolic link
    stays and its target is replaced. The new file's mode follows the umask. What is no regular file (a device, a
    pipe) is written in place, since a rename would replace the device itself.

    Raises:
        OSError: the file cannot be written.
    """
    target = Path(os.path.realpath(path))
    if target.exists() and not target.is_file():
        target.write_bytes(data)
        return
    temporary = target.with_name(f".warpvec-{secrets.token_hex(8)}.tmp")
    try:
        _write_through(temporary, data)
        os.replace(temporary, target)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def encode_svg(text: str, path: str | os.PathLike[str]) -> bytes:
    """The bytes of a file ``path`` that holds the SVG ``text``: gzipped if its name ends in ``.svgz``."""
    data = text.encode()
    return gzip_bytes(data) if Path(path).suffix.lower() == ".svgz" else data


def gzip_bytes(data: bytes) -> bytes:
    """``data`` gzipped without a time stamp: equal data give equal bytes."""
    return gzip.compress(data, GZIP_LEVEL, mtime=0)


def _write_through(path: Path, data: bytes) -> None:
    """Write a new file down to the disk, so that no rename after it can come first in a power cut."""
    with path.open("xb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())


def _resolved(path: str | os.PathLike[str], name: str) -> Path:
    """Where ``path`` leads through symbolic links; asking the system also tells whether such a name can be."""
    try:
        target = Path(os.path.realpath(path))
        with suppress(FileNotFoundError, NotADirectoryError):
            os.lstat(target)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise InputError(f"{name} must be a possible file name, got {str(path)!r}: {reason}; choose another") from None
    return target


def _check_permission(target: Path, name: str) -> None:
    if target.exists() and not os.access(target, os.W_OK):
        raise InputError(f"{name} must be writable, got the write-protected file {str(target)!r}; choose another name")
    if (target.is_file() or not target.exists()) and not os.access(target.parent, os.W_OK | os.X_OK):
        raise InputError(f"{name} must be in a folder you may write to, got {str(target)!r}; choose another folder")
