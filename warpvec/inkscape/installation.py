"""Copy the extension into the folder where Inkscape looks for the user's extensions, and remove it from there."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from warpvec.errors import InputError
from warpvec.files import check_writable, make_folder, write_atomic

FOLDER = "warpvec"
"""Folder of the extension among those of others."""

COMMAND_FILE = "command.json"
"""File with the command that the extension calls; ``extension/warpvec_command.py`` reads it."""

ASK_SECONDS = 20.0
"""Longest time for Inkscape to state its folder. It takes 0.1 s, and some seconds on a cold disk."""

_SOURCES = Path(__file__).parent / "extension"


def install(folder: Path) -> Path:
    """Write the extension into the ``folder`` of extensions, and return its own folder there. It replaces an older one.

    The extension will call this Python with ``-m warpvec``, so it works until this environment is removed.

    Raises:
        InputError: the folder cannot be made or written to.
    """
    target = folder / FOLDER
    make_folder(target, "--folder", os.fspath(folder))
    command = {"command": [os.path.abspath(sys.executable), "-P", "-m", "warpvec"]}
    files = {path.name: path.read_bytes() for path in _source_files()}
    files[COMMAND_FILE] = json.dumps(command).encode() + b"\n"
    for name in files:
        check_writable(target / name, "--folder")
    for name, data in files.items():
        write_atomic(target / name, data)
    return target


def uninstall(folder: Path) -> Path:
    """Remove the extension from the ``folder`` of extensions, and return where it was. Files of others there stay.

    Raises:
        InputError: it is not there.
    """
    target = folder / FOLDER
    if not (target / COMMAND_FILE).is_file():
        remedy = "give the --folder that it was installed in"
        raise InputError("--folder", "must contain the extension", repr(os.fspath(folder)), remedy)
    for name in (COMMAND_FILE, *(path.name for path in _source_files())):
        (target / name).unlink(missing_ok=True)
    shutil.rmtree(target / "__pycache__", ignore_errors=True)
    with suppress(OSError):  # somebody else's files are in it
        target.rmdir()
    return target


def user_folder() -> Path:
    """Return the folder of the user's extensions: where Inkscape says, or where it is by default.

    Raises:
        InputError: Inkscape is not found, and has never been started.
    """
    stated = _ask_inkscape()
    if stated is not None:
        return stated / "extensions"
    folder = default_data_folder(sys.platform, os.environ, Path.home())
    if not folder.is_dir():
        remedy = "give the folder that Inkscape states under Edit > Preferences > System > User extensions"
        raise InputError("--folder", "must be given, because Inkscape was not found", remedy=remedy)
    return folder / "extensions"


def default_data_folder(platform: str, environment: Mapping[str, str], home: Path) -> Path:
    """Return the folder of Inkscape's data of the user ``home``; ``platform`` as in `sys.platform`."""
    if environment.get("INKSCAPE_PROFILE_DIR"):
        return Path(environment["INKSCAPE_PROFILE_DIR"])
    if platform == "win32":
        return Path(environment.get("APPDATA") or home / "AppData" / "Roaming") / "inkscape"
    if platform == "darwin":
        return home / "Library" / "Application Support" / "org.inkscape.Inkscape" / "config" / "inkscape"
    return Path(environment.get("XDG_CONFIG_HOME") or home / ".config") / "inkscape"


def _ask_inkscape() -> Path | None:
    """Return the data folder of the user that Inkscape states; None if there is no Inkscape, or no answer."""
    program = shutil.which("inkscape")
    if program is None:
        return None
    command = [program, "--user-data-directory"]
    with suppress(OSError, subprocess.SubprocessError):
        done = subprocess.run(command, capture_output=True, text=True, timeout=ASK_SECONDS, check=True)
        lines = done.stdout.split("\n")
        if Path(lines[0].strip()).is_absolute():
            return Path(lines[0].strip())
    return None


def _source_files() -> list[Path]:
    return sorted(path for path in _SOURCES.iterdir() if path.suffix in (".py", ".inx"))
