"""Write the frames of a fit as an MP4, GIF or WebP file."""

from __future__ import annotations

import os
from importlib.util import find_spec
from pathlib import Path
from types import TracebackType

import numpy as np
from numpy.typing import NDArray

from warpvec.errors import InputError
from warpvec.files import check_writable
from warpvec.image.alpha import is_transparent, over
from warpvec.image.write import to_8_bits
from warpvec.temporary_files import temporary_file

EXTENSIONS = (".mp4", ".gif", ".webp")

FRAMES_PER_SECOND = 12
"""Frame rate of every video: the 40 frames of a default fit take three seconds."""


def check_video(path: str) -> None:
    """Check that a video can be written to ``path``, before work is spent on its frames.

    Raises:
        InputError: the extension is unknown, the path cannot be written, or the encoder for MP4 is not installed.
    """
    extension = Path(path).suffix.lower()
    if extension not in EXTENSIONS:
        raise InputError("video", f"must end in {', '.join(EXTENSIONS)}", repr(path), "rename it")
    check_writable(path, "video")
    if extension == ".mp4" and find_spec("imageio_ffmpeg") is None:
        rule = "needs imageio-ffmpeg for MP4, which is not installed"
        raise InputError("video", rule, remedy="pip install 'warpvec[video]'")


class Video:
    """A context manager that collects frames and writes the file if the block ends without an error."""

    def __init__(self, path: str) -> None:
        self._path = Path(path)
        self._frames: list[NDArray[np.uint8]] = []

    def __enter__(self) -> Video:
        return self

    def add(self, image: NDArray[np.float32]) -> None:
        """Append ``image`` [h, w, 3 or 4] in [0, 1]; a transparent one is shown over white."""
        self._frames.append(to_8_bits(over(image, 1.0) if is_transparent(image) else image))

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is not None or not self._frames:
            return
        with temporary_file(self._path, self._path.suffix.lower()) as temporary:
            _write(temporary, self._frames)
            os.replace(temporary, self._path)


def _write(path: Path, frames: list[NDArray[np.uint8]]) -> None:
    if path.suffix == ".mp4":
        _write_mp4(path, frames)
        return
    import imageio.v3 as iio

    duration = round(1000 / FRAMES_PER_SECOND)
    iio.imwrite(path, np.stack(frames), extension=path.suffix, plugin="pillow", duration=duration, loop=0)


def _write_mp4(path: Path, frames: list[NDArray[np.uint8]]) -> None:
    import imageio.v2 as iio

    with iio.get_writer(path, format="FFMPEG", fps=FRAMES_PER_SECOND, macro_block_size=1) as writer:
        for frame in frames:
            # Players expect colour at half the resolution, so an odd side repeats its last row or column.
            height, width = frame.shape[:2]
            writer.append_data(np.pad(frame, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge"))  # type: ignore[attr-defined]
