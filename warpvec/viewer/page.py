"""One HTML file to look at a drawing, compare it with its photo, and edit it: nothing in it loads or runs but its own.

The page's scripts and styles are in ``warpvec/viewer/assets``; they are written into the file, and a content security policy
allows these alone, by their hashes. The SVG goes in as a string of JSON, reduced to known elements and attributes;
of these the page's reader takes numbers, colours and names, and never shows an element itself.
"""

from __future__ import annotations

import base64
import hashlib
import json
import math
import os
from html import escape
from importlib.resources import files
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from warpvec import __version__
from warpvec.errors import InputError
from warpvec.files import check_writable, write_atomic
from warpvec.image.read import read_image
from warpvec.image.resize import reduce_image
from warpvec.image.write import to_8_bits
from warpvec.svg.measure import file_facts, measure
from warpvec.svg.sanitize import sanitized
from warpvec.svg.scan import read_text

PAGE_PHOTO_SIDE = 2048
"""Longest side in pixels of the photo in the page: enough for a screen, and the page measures in milliseconds."""

HISTORY_KEYS = ("iteration", "curves", "psnr", "seconds")

# In the order in which they are joined: what is used while the page starts stands before its use.
_SCRIPTS = (
    "paths", "pen", "basics", "read", "save", "raster", "measure", "history", "edit", "brush", "gesture", "stage",
    "tools", "app", "charts", "levels", "panel", "keys", "main",
)  # fmt: skip


def write_report(
    path: str | os.PathLike[str],
    svg: bytes,
    *,
    photo: bytes | None = None,
    background: str | None = None,
    history: list[dict[str, float]] | None = None,
    name: str | None = None,
) -> None:
    """Writes the page of a drawing to ``path``, whole or not at all.

    Args:
        path: the HTML file.
        svg: bytes of an ``.svg`` or ``.svgz`` file, warpvec's own or another.
        photo: bytes of the image file that it was made from; without it nothing is compared.
        background: colour behind a transparent photo; None keeps it transparent.
        history: records of the fit as `warpvec.Result.history` gives them; without them there is no convergence plot.
            An infinite PSNR, or None for it, has no place there.
        name: what the page calls the drawing and the file that it saves; the name of ``path`` if not given.

    Raises:
        InputError: the SVG is none, is refused as unsafe (see `warpvec.svg.measure.draw`) or has not the photo's
            proportions; the photo cannot be read; a record of ``history`` is not one; ``path`` cannot be written.
    """
    check_writable(path, "path")
    records = _checked_history(history or [])
    pixels = None if photo is None else read_image(photo, background, name="photo")
    data = {"name": name or Path(path).stem, "history": records, **_data(svg, pixels)}
    write_atomic(path, _page(data).encode())


def _data(svg: bytes, pixels: NDArray[np.float32] | None) -> dict[str, Any]:
    """What the page is told of the file, as JSON can say it; an infinite PSNR is null."""
    figures: dict[str, Any] = {**file_facts(svg)}
    data: dict[str, Any] = {"figures": figures, "svg": sanitized(read_text(svg))}
    if pixels is not None:
        quality = measure(svg, pixels)
        figures |= {key: value if math.isfinite(value) else None for key, value in quality.items()}
        data["photo"] = _data_url(reduce_image(pixels, PAGE_PHOTO_SIDE))
    return data


def _checked_history(history: object) -> list[dict[str, float]]:
    """The known numbers of each record that has a finite PSNR."""
    if not isinstance(history, list) or not all(isinstance(record, dict) for record in history):
        raise InputError("history must be a list of records, got something else; see warpvec.Result.history")
    records = [{key: record.get(key) for key in HISTORY_KEYS} for record in history]
    for record in records:
        for key, value in record.items():
            if key == "psnr" and value in (None, math.inf):
                continue
            if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
                raise InputError(f"history must have a finite {key} in each record, got {value!r}; write it again")
    return [record for record in records if record["psnr"] not in (None, math.inf)]


def _data_url(pixels: NDArray[np.float32]) -> str:
    """``pixels`` [h, w, 3 or 4] in [0, 1] as an 8 bit PNG in a URL: without the photo's metadata, upright, in sRGB."""
    stream = BytesIO()
    Image.fromarray(to_8_bits(pixels)).save(stream, "PNG")
    return "data:image/png;base64," + base64.b64encode(stream.getvalue()).decode()


def _page(data: dict[str, Any]) -> str:
    style = _page_file("page.css")
    modules = "\n".join(_page_file(f"{name}.js") for name in _SCRIPTS)
    script = f'(() => {{\n"use strict";\n{modules}}})();\n'
    # In a script element only "<" can end the text, or begin a comment.
    told = json.dumps(data, allow_nan=False).replace("<", "\\u003c")
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{_policy(script, style)}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="generator" content="warpvec {__version__}">
<title>{escape(data["name"])} - warpvec</title>
<style>{style}</style>
</head>
<body>
{_page_file("page.html")}<script type="application/json" id="data">{told}</script>
<script>{script}</script>
</body>
</html>
"""


def _policy(script: str, style: str) -> str:
    """No network, no frames, no forms, and no script or style but these two."""
    allowed = [f"{kind}-src '{_hash(text)}'" for kind, text in (("script", script), ("style", style))]
    return "; ".join(["default-src 'none'", *allowed, "img-src data:", "base-uri 'none'", "form-action 'none'"])


def _hash(text: str) -> str:
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()


def _page_file(name: str) -> str:
    return (files("warpvec.viewer") / "assets" / name).read_text(encoding="utf-8")
