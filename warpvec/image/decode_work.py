"""Decode a picture file in a child process; see `warpvec.sandbox.run`."""

from __future__ import annotations

import io
import json
from contextlib import suppress

import numpy as np
from PIL import Image, MpoImagePlugin, TiffImagePlugin  # noqa: F401 # of JPEG files with several pictures, of EXIF

from warpvec.image.decode import FORMATS, decode_file
from warpvec.image.decoded import Decoded


def work(data: bytes, label: str, name: str, page: int | None) -> list[bytes | memoryview]:
    """Return what the picture file ``data`` has, as `sent` does."""
    return sent(decode_file(data, label, name, page))


def sent(found: Decoded) -> list[bytes | memoryview]:
    """Return the samples after a line of JSON: what was left out, the width, the type and the shape."""
    samples = np.ascontiguousarray(found.samples)
    head = [found.unread, found.meters, samples.dtype.name, *samples.shape]
    return [json.dumps(head).encode() + b"\n", samples.data.cast("B")]


def _load_readers() -> None:
    """Let Pillow load all that it loads when it reads a file of a format for the first time."""
    Image.init()
    for format in FORMATS:
        stream = io.BytesIO()
        with suppress(OSError, KeyError):  # Pillow may be built without some
            Image.new("RGB", (1, 1)).save(stream, format)
            decode_file(stream.getvalue(), format, format)


_load_readers()
