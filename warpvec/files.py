"""Write result files: check before the fit that they can be written, then write them completely or not at all."""

from __future__ import annotations

import errno
import gzip
import os
import zlib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from warpvec.errors import InputError
from warpvec.temporary_files import open_temporary_file, temporary_file

GZIP_LEVEL = 9
"""The slowest level: at these file sizes it takes milliseconds, and a file is written once and read often."""

GZIP_COMMAND_MEMORY = 9
"""zlib's memory level with which it finds the same blocks as the command gzip; it usually takes 8."""


def check_writable(path: str | os.PathLike[str], name: str) -> None:
    """Check that `write_atomic` can write ``path``, before work is spent on its contents.

    Args:
        path: file to be written; it need not exist.
        name: the caller's name for the argument, for the message.

    Raises:
        InputError: the path is a folder or not a valid file name, its folder is missing or is a file, or there is no
            permission to write it, or the system makes no files there.
    """
    target, given = _resolved(path, name), repr(os.fspath(path))
    folder = target.parent
    if target.is_dir() or os.fspath(path).endswith(("/", os.sep)):
        raise InputError(name, "must name a file", f"the folder {given}", "add a file name to it")
    if not folder.exists():
        raise InputError(name, "must be in an existing folder", given, f"create {str(folder)!r} first")
    if not folder.is_dir():
        raise InputError(name, "must be in a folder", given, f"choose another, as {str(folder)!r} is a file")
    _check_permission(target, name)


def make_folder(path: str | os.PathLike[str], name: str, given: str | None = None) -> None:
    """Make the folder ``path`` and its parents if they do not exist.

    Args:
        path: folder to make.
        name: the caller's name for the argument, for the message.
        given: the argument's value, if ``path`` was derived from it.

    Raises:
        InputError: the folder cannot be made, or there is no permission to write to it.
    """
    given = os.fspath(path) if given is None else given
    try:
        Path(path).mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        rule = "must be a folder or a name for one"
        raise InputError(name, rule, f"{given!r} ({reason})", "choose another") from error
    if not os.access(path, os.W_OK | os.X_OK):
        raise InputError(name, "must be a folder you may write to", repr(given), "choose another")


def write_atomic(path: str | os.PathLike[str], data: bytes) -> None:
    """Write ``data`` to ``path`` such that a reader finds either the old file or the complete new one.

    The data go to a temporary file in the same folder, which then replaces the file; on failure it is removed. A
    symbolic link is kept and its target is replaced. The new file's mode follows the umask. A device or a pipe is
    written in place, because a rename would replace the device itself.

    Raises:
        OSError: the file cannot be written; the error has the name ``path``.
    """
    target = Path(os.path.realpath(path))
    with naming_errors(path):
        if target.exists() and not target.is_file():
            target.write_bytes(data)
            return
        with temporary_file(target) as temporary:
            _write_through(temporary, data)
            os.replace(temporary, target)


@contextmanager
def naming_errors(name: str | os.PathLike[str]) -> Iterator[None]:
    """Give each OSError inside of the context the file's ``name``, which errors of writing do not have."""
    try:
        yield
    except OSError as error:
        if error.errno is None:
            raise
        raise OSError(error.errno, error.strerror, os.fspath(name)) from error


def is_full(error: OSError) -> bool:
    """Return whether ``error`` means that the disk, or the user's share of it, is full."""
    return error.errno in (errno.ENOSPC, errno.EDQUOT)


def gzip_bytes(data: bytes) -> bytes:
    """Return ``data`` gzipped without a time stamp, so that equal data give equal bytes."""
    return gzip.compress(data, GZIP_LEVEL, mtime=0)


def gzip_count(data: bytes) -> int:
    """Return the bytes of ``data`` gzipped at the highest level: the more of `gzip_bytes` and of the command gzip.

    They differ by up to 0.2 %. The name that the command stores unless it is told ``-n`` does not count.
    """
    packer = zlib.compressobj(GZIP_LEVEL, zlib.DEFLATED, zlib.MAX_WBITS | 16, GZIP_COMMAND_MEMORY)
    return max(len(gzip_bytes(data)), len(packer.compress(data)) + len(packer.flush()))


def text_bytes(text: str, *, gzip: bool = False) -> int:
    """Return the bytes of ``text``, after gzip if asked."""
    data = text.encode()
    return gzip_count(data) if gzip else len(data)


def _write_through(path: Path, data: bytes) -> None:
    """Fill an empty file and flush it to the disk, so that a power cut cannot leave the rename without the data."""
    with open_temporary_file(path) as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())


def _resolved(path: str | os.PathLike[str], name: str) -> Path:
    """Follow symbolic links of ``path``, and raise InputError if the system does not accept it as a file name."""
    try:
        target = Path(os.path.realpath(path))
        with suppress(FileNotFoundError, NotADirectoryError):
            os.lstat(target)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise InputError(name, "must be a valid file name", f"{str(path)!r} ({reason})", "choose another") from None
    return target


def _check_permission(target: Path, name: str) -> None:
    if target.exists() and not os.access(target, os.W_OK):
        raise InputError(name, "must be writable", f"the write-protected file {str(target)!r}", "choose another name")
    if target.exists() and not target.is_file():
        return
    if not os.access(target.parent, os.W_OK | os.X_OK):
        raise InputError(name, "must be in a folder you may write to", repr(str(target)), "choose another folder")
    try:
        with temporary_file(target) as temporary, open_temporary_file(temporary) as file:
            file.write(b"0")
    except OSError as error:  # such as in /proc, where root has every permission
        if is_full(error):
            return  # there may be space by the end of the fit
        rule, found = "must be in a folder where files can be made", f"{str(target)!r} ({error.strerror})"
        raise InputError(name, rule, found, "choose another folder") from None
