"""Write EPS files. EPS has no opacity: cairo draws the parts of a page below translucent paths as pixels.

Until the end cairo keeps the page in a temporary file, which has no name.
"""

from __future__ import annotations

from warpvec.writers import cairo

WRITER = cairo.writer(".eps", "application/postscript", "svg2eps", files=1)
