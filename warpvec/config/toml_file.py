"""Settings in a TOML file, under the names of the command line options and of the arguments of `warpvec.vectorize`."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Collection
from typing import Any

from warpvec.errors import InputError
from warpvec.files import check_writable, write_atomic
from warpvec.inputs import read_file

MAX_TOML_BYTES = 2**14
"""Largest file of settings. All settings there are take about 2 kB. The time of Python's reader grows with the square
of a name's dots: 80 kB of them take 23 s."""

_NAME_MAX = 100
"""Most characters of an unknown name in a message."""


def read_settings(path: str, known: Collection[str], flags: Collection[str] = ()) -> dict[str, str]:
    """Return the settings in the file ``path``, values as text as on the command line; names may contain hyphens.

    Args:
        known: names that the file may hold.
        flags: those of them whose value must be true or false.

    Raises:
        InputError: the file cannot be read, is too large, is not TOML, contains a name that is not ``known``, or a
            value of another type.
    """
    try:
        found = tomllib.loads(read_file(path, MAX_TOML_BYTES, "config", "a TOML file").decode())
    except (ValueError, RecursionError) as error:  # TOML and Unicode errors are ValueErrors
        if isinstance(error, InputError):
            raise
        raise InputError("config", "must be a TOML file", f"{path!r} ({error})") from error
    settings = {name.replace("-", "_"): value for name, value in found.items()}
    for name, value in settings.items():
        if name not in known:
            rule = "must be the name of an option of this command"
            shown = f"{name[:_NAME_MAX]}..." if len(name) > _NAME_MAX else name
            raise InputError(f"{shown} in {path!r}", rule, remedy="see --help-all for the names")
        if not isinstance(value, bool | int | float | str):
            rule = "must be a number, a text, true or false"
            raise InputError(f"{name} in {path!r}", rule, repr(value))
        if name in flags and not isinstance(value, bool):
            raise InputError(f"{name} in {path!r}", "must be true or false", repr(value), "write one, without quotes")
    return {name: _text(name, value, path) for name, value in settings.items()}


def _text(name: str, value: bool | int | float | str, path: str) -> str:
    try:
        return str(value)
    except ValueError as error:  # Python writes no number of thousands of digits; a file may have one as 0xfff...
        raise InputError(f"{name} in {path!r}", "must be a number of fewer digits", remedy="give another") from error


def write_settings(path: str, settings: dict[str, Any]) -> None:
    """Write ``settings`` (numbers, texts and flags) to the file ``path``, whole or not at all.

    Raises:
        InputError: ``path`` cannot be written.
    """
    check_writable(path, "write_config")
    # Texts, numbers and flags are written the same way in TOML and in JSON.
    lines = [f"{name} = {json.dumps(value)}" for name, value in settings.items()]
    write_atomic(path, ("\n".join(["# Settings of warpvec", *lines]) + "\n").encode())
