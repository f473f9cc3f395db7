"""Originals of flat art: drawn by resvg at any size, saved as PNG or JPEG, and written anew by svgo."""

from __future__ import annotations

import io
import shlex
import shutil
import subprocess
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from xml.etree import ElementTree

import click
import numpy as np
from flat_counts import Counts, count
from numpy.typing import NDArray
from PIL import Image

from warpvec.svg.measure import draw
from warpvec.svg.units import stated_size

JPEG_QUALITY = 80
SCALE = 4
"""Times the size at which files are compared with the originals: is the curve right, or only its pixels?"""

Pixels = NDArray[np.uint8]


@dataclass(frozen=True)
class Original:
    """An SVG that a designer made."""

    name: str
    text: str

    @cached_property
    def counts(self) -> Counts:
        """What the text of the drawing contains."""
        return count(self.text)

    def extent(self, size: int) -> tuple[int, int]:
        """Return width and height of the drawing whose longest side has ``size`` pixels."""
        width, height = stated_size(ElementTree.fromstring(self.text).attrib)
        longest = max(width, height)
        return max(1, round(size * width / longest)), max(1, round(size * height / longest))

    def drawn(self, size: int, scale: int = 1, transparent: bool = False) -> Pixels:
        """Draw it at ``scale`` times the pixels of ``size``, over white [h, w, 3] or with straight alpha [h, w, 4]."""
        width, height = (scale * side for side in self.extent(size))
        return draw(stretched(self.text, width, height), width, height, transparent=transparent)

    def save(self, folder: Path, size: int, as_jpeg: bool) -> Path:
        """Save the drawing as a PNG, with alpha where it is not opaque, or as a JPEG over white."""
        path = folder / f"{self.name}-{size}.{'jpg' if as_jpeg else 'png'}"
        if as_jpeg:
            Image.fromarray(self.drawn(size)).save(path, quality=JPEG_QUALITY)
            return path
        pixels = self.drawn(size, transparent=True)
        Image.fromarray(pixels if (pixels[..., 3] < 255).any() else pixels[..., :3].copy()).save(path)
        return path


def find_originals(folder: Path, names: list[str]) -> list[Original]:
    """Return the SVGs of ``folder``, or those of them that ``names`` names, sorted by name.

    Raises:
        click.UsageError: there are none.
    """
    paths = [path for path in sorted(folder.glob("*.svg")) if not names or path.stem in names]
    if not paths:
        raise click.UsageError(f"FOLDER must hold SVGs of these names, but {folder} holds none")
    return [Original(path.stem, path.read_text()) for path in paths]


def stretched(svg: str, width: int, height: int) -> str:
    """Return ``svg`` with a size of exactly ``width`` x ``height``.

    Sides that are rounded to pixels have other proportions than the drawing. It then fills them at each scale alike.
    """
    root = ElementTree.fromstring(svg)
    if "viewBox" not in root.attrib:
        own_width, own_height = stated_size(root.attrib)
        root.set("viewBox", f"0 0 {own_width:g} {own_height:g}")
    root.attrib.update(width=str(width), height=str(height), preserveAspectRatio="none")
    ElementTree.register_namespace("", "http://www.w3.org/2000/svg")
    text = io.StringIO()
    ElementTree.ElementTree(root).write(text, encoding="unicode")
    return text.getvalue()


class Svgo:
    """The command ``svgo``, or the reason why it is not there."""

    def __init__(self, command: str) -> None:
        self._command = shlex.split(command)
        found = bool(self._command) and shutil.which(self._command[0]) is not None
        self.reason = "" if found else f"svgo: skipped, no command {command!r} (npm install svgo; --svgo CMD)"
        self._known: dict[str, int | None] = {}

    def byte_count(self, svg: str) -> int | None:
        """Return the bytes of ``svg`` as svgo writes it; None without svgo, or if svgo refuses it."""
        if self.reason:
            return None
        if svg not in self._known:
            done = subprocess.run([*self._command, "-i", "-", "-o", "-"], input=svg.encode(), capture_output=True)
            self._known[svg] = None if done.returncode else len(done.stdout)
        return self._known[svg]
