"""HEIC files, the pictures of phones, by libheif."""

from __future__ import annotations

from PIL import Image
from pillow_heif import register_heif_opener

from warpvec.image.decode import decode_file
from warpvec.image.decode_work import sent

Image.init()
register_heif_opener()


def work(data: bytes, label: str, name: str, page: int | None) -> list[bytes | memoryview]:
    """Return what `warpvec.image.decode_work.work` does."""
    return sent(decode_file(data, label, name, page, ("HEIF",)))
