"""A request for a drawing: all that a mode gets."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from warpvec.config.fit_config import FitConfig
from warpvec.drawing.drawing import Drawing
from warpvec.drawing.encoding import Encoding
from warpvec.drawing.file_options import DEFAULT_FILE_OPTIONS, FileOptions
from warpvec.goals.goal import NO_GOAL, Goal
from warpvec.image.picture import Picture
from warpvec.watch.watch import Watch

if TYPE_CHECKING:  # it loads SciPy, which the fit of a photo does not need
    from warpvec.flat.thin_lines.thin_lines import ThinLines


@dataclass(frozen=True, eq=False)
class Request:
    """A request for a drawing.

    Attributes:
        settings: settings of the run.
        goal: requirements on the file; false for none. ``settings.curves`` is then the most that may be used.
        encoding: how the drawing becomes a file.
        watch: progress, stop, clock and history of the run.
        thin_lines: straight thin lines and dots, which the copy of the picture is without; None for none.
    """

    settings: FitConfig
    goal: Goal
    encoding: Encoding
    watch: Watch
    thin_lines: ThinLines | None = None

    @staticmethod
    def of(
        pixels: NDArray[np.float32],
        settings: FitConfig,
        goal: Goal = NO_GOAL,
        *,
        title: str | None = None,
        unread: str | None = None,
        options: FileOptions = DEFAULT_FILE_OPTIONS,
        watch: Watch | None = None,
    ) -> Request:
        """Return the request for a drawing of ``pixels``, as `warpvec.image.read.read_image` gives them.

        ``title`` and ``unread`` are those of a `Picture`.
        """
        picture = Picture.of(pixels, settings.fit_size, title, unread)
        watch = Watch(time_budget=settings.time_budget) if watch is None else watch
        return Request(settings, goal, Encoding.of(picture, settings, options), watch)

    @property
    def picture(self) -> Picture:
        """The picture to draw."""
        return self.encoding.picture

    def with_settings(self, settings: FitConfig) -> Request:
        """Return the request with other settings, which the file states."""
        return replace(self, settings=settings, encoding=replace(self.encoding, settings=settings))


class Mode(Protocol):
    """A way to draw pictures of one kind."""

    def draw(self, request: Request) -> Drawing:
        """Return the drawing that ``request`` asks for.

        Raises:
            InputError: it cannot be made.
        """
