"""Write one HTML file in which an SVG can be viewed, compared with its image, and edited.

`markup` and `style` are the parts of the page that do not depend on the drawing, unlike `page_data`. The page of
``warpvec app`` is built of them too; `warpvec/viewer/README.md` tells how the pages are put together.

The file loads nothing. Its scripts and styles, from ``warpvec/viewer/assets``, are written into it, and a content
security policy allows only these: the style by its hash, the scripts by a nonce. The SVG is stored as a JSON string,
reduced to known elements and attributes. The page reads only numbers, colours and names from it and never inserts its
elements.
"""

from __future__ import annotations

import base64
import hashlib
import json
import math
import os
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpvec import __version__
from warpvec.errors import InputError
from warpvec.files import check_writable, write_atomic
from warpvec.image.picture import reduce_image
from warpvec.image.read import ImageSource, read_image
from warpvec.image.write import png_bytes, to_8_bits
from warpvec.svg.measure import file_facts, file_quality
from warpvec.svg.sanitize import sanitize
from warpvec.viewer.modules import asset, module_scripts, module_texts

PAGE_PHOTO_SIDE = 2048
"""Longest side of the image in the page in pixels: enough for a screen, and fast to compare with."""

HISTORY_KEYS = ("iteration", "curves", "psnr", "seconds")


def write_page(
    path: str | os.PathLike[str],
    svg: bytes,
    *,
    photo: ImageSource | None = None,
    background: str | None = None,
    history: Sequence[Mapping[str, object]] | None = None,
    name: str | None = None,
    not_kept: Sequence[str] = (),
) -> None:
    """Write the page of an SVG to ``path``, completely or not at all.

    Args:
        path: the HTML file.
        svg: bytes of an ``.svg`` or ``.svgz`` file of any program.
        photo: the image that the SVG was made from, as `read_image` takes it; without it nothing is compared.
        background: colour behind a transparent image; None keeps it transparent.
        history: records of the fit as in `warpvec.Result.history`; without them there is no convergence plot. Records
            with an infinite PSNR, or with None in its place, are not plotted.
        name: title of the page and name of the file that it saves; by default the name of ``path``.
        not_kept: what the drawing could not keep of its picture, in words; see `warpvec.drawing.not_kept`.

    Raises:
        InputError: ``svg`` is not an SVG, is refused as unsafe (see `warpvec.svg.measure.draw`) or does not have the
            proportions of the image; the image cannot be read; ``history`` has another form; ``path`` cannot be
            written.
    """
    check_writable(path, "path")
    records = _checked_history(history or [])
    pixels = None if photo is None else read_image(photo, background, name="photo")
    facts = {"notKept": list(not_kept)}
    data = {"name": name or Path(path).stem, "history": records, "facts": facts, **page_data(svg, pixels)}
    write_atomic(path, _page(data).encode())


def page_data(svg: bytes, pixels: NDArray[np.float32] | None) -> dict[str, Any]:
    """Return "svg", "figures" and, if there are ``pixels``, "photo" of the page, ready for JSON.

    Args:
        svg: bytes of an ``.svg`` or ``.svgz`` file of any program.
        pixels: the image to compare with, [h, w, 3 or 4] in [0, 1]. An infinite PSNR is None.

    Raises:
        InputError: as in `write_page`.
    """
    document, text = sanitize(svg)
    figures: dict[str, Any] = {**file_facts(document)}
    data: dict[str, Any] = {"figures": figures, "svg": text}
    if pixels is not None:
        quality = file_quality(document, pixels)
        figures |= {key: value if math.isfinite(value) else None for key, value in quality.items()}
        data["photo"] = _data_url(reduce_image(pixels, PAGE_PHOTO_SIDE))
    return data


def _checked_history(history: object) -> list[dict[str, float]]:
    """Return the ``HISTORY_KEYS`` of each record that has a finite PSNR."""
    if not isinstance(history, list) or not all(isinstance(record, dict) for record in history):
        found = type(history).__name__
        raise InputError("history", "must be a list of records", found, "use the form of warpvec.Result.history")
    records = [{key: record.get(key) for key in HISTORY_KEYS} for record in history]
    for record in records:
        for key, value in record.items():
            if key == "psnr" and value in (None, math.inf):
                continue
            if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
                raise InputError("history", f"must have a finite {key} in each record", repr(value), "write it again")
    return [record for record in records if record["psnr"] not in (None, math.inf)]


def _data_url(pixels: NDArray[np.float32]) -> str:
    """Return ``pixels`` [h, w, 3 or 4] in [0, 1] as a data URL of an 8-bit PNG, which has no metadata."""
    return "data:image/png;base64," + base64.b64encode(png_bytes(to_8_bits(pixels))).decode()


def _page(data: dict[str, Any]) -> str:
    sheet, embedded = asset("viewer", "page.css"), embedded_data(data)
    # Whoever made the SVG cannot state this nonce in it, as it depends on the whole SVG.
    nonce = hashlib.sha256(embedded.encode()).hexdigest()
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{policy(nonce, sheet)}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="generator" content="warpvec {__version__}">
<title>{escape(data["name"])} - warpvec</title>
<style>{sheet}</style>
</head>
<body>
{asset("viewer", "page.html")}<script type="application/json" id="data">{embedded}</script>
{module_scripts("viewer/main.js", nonce, module_texts("viewer"))}
</body>
</html>
"""


def embedded_data(data: dict[str, Any]) -> str:
    """Return JSON of ``data`` for ``<script type="application/json" id="data">``.

    Args:
        data: "name", and optionally "history", "facts" and what `page_data` returns. Without "svg" the page starts
            empty.
    """
    # In a script element only "<" can end the text or start a comment.
    return json.dumps(data, allow_nan=False).replace("<", "\\u003c")


def policy(nonce: str, style: str, images: str = "data:") -> str:
    """Return the policy: no network, no frames, no forms, and only scripts with the ``nonce`` and this style."""
    allowed = [f"script-src 'nonce-{nonce}'", f"style-src '{_hash_source(style)}'", f"img-src {images}"]
    return "; ".join(["default-src 'none'", *allowed, "base-uri 'none'", "form-action 'none'"])


def _hash_source(text: str) -> str:
    """Return the source of a content security policy that allows an inline style of this text."""
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
