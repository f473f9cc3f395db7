"""The document of ``warpvec app``: the page of ``warpvec view`` with the panel that makes drawings.

Its scripts are those of the viewer, which leave ``window.warpvecView`` behind, and then its own, which work with that.
"""

from __future__ import annotations

import base64
import hashlib
from importlib.resources import files

from warpvec import __version__
from warpvec.viewer import page as viewer

# In the order in which they are joined.
_SCRIPTS = ("server", "parts", "settings", "picture", "queue", "saving", "again", "sheet", "desk")


def page_text() -> tuple[str, str]:
    """Return the HTML of the page and its content security policy.

    The policy allows these scripts and styles by their hashes, images that the page makes, and requests to the server.
    """
    style = viewer.style() + _asset("desk.css")
    scripts = [viewer.script(), _own_script()]
    text = f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="generator" content="warpvec {__version__}">
<title>warpvec</title>
<link rel="icon" href="data:,">
<style>{style}</style>
</head>
<body class="desk">
{_asset("desk.html")}{viewer.markup()}
<script type="application/json" id="data">{viewer.embedded_data({"name": "warpvec"})}</script>
{"".join(f"<script>{script}</script>" for script in scripts)}
</body>
</html>
"""
    return text, _policy(scripts, style)


def _own_script() -> str:
    modules = "\n".join(_asset(f"{name}.js") for name in _SCRIPTS)
    return f'(() => {{\n"use strict";\n{modules}}})();\n'


def _policy(scripts: list[str], style: str) -> str:
    allowed = " ".join(f"'{_hash(script)}'" for script in scripts)
    rules = [
        "default-src 'none'",
        f"script-src {allowed}",
        f"style-src '{_hash(style)}'",
        "img-src 'self' data: blob:",
        "connect-src 'self'",
        "base-uri 'none'",
        "form-action 'none'",
        "frame-ancestors 'none'",
    ]
    return "; ".join(rules)


def _hash(text: str) -> str:
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()


def _asset(name: str) -> str:
    return (files("warpvec.app") / "assets" / name).read_text(encoding="utf-8")
