"""The messages between the server and its worker process."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from warpvec.app.settings import FitSettings


@dataclass(frozen=True)
class FitJob:
    """A fit to do.

    Attributes:
        number: identifies the job in messages about it.
        data: bytes of the picture's file.
        name: title of the drawing.
        settings: what the page asks for.
        start: SVG text to go on from; None to begin from nothing.
        before: SVG text of ``start`` before the user edited it, without the deleted shapes; None if that is unknown.
        locked: places of paths in ``start`` that keep their form and paint.
        erased: SVG text whose shapes are taken out of the picture before the fit; None for none.
        filled: those of them that new paths of a photo are to fill; None for none.
        keeps_paths: fit the paths of ``start`` again, and add none but those.
        cuts: take the overlaps out of ``start``, and change nothing else.
        done_share: share of a whole fit that ``start`` has had, from 0 to 1.
    """

    number: int
    data: bytes = field(repr=False)
    name: str
    settings: FitSettings
    start: str | None = field(default=None, repr=False)
    before: str | None = field(default=None, repr=False)
    locked: tuple[int, ...] = ()
    erased: str | None = field(default=None, repr=False)
    filled: str | None = field(default=None, repr=False)
    keeps_paths: bool = False
    cuts: bool = False
    done_share: float = 0.0


@dataclass(frozen=True)
class Stop:
    """End the job ``number`` early. Its best drawing so far is the result, or there is none if it ``is_dropped``."""

    number: int
    is_dropped: bool = False


@dataclass(frozen=True)
class Report:
    """News of the worker: of the job ``number``, or of itself if that is 0.

    ``kind`` is "ready" (the kernels are loaded), "mode" (the mode found), "stage" (what is done now, and how long that
    may take), "frame" (the present drawing), "done" or "failed". ``facts`` go to the page as they are.
    """

    kind: str
    number: int
    facts: dict[str, Any] = field(default_factory=dict)
