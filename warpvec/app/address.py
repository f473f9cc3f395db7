"""The address of the server: this machine only, a port, and a secret token as the first part of every path.

The token is kept for a day in a file that only the user can read. A server that is started again within that time has
the address of the one before, so that a page that is still open finds it again.
"""

from __future__ import annotations

import os
import re
import secrets
import socket
import stat
import tempfile
import time
from contextlib import suppress
from pathlib import Path

from warpvec.errors import InputError

HOST = "127.0.0.1"
"""The only interface: nothing outside of this machine can connect."""

DEFAULT_PORT = 8437
"""The port unless one is given; not in use by any well-known service. A fixed one lets pages find a new server."""

TOKEN_BYTES = 24
"""Random bytes of a token: 192 bits cannot be guessed."""

TOKEN_SECONDS = 86_400.0
"""Time for which a token is used again: a working day and a night."""

_TOKEN = re.compile(r"[A-Za-z0-9_-]{32}")


def read_token(port: int) -> str:
    """Return the token of the last server on ``port`` if it is young enough, else a new one, which is kept if possible.

    A file that another user may have written or read is not trusted.
    """
    path = private_folder() / f"token-{port}"
    known = _kept_token(path)
    if known is not None:
        return known
    token = secrets.token_urlsafe(TOKEN_BYTES)
    with suppress(OSError):
        _keep(path, token)
    return token


def open_socket(port: int | None) -> socket.socket:
    """Return a socket that listens at ``port`` of this machine; None for the default one, or another if that is taken.

    Raises:
        InputError: the given port cannot be used.
    """
    wanted = DEFAULT_PORT if port is None else port
    try:
        return socket.create_server((HOST, wanted))
    except OSError as error:
        if port is None:
            return socket.create_server((HOST, 0))
        reason = error.strerror or str(error)
        raise InputError("--port", "must be a free port", f"{port} ({reason})", "give another, or none") from error


def private_folder() -> Path:
    """Return the folder for secrets: the user's own one for running programs, or one for their state."""
    runtime, state = os.environ.get("XDG_RUNTIME_DIR"), os.environ.get("XDG_STATE_HOME")
    if runtime:
        return Path(runtime) / "warpvec"
    home = Path(state) if state else Path(os.path.expanduser("~")) / ".local" / "state"
    return home / "warpvec"


def _kept_token(path: Path) -> str | None:
    with suppress(OSError, ValueError):
        facts = path.lstat()
        is_private = stat.S_ISREG(facts.st_mode) and not facts.st_mode & 0o077
        is_own = not hasattr(os, "geteuid") or facts.st_uid == os.geteuid()
        if os.name == "posix" and not (is_private and is_own):
            return None
        token = path.read_text(encoding="ascii").strip()
        age = time.time() - facts.st_mtime
        if 0 <= age < TOKEN_SECONDS and _TOKEN.fullmatch(token):
            return token
    return None


def _keep(path: Path, token: str) -> None:
    """Write the token into a new file that only the user can read, and put it in the place of the old one."""
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=".token-")  # with mode 600
    try:
        with os.fdopen(handle, "w", encoding="ascii") as file:
            file.write(token)
        os.replace(name, path)
    except OSError:
        os.unlink(name)
        raise
