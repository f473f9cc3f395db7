"""OpenRaster files, and those of Krita: archives of layers with the merged picture as a PNG (OpenRaster 0.0.6)."""

from __future__ import annotations

import zipfile
from io import BytesIO

from PIL import Image

from warpvec.image.decode import decode_file, guarded
from warpvec.image.decode_work import sent

_MERGED = "mergedimage.png"

Image.init()
"".encode("cp437")  # the encoding of names in an archive, which Python loads when it first needs it


def work(data: bytes, label: str, name: str, page: int | None) -> list[bytes | memoryview]:
    """Return what `warpvec.image.decode_work.work` does."""
    with guarded(label, name), zipfile.ZipFile(BytesIO(data)) as archive:
        if _MERGED not in archive.namelist():
            raise ValueError(f"an archive without {_MERGED}")
        merged = archive.read(_MERGED)
    return sent(decode_file(merged, label, name, page, ("PNG",)))
