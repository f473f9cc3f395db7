"""The tools: each reads and writes files of the folders, and answers with the figures and a small picture.

Settings are checked as those of the command line, and pictures and SVGs have its limits; what could do harm is drawn in
a process of its own. One fit runs at a time.
"""

from __future__ import annotations

import math
import threading
from base64 import b64encode
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from warpvec.agents.folders import Folders
from warpvec.api import refine, vectorize
from warpvec.errors import InputError
from warpvec.image.read import read_image
from warpvec.inputs import read_file
from warpvec.result import Result
from warpvec.svg.document import MAX_SVG_BYTES, read_text
from warpvec.svg.measure import evaluate
from warpvec.writers.png import drawing_size
from warpvec.writers.registry import check_suffix, encode
from warpvec.writers.writer import Canvas, Target

SECONDS_DEFAULT = 60.0
"""Time for a fit unless the settings give another: programs that call tools often give up after some minutes."""

PREVIEW_SIDE = 256
"""Longest side in pixels of the picture in an answer: it shows what was drawn, and costs a model few tokens."""

_FIGURES = (
    "mode", "mode_reason", "curves", "gradients", "segments", "found", "bytes", "gzip_bytes", "millimeters", "colors",
    "psnr", "ssim", "start_psnr", "unchanged", "seconds", "interrupted",
)  # fmt: skip
"""Figures of `Result.metrics` that an answer has."""


_TAKEN = ("image", "svg", "on_progress")
"""Arguments of `warpvec.vectorize` and `warpvec.refine` that are no settings."""


class Answer:
    """What a tool answers: facts, and a drawing to show."""

    def __init__(self, facts: dict[str, Any], svg: str) -> None:
        self.facts = {name: _finite(value) for name, value in facts.items()}
        self._svg = svg

    def preview(self) -> str:
        """Return a PNG of the drawing in base64; its longest side has at most ``PREVIEW_SIDE`` pixels."""
        across, down = drawing_size(self._svg)
        scale = min(1.0, PREVIEW_SIDE / max(across, down))
        canvas = Canvas(max(1, round(across * scale)), max(1, round(down * scale)))
        return b64encode(encode(self._svg, "preview.png", Target(canvas))).decode()


class Tools:
    """The tools on the files of ``folders``; fits use at most ``threads`` CPU threads, None for all cores."""

    def __init__(self, folders: Folders, threads: int | None = None) -> None:
        self._folders, self._threads, self._turn = folders, threads, threading.Lock()
        self._taken: set[Path] = set()
        self._taking = threading.Lock()

    def vectorize(self, image: str, out: str, settings: dict[str, Any], *, overwrite: bool) -> Answer:
        """Draw the picture ``image`` as the file ``out``.

        Raises:
            InputError: a file is outside of the folders or cannot be used, or a setting is wrong.
        """
        source = self._folders.source(image, "image")
        with self._target(out, overwrite) as target, self._turn:
            return self._saved(vectorize(source, **self._with_usual(settings)), target, overwrite)

    def refine(self, image: str, svg: str, out: str, settings: dict[str, Any], *, overwrite: bool) -> Answer:
        """Fit the drawing ``svg`` to the picture ``image``, as the file ``out``.

        Raises:
            InputError: as `vectorize`.
        """
        source, drawing = self._folders.source(image, "image"), self._folders.source(svg, "svg")
        with self._target(out, overwrite) as target, self._turn:
            return self._saved(refine(source, drawing, **self._with_usual(settings)), target, overwrite)

    def evaluate(self, image: str, svg: str) -> Answer:
        """Measure how well the drawing ``svg`` matches the picture ``image``.

        Raises:
            InputError: a file is outside of the folders or cannot be used.
        """
        pixels = read_image(self._folders.source(image, "image"), name="image")
        data = read_file(self._folders.source(svg, "svg"), MAX_SVG_BYTES, "svg", "an SVG file")
        figures = evaluate(data, pixels)
        facts = {name: figures[name] for name in _FIGURES if name in figures}
        return Answer(facts, read_text(data))

    @contextmanager
    def _target(self, out: str, overwrite: bool) -> Iterator[Path]:
        """Give the file ``out``, which no other call may write meanwhile."""
        target = self._folders.new_file(out, "out", overwrite=overwrite)
        check_suffix(target, "out")
        with self._taking:
            if target in self._taken:
                raise InputError("out", "must not be in use", repr(out), "choose another name, or wait for that call")
            self._taken.add(target)
        try:
            yield target
        finally:
            self._taken.remove(target)

    def _with_usual(self, settings: dict[str, Any]) -> dict[str, Any]:
        for name in _TAKEN:
            if name in settings:
                raise InputError(name, "is not a setting", remedy="leave it out")
        return {"time_budget": SECONDS_DEFAULT, "threads": self._threads, **settings}

    def _saved(self, result: Result, target: Path, overwrite: bool) -> Answer:
        self._folders.new_file(str(target), "out", overwrite=overwrite)  # another program may have made it meanwhile
        losses = result.write(target, "out")
        facts = {name: result.metrics[name] for name in _FIGURES}
        facts |= {"not_kept": list(result.metrics["not_kept"].values()), "losses": losses}
        return Answer({"path": str(target), **facts}, result.drawing.text)


def _finite(value: object) -> object:
    """Return ``value``; None for a number that JSON does not have."""
    return None if isinstance(value, float) and not math.isfinite(value) else value
