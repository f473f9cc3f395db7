"""The folder that the server was started with: its pictures can be opened, and drawings are saved beside them."""

from __future__ import annotations

import os
import re
from contextlib import suppress
from pathlib import Path

from warpvec.errors import InputError
from warpvec.files import write_atomic
from warpvec.image.formats import SUFFIXES
from warpvec.inputs import read_file

LISTED_MAX = 1000
"""Most pictures that are listed, the first ones by name."""

NAME_MAX = 100
"""Longest name of a saved file in bytes, without its suffix: file systems allow 255, or 143 if they encrypt names."""

_UNUSABLE = re.compile(r"[^\w .()+,=@-]+")


def list_pictures(folder: Path) -> list[str]:
    """Return the names of the pictures directly in ``folder``, in order.

    Links that lead out of the folder, and names that are not Unicode, which no page can ask for, are left out.
    """
    with os.scandir(folder) as entries:
        names = [entry.name for entry in entries if entry.name.lower().endswith(SUFFIXES) and _is_inside(entry)]
    return sorted(names)[:LISTED_MAX]


def _is_inside(entry: os.DirEntry[str]) -> bool:
    try:
        entry.name.encode()
        if not entry.is_symlink():
            return entry.is_file()
        target = Path(entry.path).resolve(strict=True)
        return target.is_file() and target.is_relative_to(Path(entry.path).parent.resolve())
    except (OSError, RuntimeError, UnicodeError):  # such as a link to itself
        return False


def read_picture(folder: Path, name: str, limit: int) -> bytes:
    """Return the bytes of a picture that `list_pictures` lists, at most ``limit``.

    Raises:
        InputError: there is no such picture, or it cannot be read, or it is larger.
    """
    if name not in list_pictures(folder):
        raise InputError("picture", "must be in the folder of the server", repr(name), "reload the page")
    return read_file(folder / name, limit, "picture", "an image file")


def save_drawing(folder: Path, name: str, suffix: str, data: bytes) -> str:
    """Write ``data`` to a new file in ``folder`` and return its name; no file is ever replaced.

    Args:
        folder: where to write.
        name: wish for the name without its suffix; what file systems may not like is left out.
        suffix: with its point.

    Raises:
        OSError: the file cannot be written.
    """
    path = _taken_name(folder, usable_name(name), suffix)
    try:
        write_atomic(path, data)
    except OSError:
        with suppress(OSError):
            path.unlink()
        raise
    return path.name


def _taken_name(folder: Path, stem: str, suffix: str) -> Path:
    """Return the path of a new empty file, so that another page that saves at the same time takes another name."""
    path, number = folder / f"{stem}{suffix}", 1
    while True:
        try:
            path.touch(exist_ok=False)
        except FileExistsError:
            number += 1
            path = folder / f"{stem}-{number}{suffix}"
        else:
            return path


def usable_name(name: str) -> str:
    """Return ``name`` without folders, control characters and leading points, and not empty."""
    last = re.split(r"[\\/]", name)[-1]
    kept = _UNUSABLE.sub("_", last).encode("utf-8", "replace")[:NAME_MAX].decode("utf-8", "ignore")
    return kept.strip(". ") or "drawing"
