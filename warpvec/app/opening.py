"""Open the page in the default browser.

All users of the machine can read the arguments of a program. So the browser gets the name of a file that only this user
can read, and the file leads to the page.
"""

from __future__ import annotations

import html
import os
import threading
import webbrowser
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from warpvec.app.address import private_folder
from warpvec.temporary_files import open_temporary_file, temporary_file

TEXT_BROWSERS = ("www-browser", "lynx", "links", "elinks", "w3m")
"""Browsers that run in the terminal: `webbrowser` starts them if there are no others."""

_FILE = """<!DOCTYPE html>
<meta charset="utf-8">
<meta name="referrer" content="no-referrer">
<meta http-equiv="refresh" content="0; url={address}">
<title>warpvec</title>
"""


@contextmanager
def leading_file(address: str) -> Iterator[str]:
    """Yield the URL of a file that leads a browser to ``address``, and remove it at the end.

    Raises:
        OSError: the file cannot be written.
    """
    home = Path.home()
    # Browsers that are snaps, as on Ubuntu, see only files of the home folder that are not hidden.
    has_snaps = (home / "snap").is_dir()
    folder = home if has_snaps else private_folder()
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    with temporary_file(folder / "page", ".html", mode=0o600, is_hidden=not has_snaps) as path:
        with open_temporary_file(path) as file:
            file.write(_FILE.format(address=html.escape(address)).encode())
        yield path.absolute().as_uri()


def has_browser() -> bool:
    """Return whether the default browser can show the page: there is one, and it does not run in the terminal."""
    try:
        name = getattr(webbrowser.get(), "name", "")
    except webbrowser.Error:
        return False
    return os.path.basename(name) not in TEXT_BROWSERS


def open_browser(address: str) -> None:
    """Open the default browser. Some end with their command: a thread of its own waits for that."""
    threading.Thread(target=webbrowser.open, args=(address,), daemon=True).start()
