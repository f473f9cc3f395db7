"""Places on the command line: no two names for one file, where one would be written over the other."""

from __future__ import annotations

import os
from collections.abc import Mapping

from warpvec.errors import InputError

_IN_PLACE = {("--from", "OUT"), ("--resume", "--checkpoint"), ("--config", "--write-config")}
"""What is read whole before the other is written, and means to be replaced by it."""


def check_places(places: Mapping[str, str | None]) -> None:
    """Check that the files a command reads and writes are different ones.

    Args:
        places: the name on the command line -> the path, None if not given; those that are read come first.

    Raises:
        InputError: two names lead to one file, through symbolic links too.
    """
    names: dict[str, str] = {}
    for name, path in places.items():
        resolved = None if path is None else _resolved(path)
        if resolved is None:
            continue
        other = names.setdefault(resolved, name)
        if other != name and (other, name) not in _IN_PLACE:
            raise InputError(f"{name} must be another file than {other}, got {path!r} for both; choose another name")


def _resolved(path: str) -> str | None:
    """The file that ``path`` leads to; None for a stream, a device, and what can be no file's name."""
    if path == "-":
        return None
    try:
        resolved = os.path.normcase(os.path.realpath(path))
        return None if os.path.exists(resolved) and not os.path.isfile(resolved) else resolved
    except (OSError, ValueError):  # which is told where the file is opened
        return None
