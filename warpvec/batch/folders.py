"""Folders that a batch reads and writes: of this machine, or of any file system that fsspec knows.

Names of files are relative to their folder, with "/" between the parts.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cached_property
from io import UnsupportedOperation
from pathlib import Path
from typing import Any, Protocol

from warpvec.errors import InputError
from warpvec.files import make_folder, write_atomic


class Folder(Protocol):
    """A folder that can be pickled; what it raises beside an InputError may pass, as a lost connection does."""

    appends: bool
    """Whether :meth:`append` can be used; object stores know no such thing."""

    def names(self, recursive: bool) -> list[str]:
        """The files, sorted, those of its folders too if ``recursive``; none whose path has a part with a first dot.

        Raises:
            InputError: there is no such folder.
        """

    def exists(self, name: str) -> bool:
        """Whether there is a file ``name``."""

    def read(self, name: str) -> bytes:
        """The bytes of a file.

        Raises:
            InputError: it is not there, or may not be read.
        """

    def write(self, name: str, data: bytes) -> None:
        """Write a file and the folders it is in, whole or not at all."""

    def append(self, name: str, data: bytes) -> None:
        """Add ``data`` to a file by one write that has reached the disk when this returns."""

    def claim(self) -> Any:
        """Makes the folder, and is a context in which no other process has it.

        Raises:
            InputError: it cannot be made or written, or another process has it.
        """


def open_folder(address: str, name: str) -> Folder:
    """The folder at ``address``: a path, or an address such as s3://bucket/photos; ``name`` is for messages.

    Raises:
        InputError: the address is empty, or what reads such addresses is not installed.
    """
    if not address:  # which pathlib takes for the current folder
        raise InputError(f"{name} must be a folder, got ''; give . for this one")
    return RemoteFolder(address, name) if "://" in address else LocalFolder(address, name)


class LocalFolder:
    """A folder at a path of this machine."""

    appends = True

    def __init__(self, path: str | os.PathLike[str], name: str = "IN_DIR") -> None:
        # Absolute: a worker of a cluster has a current folder of its own.
        self._path, self._given, self._name = Path(os.path.abspath(path)), os.fspath(path), name

    def names(self, recursive: bool) -> list[str]:
        if not self._path.is_dir():
            raise InputError(f"{self._name} must be a folder, got {self._given!r}; check the path")
        found = []
        for folder, folders, files in os.walk(self._path):
            folders[:] = [each for each in folders if recursive and not each.startswith(".")]
            shown = (each for each in files if not each.startswith("."))
            found += [(Path(folder) / each).relative_to(self._path).as_posix() for each in shown]
        return sorted(found)

    def exists(self, name: str) -> bool:
        return (self._path / name).is_file()

    def read(self, name: str) -> bytes:
        with _as_input_error(name):
            return (self._path / name).read_bytes()

    def write(self, name: str, data: bytes) -> None:
        path = self._path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        write_atomic(path, data)

    def append(self, name: str, data: bytes) -> None:
        with (self._path / name).open("ab", buffering=0) as file:
            file.write(data)
            os.fsync(file.fileno())

    @contextmanager
    def claim(self) -> Iterator[None]:
        make_folder(self._path, self._name, self._given)
        handle = os.open(self._path, os.O_RDONLY)
        try:
            self._lock(handle)
            yield
        finally:
            os.close(handle)

    def _lock(self, handle: int) -> None:
        """Held until ``handle`` is closed, be it by the end of the process. The folder itself: it leaves no file."""
        try:
            import fcntl
        except ImportError:  # Windows has no such lock on a folder
            return
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            rule = f"{self._name} must be written by one batch at a time, {self._given!r} is in use"
            raise InputError(f"{rule}; wait for the other, or choose another folder") from None
        except OSError:  # some network file systems have no locks
            return


class RemoteFolder:
    """A folder of a file system that fsspec knows, at an address with "://"."""

    appends = False

    def __init__(self, address: str, name: str = "IN_DIR") -> None:
        self._address, self._name = address.rstrip("/"), name
        self._root  # noqa: B018 - what is missing is said before work is spent

    def __getstate__(self) -> dict[str, Any]:
        # A connection is made where it is used.
        return {"_address": self._address, "_name": self._name}

    @cached_property
    def _root(self) -> tuple[Any, str]:
        """The file system and the path in it."""
        try:
            from fsspec.core import url_to_fs
        except ImportError:
            rule = f"{self._name} must be a path unless fsspec is installed, got {self._address!r}"
            raise InputError(f"{rule}; pip install 'warpvec[cluster]'") from None
        try:
            system, path = url_to_fs(self._address)
        except (ImportError, ValueError) as error:
            rule = f"{self._name} must be an address that fsspec can open, got {self._address!r}"
            raise InputError(f"{rule}; {error}") from error
        return system, path.rstrip("/")

    def _path(self, name: str) -> str:
        return f"{self._root[1]}/{name}"

    def names(self, recursive: bool) -> list[str]:
        system, root = self._root
        if not system.isdir(root):
            raise InputError(f"{self._name} must be a folder, got {self._address!r}; check the address")
        paths = system.find(root, maxdepth=None if recursive else 1)
        names = (path.removeprefix(root).lstrip("/") for path in paths)
        return sorted(name for name in names if not any(part.startswith(".") for part in name.split("/")))

    def exists(self, name: str) -> bool:
        return bool(self._root[0].isfile(self._path(name)))

    def read(self, name: str) -> bytes:
        with _as_input_error(name):
            data: bytes = self._root[0].cat_file(self._path(name))
            return data

    def write(self, name: str, data: bytes) -> None:
        system, path = self._root[0], self._path(name)
        with suppress(NotImplementedError):  # fsspec's word of a store that knows no folders
            system.makedirs(path.rpartition("/")[0], exist_ok=True)
        # Where a file would show before it is whole, a transaction writes it beside and moves it.
        with system.transaction, system.open(path, "wb") as file:
            file.write(data)

    def append(self, name: str, data: bytes) -> None:
        raise UnsupportedOperation(f"{self._address} has files that are written whole")

    @contextmanager
    def claim(self) -> Iterator[None]:
        yield


@contextmanager
def _as_input_error(name: str) -> Iterator[None]:
    """What no second attempt mends."""
    try:
        yield
    except (FileNotFoundError, PermissionError, IsADirectoryError) as error:
        raise InputError(f"{name} must be a file you may read, got {error.strerror or error}; check it") from error
