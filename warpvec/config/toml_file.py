"""Settings in a TOML file, by the names that the options and the keywords of `warpvec.vectorize` have."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Collection
from pathlib import Path
from typing import Any

from warpvec.errors import InputError
from warpvec.files import check_writable, write_atomic


def read_settings(path: str, known: Collection[str]) -> dict[str, str]:
    """The settings in the file ``path`` as the command line would have them; a name may have hyphens, as there.

    Raises:
        InputError: the file cannot be read, is not TOML, or has a name that is not ``known``.
    """
    try:
        found = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:  # TOML and Unicode errors are ValueErrors
        raise InputError(f"--config must be a TOML file, got {path!r} ({error}); check it") from error
    settings = {name.replace("-", "_"): value for name, value in found.items()}
    for name, value in settings.items():
        if name not in known:
            raise InputError(f"{name} in {path!r} must be an option of this command by its name; see --help for these")
        if not isinstance(value, bool | int | float | str):
            raise InputError(f"{name} in {path!r} must be a number, a text, true or false, got {value!r}; give one")
    return {name: str(value) for name, value in settings.items()}


def write_settings(path: str, settings: dict[str, Any]) -> None:
    """Writes ``settings``, numbers, texts and flags, whole or not at all.

    Raises:
        InputError: ``path`` cannot be written.
    """
    check_writable(path, "--write-config")
    # TOML's texts, numbers and flags are JSON's.
    lines = [f"{name} = {json.dumps(value)}" for name, value in settings.items()]
    write_atomic(path, ("\n".join(["# Settings of warpvec", *lines]) + "\n").encode())
