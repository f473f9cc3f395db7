"""Write the frames of a fit as an MP4, GIF or WebP file."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import AbstractContextManager, ExitStack, closing, contextmanager, suppress
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpvec.errors import InputError
from warpvec.files import check_writable
from warpvec.image.alpha import is_transparent, over
from warpvec.image.animation import GifWriter, PartWriter, WebpWriter
from warpvec.image.write import to_8_bits
from warpvec.temporary_files import at_abrupt_end, temporary_file

EXTENSIONS = (".mp4", ".gif", ".webp")

FRAMES_PER_SECOND = 12
"""Frame rate of every video: the 40 frames of a default fit take three seconds."""

_QUALITY = "25"
"""Quality of an MP4 for ffmpeg, whose default is 23; 0 has no loss and 51 the fewest bytes."""

_FFMPEG_FAILED = "ffmpeg could not write all of it; the disk may be full"


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


class Video(AbstractContextManager["Video"]):
    """A video that is written while its frames come. A context manager: without `finish` there is no file after it."""

    def __init__(self, path: str) -> None:
        self._path = Path(path)
        self._writer: PartWriter | _Mp4Writer | None = None
        self._files = ExitStack()

    def add(self, image: NDArray[np.float32]) -> None:
        """Append ``image`` [h, w, 3 or 4] in [0, 1]; a transparent one is shown over white.

        Raises:
            OSError: the video cannot be written. It cannot be continued then.
        """
        if self._writer is None:
            self._temporary = self._files.enter_context(temporary_file(self._path, self._path.suffix.lower()))
            self._writer = self._files.enter_context(_open_writer(self._temporary))
        self._writer.add(to_8_bits(over(image, 1.0) if is_transparent(image) else image))

    def finish(self) -> None:
        """Put the video in place, unless it has no frames.

        Raises:
            OSError: the video cannot be written.
        """
        if self._writer is not None:
            self._writer.finish()
            os.replace(self._temporary, self._path)

    def __exit__(self, *_: object) -> None:
        with suppress(OSError):  # what was left to write after an error
            self._files.close()


@contextmanager
def _open_writer(path: Path) -> Iterator[PartWriter | _Mp4Writer]:
    if path.suffix == ".mp4":
        with closing(_Mp4Writer(path)) as writer:
            yield writer
        return
    duration = round(1000 / FRAMES_PER_SECOND)
    with path.open("wb") as stream:
        yield (GifWriter if path.suffix == ".gif" else WebpWriter)(stream, duration)


class _Mp4Writer:
    """Passes frames on to the program ffmpeg, which chooses the encoder: H.264 where it has one."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._process: subprocess.Popen[bytes] | None = None
        self._ends = ExitStack()

    def add(self, frame: NDArray[np.uint8]) -> None:
        """Append ``frame`` [h, w, 3]."""
        # Players expect colour at half the resolution, so an odd side repeats its last row or column.
        height, width = frame.shape[:2]
        padded = np.pad(frame, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")
        process = self._process or self._start(padded.shape[1], padded.shape[0])
        assert process.stdin is not None
        try:
            process.stdin.write(padded.tobytes())
        except BrokenPipeError as error:
            raise OSError(_FFMPEG_FAILED) from error

    def finish(self) -> None:
        """Write what is left."""
        self.close()
        if self._process is not None and self._process.returncode != 0:
            raise OSError(_FFMPEG_FAILED)

    def close(self) -> None:
        """Tell ffmpeg that there are no more frames, and wait for its end."""
        if self._process is not None and self._process.stdin is not None:
            with suppress(BrokenPipeError):
                self._process.stdin.close()
            self._process.wait()
            self._ends.close()

    def _start(self, width: int, height: int) -> subprocess.Popen[bytes]:
        from imageio_ffmpeg import get_ffmpeg_exe  # type: ignore[import-untyped]

        try:
            program = get_ffmpeg_exe()
        except RuntimeError as error:
            raise OSError(str(error)) from error
        source = ["-f", "rawvideo", "-s", f"{width}x{height}", "-pix_fmt", "rgb24", "-r", str(FRAMES_PER_SECOND)]
        options = [*source, "-i", "-", "-an", "-pix_fmt", "yuv420p", "-crf", _QUALITY, "-v", "quiet"]
        # In a process group of its own, or Ctrl-C in a terminal would end it before the last frame.
        group: dict[str, Any] = {} if sys.platform == "win32" else {"process_group": 0}
        silence = subprocess.DEVNULL
        command = [program, "-y", *options, str(self._path)]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=silence, stderr=silence, **group)
        self._ends.enter_context(at_abrupt_end(self._process.kill))
        return self._process
