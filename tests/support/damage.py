"""Clean drawings by resvg, and what people do to them: enlarge, blur, compress, light unevenly."""

from __future__ import annotations

import io

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy.ndimage import gaussian_filter

from warpvec.svg.measure import draw

Levels = NDArray[np.float64]

_CREAM = "#f4efe6"

_SVG = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 80"><rect width="100" height="80" fill="#f4efe6"/>
<circle cx="28" cy="36" r="21" fill="#1c6fb5"/><path d="M12 66 30 20 48 66Z" fill="#e2562f"/>
<path d="M60 12h30v9h-10v37h-10v-37h-10z" fill="#253046"/><path d="M57 70q18-22 36 0z" fill="#7a9e35"/>
<circle cx="28" cy="36" r="7" fill="#f6d74a"/><path d="M5 8h40M5 13h31" stroke="#253046" stroke-width="1.6"/></svg>"""


def drawn(width: int, ground: str = _CREAM) -> Image.Image:
    """Return a clean drawing: shapes with level, oblique and round edges, and thin lines, on ``ground``."""
    return Image.fromarray(draw(_SVG.replace(_CREAM, ground), width, round(width * 0.8)))


def levels_of(image: Image.Image) -> Levels:
    """Return the levels [h, w, 3] in [0, 255] of ``image``."""
    return np.asarray(image.convert("RGB")).astype(np.float64)


def enlarged(image: Image.Image, factor: float, kernel: Image.Resampling) -> Image.Image:
    """Return ``image`` enlarged by ``factor`` along both axes."""
    return image.resize((round(image.width * factor), round(image.height * factor)), kernel)


def as_jpeg(image: Image.Image, quality: int, subsampling: int = 2) -> Image.Image:
    """Return ``image`` saved as JPEG and read again; ``subsampling`` is Pillow's, 2 for colours at half size."""
    buffer = io.BytesIO()
    image.save(buffer, "JPEG", quality=quality, subsampling=subsampling)
    return Image.open(buffer).convert("RGB")


def blurred(image: Image.Image, deviation: float) -> Image.Image:
    """Return ``image`` blurred by a Gaussian of ``deviation`` pixels."""
    return _image(gaussian_filter(levels_of(image), (deviation, deviation, 0.0), mode="nearest"))


def noisy(image: Image.Image, deviation: float) -> Image.Image:
    """Return ``image`` with white noise of ``deviation`` levels."""
    levels = levels_of(image)
    return _image(levels + deviation * np.random.default_rng(7).normal(size=levels.shape))


def unevenly_lit(image: Image.Image, darkest: float) -> Image.Image:
    """Return ``image`` with light that falls from 1 to ``darkest`` along a diagonal and a curve, with some grain."""
    levels = levels_of(image)
    down, across = np.meshgrid(*(np.linspace(0.0, 1.0, side) for side in levels.shape[:2]), indexing="ij")
    light = 1.0 - (1.0 - darkest) * (0.5 * across + 0.5 * down**2)
    return noisy(_image(levels * light[..., None]), 2.0)


def _image(levels: Levels) -> Image.Image:
    return Image.fromarray(np.rint(levels.clip(0.0, 255.0)).astype(np.uint8))
