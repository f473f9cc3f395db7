"""Write PDF files, for print shops, cutters and typesetting."""

from __future__ import annotations

from warpvec.writers import cairo

WRITER = cairo.writer(".pdf", "application/pdf", "svg2pdf")
