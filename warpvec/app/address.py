"""The address of the server: this machine only, and a port. The folder for its secrets."""

from __future__ import annotations

import os
import socket
from pathlib import Path

from warpvec.errors import InputError

HOST = "127.0.0.1"
"""The only interface: nothing outside of this machine can connect."""

DEFAULT_PORT = 8437
"""The port unless one is given; not in use by any well-known service. A fixed one lets pages find a new server."""


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
