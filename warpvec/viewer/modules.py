"""The scripts of a page: ES modules, written into the page itself.

Every file ``NAME.js`` in the assets of a room is the module "ROOM/NAME.js", which other modules import by this name.
The page holds a map from these names to ``data:`` URLs of the texts, so that it loads nothing and works as a file.

Content security policies refuse such modules unless they have the nonce of the policy. Modules that a script imports
have the nonce of the script.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from importlib.resources import files
from urllib.parse import quote

_KEPT = " !\"$&'()*+,/:;<=>?@[\\]^`{|}"
"""Characters that a data: URL may hold as they are, besides letters and digits: all but control characters, % and #."""


def asset(room: str, name: str) -> str:
    """Return the text of the file ``name`` in the assets of ``room``."""
    return (files(f"warpvec.{room}") / "assets" / name).read_text(encoding="utf-8")


def module_texts(*rooms: str) -> dict[str, str]:
    """Return the text of every module of ``rooms`` by its name."""
    found: dict[str, str] = {}
    for room in rooms:
        assets = files(f"warpvec.{room}") / "assets"
        paths = sorted((path for path in assets.iterdir() if path.name.endswith(".js")), key=lambda path: path.name)
        found |= {f"{room}/{path.name}": path.read_text(encoding="utf-8") for path in paths}
    return found


def module_scripts(entry: str, nonce: str, texts: Mapping[str, str]) -> str:
    """Return the script elements that run the module ``entry``, which may import the modules of ``texts``.

    Args:
        entry: name of a module.
        nonce: that of the policy of the page.
        texts: module name -> its text.
    """
    urls = {name: f"data:text/javascript,{quote(text, safe=_KEPT)}" for name, text in texts.items()}
    # In a script element only "<" can end the text or start a comment.
    table = json.dumps({"imports": urls}).replace("<", "\\u003c")
    return (
        f'<script type="importmap" nonce="{nonce}">{table}</script>\n'
        f'<script type="module" nonce="{nonce}">import "{entry}";</script>'
    )
