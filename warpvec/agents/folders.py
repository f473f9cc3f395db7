"""The folders whose files the tools may read and write. Nothing else can be reached, through links neither."""

from __future__ import annotations

import errno
import os
from collections.abc import Sequence
from pathlib import Path

from warpvec.errors import InputError


class Folders:
    """Folders that were named when the server was started.

    Raises:
        InputError: one is no folder.
    """

    def __init__(self, folders: Sequence[str]) -> None:
        for folder in folders:
            if not (folder and os.path.isdir(folder)):
                raise InputError("FOLDER", "must be an existing folder", repr(folder), "create it first")
        self.roots = tuple(Path(folder).resolve() for folder in folders)

    def file(self, path: str, name: str) -> Path:
        """Return the file at ``path``, with its links followed. A relative path begins in the first folder.

        Raises:
            InputError: it is in none of the folders; ``name`` is for the message.
        """
        try:
            found = (self.roots[0] / path).resolve()
            found.exists()
        except (OSError, RuntimeError, ValueError) as error:  # too long, a loop of links, or a zero byte
            found = None
            if isinstance(error, OSError) and error.errno == errno.ENAMETOOLONG:
                raise InputError(name, "must be a valid file name", repr(path), "choose a shorter one") from None
        if found is None or not any(found.is_relative_to(root) for root in self.roots) or found in self.roots:
            listed = ", ".join(map(str, self.roots))
            raise InputError(name, f"must be a file in {listed}", repr(path), "choose a path in there")
        return found

    def source(self, path: str, name: str) -> Path:
        """Return the file at ``path`` to read: no pipe or device, which may never end.

        Raises:
            InputError: as `file`; or it is of such a kind.
        """
        found = self.file(path, name)
        if found.exists() and not (found.is_file() or found.is_dir()):
            raise InputError(name, "must be a file, not a pipe or device", repr(path), "save it as a file first")
        return found

    def new_file(self, path: str, name: str, *, overwrite: bool) -> Path:
        """Return the file at ``path`` to write to.

        Raises:
            InputError: it is in none of the folders; or it is there, and ``overwrite`` is false.
        """
        found = self.file(path, name)
        if not found.parent.is_dir():
            raise InputError(name, "must be in an existing folder", repr(path), "create it first")
        if found.exists() and not overwrite:
            raise InputError(name, "must not exist", repr(path), "choose another name, or set overwrite")
        return found
