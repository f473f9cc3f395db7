"""The document of ``warpvec app``: the page of ``warpvec view`` with the panel that makes drawings.

See `warpvec/viewer/README.md`.
"""

from __future__ import annotations

import secrets

from warpvec import __version__
from warpvec.app.controls import controls_data, controls_markup
from warpvec.app.uses import uses_markup
from warpvec.image.formats import SUFFIXES
from warpvec.viewer import page as viewer
from warpvec.viewer.modules import asset, module_scripts, module_texts
from warpvec.writers.png import SIDE_MAX

NONCE_BYTES = 18
"""Random bytes of the nonce of a server's page."""


def page_text(key: str) -> tuple[str, str]:
    """Return the HTML of the page and its content security policy; ``key`` is that of `warpvec.app.identity`.

    The policy allows scripts with a nonce, this style, images that the page makes, and requests to the server.
    """
    style = asset("viewer", "page.css") + asset("app", "desk.css")
    nonce = secrets.token_urlsafe(NONCE_BYTES)
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
<body class="desk" data-photo-side="{viewer.PAGE_PHOTO_SIDE}" data-key="{key}">
{_panel()}{asset("viewer", "page.html")}
<script type="application/json" id="controls">{controls_data()}</script>
<script type="application/json" id="data">{viewer.embedded_data({"name": "warpvec"})}</script>
{module_scripts("app/main.js", nonce, module_texts("viewer", "app"))}
</body>
</html>
"""
    rules = viewer.policy(nonce, style, images="'self' data: blob:")
    return text, f"{rules}; connect-src 'self'; frame-ancestors 'none'"


def _panel() -> str:
    """Return the elements of the panel that makes drawings."""
    panel = asset("app", "desk.html").replace("<!-- controls -->", controls_markup())
    panel = panel.replace("<!-- purposes -->", uses_markup()).replace("<!-- suffixes -->", ",".join(SUFFIXES))
    return panel.replace("<!-- widest png -->", str(SIDE_MAX))
