"""What a command does while a fit runs: it shows progress, and keeps frames."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from warpvec.cli.progress import show_progress
from warpvec.config.fit_config import FitConfig
from warpvec.errors import InputError
from warpvec.files import make_folder
from warpvec.fit.progress import Progress
from warpvec.image.resize import fitted_size
from warpvec.image.video import Video, check_video
from warpvec.image.write import write_png
from warpvec.rendering.draw import draw_pixels

Watch = Callable[[Progress], None]


@contextmanager
def watch(
    photo: NDArray[np.float32], config: FitConfig, folder: str | None, video: str | None, every: int, *, quiet: bool
) -> Iterator[Watch]:
    """The callback of a fit of ``photo``: progress on stderr, and every ``every``-th scene to ``folder`` and ``video``.

    Raises:
        InputError: the folder or the video cannot be written.
    """
    with ExitStack() as stack:
        takers: list[Callable[[int, NDArray[np.float32]], None]] = []
        if folder is not None:
            takers.append(_png_writer(folder))
        if video is not None:
            check_video(video)
            movie = stack.enter_context(Video(video))
            takers.append(lambda _, image: movie.add(image))
        show = stack.enter_context(show_progress(sys.stderr, quiet=quiet))
        size = fitted_size(photo.shape[0], photo.shape[1], config.fit_size)
        yield _both(show, _frames(takers, every, size, config)) if takers else show


def _frames(
    takers: list[Callable[[int, NDArray[np.float32]], None]], every: int, size: tuple[int, int], config: FitConfig
) -> Watch:
    """Draws every ``every``-th scene, and the last, at the size of the fit.

    Iterations are counted on over several fits for one goal; one that is not above the last is of a new fit.
    """
    before, last = 0, 0

    def call(progress: Progress) -> None:
        nonlocal before, last
        if progress.iteration <= last:
            before += last
        last = progress.iteration
        if last % every == 0 or last == progress.iteration_count:
            image = draw_pixels(progress.scene(), *size, **config.render_settings)
            for take in takers:
                take(before + last, image)

    return call


def _png_writer(folder: str) -> Callable[[int, NDArray[np.float32]], None]:
    if not folder:  # which pathlib takes for the current folder
        raise InputError("--save-frames must be a folder or a name for one, got ''; choose another")
    make_folder(folder, "--save-frames")
    return lambda iteration, image: write_png(Path(folder) / f"frame-{iteration:06}.png", image)


def _both(first: Watch, second: Watch) -> Watch:
    def call(progress: Progress) -> None:
        first(progress)
        second(progress)

    return call
