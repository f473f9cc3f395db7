"""Things that the two extensions have in common."""

from __future__ import annotations

import os
import signal
import sys
import tempfile
from typing import Any

import inkex
from warpvec_refusal import Refusal


class WarpvecEffect(inkex.EffectExtension):  # type: ignore[misc] # inkex has no types
    """An effect that works in a temporary folder. If it refuses, Inkscape shows why, and the document stays."""

    def effect(self) -> None:
        """Do the work."""
        signal.signal(signal.SIGTERM, _leave)
        try:
            with tempfile.TemporaryDirectory(prefix="warpvec-") as folder:
                self.work(folder)
        except Refusal as refusal:
            raise inkex.AbortExtension(str(refusal)) from None

    def link_folders(self) -> list[str]:
        """Return the folders that links to files may be relative to.

        Inkscape gives a copy of the document, with links relative to that copy.
        """
        return [os.path.dirname(self.options.input_file), self.svg_path() or ""]

    def work(self, folder: str) -> None:
        """Change ``self.svg``; files may be made in ``folder``."""
        raise NotImplementedError


def _leave(*_: object) -> None:
    """End with the folder removed, and warpvec ended."""
    sys.exit(1)


def read_drawing(path: str) -> Any:
    """Return the root of an SVG file as inkex has it."""
    with open(path, "rb") as file:
        return inkex.load_svg(file.read()).getroot()


def unused_id(svg: Any, name: str) -> str:
    """Return an id that nothing in the document has: ``name``, or with a number after it."""
    used = {element.get("id") for element in svg.iter()}
    number = 1
    while (found := name if number == 1 else f"{name}-{number}") in used:
        number += 1
    return found
