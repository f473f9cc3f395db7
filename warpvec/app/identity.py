"""The secrets of a server: a token for each start, and a proof to open pages that it is theirs.

The first part of every path is the token. It is new whenever the server starts: after the end of the server another
program may listen at its port, and a page that asks it anything tells it the token.

The server and its pages share a key, which neither ever sends after the page was loaded. A page that has lost its
server asks for a proof first: the server signs a random text of the page and the name of its start (HMAC-SHA256). From
this name and the key the page computes the new token. The key is kept for a day in a file that only the user can read.
"""

from __future__ import annotations

import hmac
import os
import re
import secrets
import stat
import tempfile
import time
from contextlib import suppress
from pathlib import Path

from warpvec.app.address import private_folder

KEY_BYTES = 32
"""Random bytes of a key, those of SHA-256."""

KEY_SECONDS = 86_400.0
"""Time for which a key is used again: a working day and a night."""

TOKEN_DIGITS = 32
"""Hexadecimal digits of a token: 128 bits cannot be guessed."""

PROOF_PATH = "/proof"
"""Where pages ask for a proof, outside of the token."""

_KEY = re.compile(f"[0-9a-f]{{{2 * KEY_BYTES}}}")
_NONCE = re.compile("[0-9a-f]{32}")


class Identity:
    """The secrets of one start of the server.

    Args:
        key: hexadecimal digits that the server and its pages share.
    """

    def __init__(self, key: str) -> None:
        self.key = key
        self._start = secrets.token_hex(16)
        self.token = self._signed(f"token {self._start}")[:TOKEN_DIGITS]
        """First part of every path."""

    def proof(self, host: str, nonce: str) -> dict[str, str] | None:
        """Return the name of this start, and the signature that a page at ``host`` expects; None for no ``nonce``."""
        if not _NONCE.fullmatch(nonce):
            return None
        return {"start": self._start, "proof": self._signed(f"proof {host} {nonce} {self._start}")}

    def _signed(self, text: str) -> str:
        return hmac.digest(bytes.fromhex(self.key), text.encode(), "sha256").hex()


def read_key(port: int) -> str:
    """Return the key of the last server on ``port`` if it is young enough, else a new one, which is kept if possible.

    A file that another user may have written or read is not trusted.
    """
    path = private_folder() / f"key-{port}"
    known = _kept_key(path)
    if known is not None:
        return known
    key = secrets.token_hex(KEY_BYTES)
    with suppress(OSError):
        _keep(path, key)
    return key


def _kept_key(path: Path) -> str | None:
    with suppress(OSError, ValueError):
        facts = path.lstat()
        is_private = stat.S_ISREG(facts.st_mode) and not facts.st_mode & 0o077
        is_own = not hasattr(os, "geteuid") or facts.st_uid == os.geteuid()
        if os.name == "posix" and not (is_private and is_own):
            return None
        key = path.read_text(encoding="ascii").strip()
        age = time.time() - facts.st_mtime
        if 0 <= age < KEY_SECONDS and _KEY.fullmatch(key):
            return key
    return None


def _keep(path: Path, key: str) -> None:
    """Write the key into a new file that only the user can read, and put it in the place of the old one."""
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=".key-")  # with mode 600
    try:
        with os.fdopen(handle, "w", encoding="ascii") as file:
            file.write(key)
        os.replace(name, path)
    except OSError:
        os.unlink(name)
        raise
