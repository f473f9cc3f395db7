"""Folders that a batch reads and writes: on this machine, or on any file system that fsspec can open.

File names are relative to their folder, with "/" between the parts.
"""

from __future__ import annotations

import errno
import os
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cached_property
from io import UnsupportedOperation
from pathlib import Path
from typing import Any

from warpvec.errors import InputError
from warpvec.files import make_folder, naming_errors, write_atomic
from warpvec.inputs import read_stream, too_long
from warpvec.temporary_files import lock_file, remove_stale_files

MAX_FILE_BYTES = 2**31
"""Largest file that is read unless another limit is given, above the records of a million photos."""

_ROOM_BYTES = 2**16
"""What a disk must have room for before photos are drawn: a drawing of a photo takes about so much."""

_LASTING_ERRORS = (FileNotFoundError, PermissionError, IsADirectoryError, NotADirectoryError)
_LASTING_NUMBERS = (errno.ELOOP, errno.ENAMETOOLONG)
"""Errors of a file that another attempt would not mend; ELOOP is that of links that lead to each other."""


class LocalFolder:
    """A folder on this machine. Errors other than InputError may be temporary."""

    can_append = True
    """Whether :meth:`append` works; object stores have no such operation."""

    def __init__(self, path: str | os.PathLike[str], name: str = "IN_DIR") -> None:
        # Absolute, because a worker of a cluster has another current folder.
        self._path, self._given, self._name = Path(os.path.abspath(path)), os.fspath(path), name

    def names(self, recursive: bool) -> list[str]:
        """Return the names of the files, sorted; those in its folders too if ``recursive``.

        Files and folders whose name begins with a dot are left out.

        Raises:
            InputError: there is no such folder.
        """
        if not os.path.isdir(self._path):  # unlike pathlib, it takes a name that is too long
            raise InputError(self._name, "must be a folder", repr(self._given), "check the path")
        found = []
        for folder, folders, files in os.walk(self._path):
            folders[:] = [each for each in folders if recursive and not each.startswith(".")]
            shown = (each for each in files if not each.startswith("."))
            found += [(Path(folder) / each).relative_to(self._path).as_posix() for each in shown]
        return sorted(found)

    def exists(self, name: str) -> bool:
        """Return whether there is a file ``name``."""
        return os.path.isfile(self._path / name)  # unlike pathlib, it takes a name that is too long

    def size(self, name: str) -> int:
        """Return the number of bytes of the file ``name``; 0 if it is not known."""
        try:
            return os.stat(self._path / name).st_size
        except OSError:
            return 0

    def read(self, name: str, limit: int = MAX_FILE_BYTES) -> bytes:
        """Return the bytes of the file ``name``.

        Raises:
            InputError: it does not exist, may not be read, or has more than ``limit`` bytes.
        """
        path = self._path / name
        with _as_input_error(name):
            # A pipe would wait for ever, and a device may have no end.
            if not stat.S_ISREG(path.stat().st_mode):
                raise InputError(name, "must be a file you may read", "a pipe, a device or a folder", "remove it")
            with path.open("rb") as stream:
                return read_stream(stream, limit, name, "it")

    def write(self, name: str, data: bytes) -> None:
        """Write the file ``name``, whole or not at all, and create the folders it is in.

        Raises:
            InputError: no file of that name may be written.
        """
        path = self._writable(name)
        with _as_input_error(name, "write"):
            path.parent.mkdir(parents=True, exist_ok=True)
            write_atomic(path, data)

    def append(self, name: str, data: bytes) -> None:
        """Append ``data`` to a file in one write, which is on the disk when this returns."""
        path = self._writable(name)
        with naming_errors(path), path.open("ab", buffering=0) as file:
            file.write(data)
            os.fsync(file.fileno())

    def _writable(self, name: str) -> Path:
        path = self._path / name
        if os.path.isdir(path):
            raise InputError(self._name, "must let a file be written", f"a folder named {name!r}", "move it away")
        return path

    @contextmanager
    def lock(self) -> Iterator[None]:
        """Create the folder, and keep other batches out of it in this block.

        Raises:
            InputError: it cannot be created or written, or another process has locked it.
        """
        make_folder(self._path, self._name, self._given)
        handle = os.open(self._path, os.O_RDONLY)
        try:
            if lock_file(handle) is False:  # the folder itself, which leaves no file
                value = f"{self._given!r}, which is in use"
                remedy = "wait for the other batch, or choose another folder"
                raise InputError(self._name, "must be written by one batch at a time", value, remedy)
            yield
        finally:
            os.close(handle)
            remove_stale_files(self._path)  # of workers that were killed while they wrote

    def check_room(self) -> None:
        """Raise an `InputError` if the disk is full, before anything is drawn."""
        try:
            with tempfile.TemporaryFile(dir=self._path) as file:
                file.write(bytes(_ROOM_BYTES))
        except OSError as error:
            value = f"{self._given!r} ({error.strerror})"
            raise InputError(
                self._name, "must have room for drawings", value, "choose another, or free space"
            ) from None


class RemoteFolder:
    """A folder at an address with "://", on a file system that fsspec can open; its methods are as in `LocalFolder`."""

    can_append = False

    def __init__(self, address: str, name: str = "IN_DIR") -> None:
        self._address, self._name = address.rstrip("/"), name
        self._root  # noqa: B018 - report a missing library before any work

    def __getstate__(self) -> dict[str, Any]:
        # Each process makes its own connection.
        return {"_address": self._address, "_name": self._name}

    @cached_property
    def _root(self) -> tuple[Any, str]:
        """Return the file system and the path in it."""
        try:
            from fsspec.core import url_to_fs
        except ImportError:
            rule, remedy = "must be a path unless fsspec is installed", "pip install 'warpvec[cluster]'"
            raise InputError(self._name, rule, repr(self._address), remedy) from None
        try:
            system, path = url_to_fs(self._address)
        except (ImportError, ValueError) as error:
            rule = "must be an address that fsspec can open"
            raise InputError(self._name, rule, f"{self._address!r} ({error})", "check the address") from error
        return system, path.rstrip("/")

    def check_room(self) -> None:
        """Do nothing: such systems do not tell."""

    def _path(self, name: str) -> str:
        return f"{self._root[1]}/{name}"

    def names(self, recursive: bool) -> list[str]:
        """Return the names of the files, with those of inner folders if ``recursive``."""
        system, root = self._root
        if not system.isdir(root):
            raise InputError(self._name, "must be a folder", repr(self._address), "check the address")
        paths = system.find(root, maxdepth=None if recursive else 1)
        names = (path.removeprefix(root).lstrip("/") for path in paths)
        return sorted(name for name in names if not any(part.startswith(".") for part in name.split("/")))

    def exists(self, name: str) -> bool:
        """Return whether there is a file ``name``."""
        return bool(self._root[0].isfile(self._path(name)))

    def size(self, name: str) -> int:
        """Return 0: a store would be asked for each file."""
        return 0

    def read(self, name: str, limit: int = MAX_FILE_BYTES) -> bytes:
        """Return the bytes of the file ``name``."""
        system, path = self._root[0], self._path(name)
        with _as_input_error(name):
            if (system.size(path) or 0) > limit:  # None if the store does not tell
                raise too_long(limit, name, "it")
            data: bytes = system.cat_file(path)
            return data

    def write(self, name: str, data: bytes) -> None:
        """Write the file ``name``, whole or not at all."""
        system, path = self._root[0], self._path(name)
        with suppress(NotImplementedError):  # raised by a store that has no folders
            system.makedirs(path.rpartition("/")[0], exist_ok=True)
        # On file systems that show unfinished files, a transaction writes another file and moves it.
        with system.transaction, system.open(path, "wb") as file:
            file.write(data)

    def append(self, name: str, data: bytes) -> None:
        """Raise UnsupportedOperation: stores write files whole."""
        raise UnsupportedOperation(f"files in {self._address} can only be written whole")

    @contextmanager
    def lock(self) -> Iterator[None]:
        """Do nothing: stores have no locks."""
        yield


Folder = LocalFolder | RemoteFolder
"""A folder that can be pickled."""


def open_folder(address: str, name: str) -> Folder:
    """Return the folder at ``address``: a path, or an address such as s3://bucket/photos; messages call it ``name``.

    Raises:
        InputError: the address is empty, or the library that reads such addresses is not installed.
    """
    if not address:  # pathlib would take this for the current folder
        raise InputError(name, "must be a folder", "''", "give . for the current one")
    return RemoteFolder(address, name) if "://" in address else LocalFolder(address, name)


@contextmanager
def _as_input_error(name: str, verb: str = "read") -> Iterator[None]:
    """Turn errors that another attempt would not mend into an InputError."""
    try:
        yield
    except OSError as error:
        if not isinstance(error, _LASTING_ERRORS) and error.errno not in _LASTING_NUMBERS:
            raise
        raise InputError(name, f"must be a file you may {verb}", str(error.strerror or error), "check it") from error
