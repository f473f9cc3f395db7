"""Callbacks of a fit: show its progress and record its frames."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from warpvec.cli.progress import show_progress
from warpvec.cli.side_files import SideFile
from warpvec.config.fit_config import FitConfig
from warpvec.config.modes import is_outlined
from warpvec.errors import InputError
from warpvec.files import make_folder
from warpvec.geometry.scene import Scene
from warpvec.image.picture import fitted_size
from warpvec.image.video import Video, check_video
from warpvec.image.write import write_png
from warpvec.rendering.draw import draw_pixels
from warpvec.result import Result
from warpvec.watch.progress import OnProgress, Progress

TakeFrame = Callable[[int, NDArray[np.float32]], None]
"""Receives the number of the iteration and an image [h, w, 3 or 4]."""


@contextmanager
def recorded(
    photo: NDArray[np.float32], config: FitConfig, folder: str | None, video: str | None, every: int, *, quiet: bool
) -> Iterator[Recorder]:
    """Yield the recorder of a fit of ``photo``, which shows progress on stderr and records frames.

    A frame that cannot be written later, as on a full disk, is a warning and does not end the fit.

    Args:
        folder: receives the frames as PNG files, if given.
        video: receives the frames as a video, if given.
        every: iterations between two frames.

    Raises:
        InputError: the folder or the video cannot be written.
    """
    with ExitStack() as stack:
        takers: list[TakeFrame] = []
        if folder is not None:
            takers.append(_png_writer(folder))
        if video is not None:
            check_video(video)
            takers.append(stack.enter_context(_filmed(video)))
        show = stack.enter_context(show_progress(sys.stderr, quiet=quiet))
        size = fitted_size(photo.shape[0], photo.shape[1], config.fit_size)
        yield Recorder(show, takers, every, size, config)


class Recorder:
    """Shows the progress of a fit, and draws frames at the size of the fit."""

    def __init__(
        self, show: OnProgress, takers: list[TakeFrame], every: int, size: tuple[int, int], config: FitConfig
    ) -> None:
        self._show, self._takers, self._every, self._size = show, takers, every, size
        self._settings = config.render_settings
        self._before = self._last = 0

    def __call__(self, progress: Progress) -> None:
        """Show the ``progress``, and draw every scene whose turn it is, and the last one.

        On a GPU several iterations may pass at a time: the scene after a turn is then drawn in place of that at it.
        A goal takes several fits, whose iterations are numbered consecutively: an iteration number that does not
        increase starts a new fit. Of a fit of fewer iterations than are between two frames, every scene is drawn.
        """
        self._show(progress)
        if progress.iteration <= self._last:
            self._before += self._last
            self._last = 0
        turns = self._last // self._every
        self._last = progress.iteration
        is_due = self._last // self._every > turns or self._last == progress.iteration_count
        if self._takers and (is_due or progress.iteration_count < self._every):
            self._draw(progress.scene())

    def end(self, result: Result) -> None:
        """Draw the ``result`` if it is flat art, which is no scene of a fit: its forms become regular after the fit."""
        if self._takers and is_outlined(result.config.mode):
            self._last += 1
            (height, width), (rows, columns) = self._size, result.picture.reduced_size
            self._draw(result.drawing.fitted.scaled(width / columns, height / rows))

    def _draw(self, scene: Scene) -> None:
        image = draw_pixels(scene, *self._size, **self._settings)
        for take in self._takers:
            take(self._before + self._last, image)


def _png_writer(folder: str) -> TakeFrame:
    if not folder:  # pathlib would use the current folder
        raise InputError("--save-frames", "must be a folder or a name for one", "''", "choose another")
    make_folder(folder, "--save-frames")
    side = SideFile("--save-frames")

    def take(iteration: int, image: NDArray[np.float32]) -> None:
        side.attempt(write_png, Path(folder) / f"frame-{iteration:06}.png", image, "--save-frames")

    return take


@contextmanager
def _filmed(path: str) -> Iterator[TakeFrame]:
    """Yield a receiver of frames; put the video of them in place if the block ends without an error."""
    side = SideFile("--video")

    def take(_: int, image: NDArray[np.float32]) -> None:
        if not side.has_failed:  # a video cannot be continued after a gap
            side.attempt(film.add, image)

    with Video(path) as film:
        yield take
        if not side.has_failed:
            side.attempt(film.finish)
