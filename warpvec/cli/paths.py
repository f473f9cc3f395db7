"""Check that no two arguments of the command line name the same file, which would be overwritten."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from warpvec.errors import InputError

_IN_PLACE = {("--from", "OUT"), ("--resume", "--checkpoint"), ("--config", "--write-config")}
"""Pairs that may be one file: the first is read completely before the second replaces it."""


def check_distinct_files(paths: Mapping[str, str | None]) -> None:
    """Check that the files a command reads and writes are different ones.

    Args:
        paths: name on the command line -> path, None if not given; the files that are read come first.

    Raises:
        InputError: two names lead to one file, perhaps through symbolic links, or one file would be a folder for
            another.
    """
    names: dict[str, str] = {}
    for name, path in paths.items():
        resolved = None if path is None else _resolved(path)
        if resolved is None:
            continue
        other = names.setdefault(resolved, name)
        if other != name and (other, name) not in _IN_PLACE:
            raise InputError(name, f"must be another file than {other}", f"{path!r} for both", "choose another name")
    for inner, name in names.items():
        for outer in (names[folder] for folder in map(str, Path(inner).parents) if folder in names):
            found = f"{paths[name]!r} inside of {paths[outer]!r}"
            raise InputError(name, f"must not be inside of {outer}, which is a file", found, "choose another name")


def _resolved(path: str) -> str | None:
    """Return the file that ``path`` leads to; None for a stream, a device or an impossible name."""
    if path == "-":
        return None
    try:
        resolved = os.path.normcase(os.path.realpath(path))
        return None if os.path.exists(resolved) and not os.path.isfile(resolved) else resolved
    except (OSError, ValueError):  # reported where the file is opened
        return None
