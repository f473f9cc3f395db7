"""A page of a PDF file, by PDFium, over white."""

from __future__ import annotations

import math

import pypdfium2
import pypdfium2.raw

from warpvec.image.decode import check_size, guarded
from warpvec.image.decode_work import sent
from warpvec.image.decoded import Decoded, page_index

POINTS = 72
"""Points of an inch."""

VECTOR_DPI = 150.0
"""Dots per inch of other pages: a hair line of 0.5 points is a pixel wide."""

SCAN_SHARE = 0.5
"""Share of a page that a picture covers at least if the page is a scan. A small logo may have thousands of dots per
inch, at which the page has too many pixels."""

_ROUNDING = 1e-6
"""Share by which a scale is smaller, so that a side of 96.0000001 pixels does not become one of 97."""

pypdfium2.PdfDocument.new().close()


def work(data: bytes, label: str, name: str, page: int | None) -> list[bytes | memoryview]:
    """Return what `warpvec.image.decode_work.work` does, at the resolution of a scan."""
    with guarded(label, name):
        document = pypdfium2.PdfDocument(data)
        index, unread = page_index(page, len(document))
        found = document[index]
        scale = (_resolution(found) or VECTOR_DPI) / POINTS * (1.0 - _ROUNDING)
        width, height = (math.ceil(side * scale) for side in found.get_size())
        check_size(width, height, False, label, name)
        return sent(Decoded(found.render(scale=scale, rev_byteorder=True).to_numpy()[..., :3], unread))


def _resolution(page: pypdfium2.PdfPage) -> float | None:
    """Return the dots per inch of the finest picture that covers most of ``page``, as a scan does; None without one."""
    found, (width, height) = [], page.get_size()
    for image in page.get_objects((pypdfium2.raw.FPDF_PAGEOBJ_IMAGE,)):
        assert isinstance(image, pypdfium2.PdfImage)
        matrix = image.get_matrix()
        across, down = math.hypot(matrix.a, matrix.b), math.hypot(matrix.c, matrix.d)
        columns, rows = image.get_px_size()
        if across * down >= SCAN_SHARE * width * height:
            found.append(POINTS * max(columns / across, rows / down))
    return max(found, default=None)
