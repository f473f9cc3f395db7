"""JPEG XL files, by libjxl."""

from __future__ import annotations

from PIL import Image
from pillow_jxl import JpegXLImagePlugin

from warpvec.image.decode import decode_file
from warpvec.image.decode_work import sent

Image.init()
JpegXLImagePlugin.DECODE_THREADS = 0  # threads reserve memory, which the sandbox limits


def work(data: bytes, label: str, name: str, page: int | None) -> list[bytes | memoryview]:
    """Return what `warpvec.image.decode_work.work` does."""
    return sent(decode_file(data, label, name, page, ("JXL",)))
