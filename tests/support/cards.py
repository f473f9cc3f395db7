"""Cards: drawings with a photo in them, whose outline is known."""

from __future__ import annotations

import numpy as np
from PIL import Image, ImageDraw
from PIL.Image import Resampling
from scipy.ndimage import gaussian_filter


def texture(height: int, width: int, seed: int = 3) -> np.ndarray:
    """Return what a photo has: changes of all sizes, most of them weak."""
    random = np.random.default_rng(seed)
    sizes = {0.7: 0.02, 2.0: 0.06, 8.0: 0.12}
    layers = [(gaussian_filter(random.normal(size=(height, width, 3)), (each, each, 0)), each) for each in sizes]
    mixed = sum(sizes[each] * layer / layer.std() for layer, each in layers)
    return (0.5 + mixed).clip(0.0, 1.0)


def card(form: str, ground: tuple[int, int, int] = (250, 248, 240)) -> tuple[np.ndarray, np.ndarray]:
    """Return a card [160, 200, 3] with a bar and a photo, and how much of each pixel the photo covers."""
    large = Image.new("L", (1600, 1280))
    pen, box = ImageDraw.Draw(large), (640, 240, 1439, 1039)
    {"rectangle": pen.rectangle, "ellipse": pen.ellipse}[form](box, fill=255)
    share = np.asarray(large.resize((200, 160), Resampling.BOX)) / 255.0
    plain = np.full((160, 200, 3), np.array(ground) / 255.0)
    plain[20:40, 10:60] = (0.8, 0.2, 0.1)
    part = share[..., None]
    mixed = part * texture(160, 200) + (1.0 - part) * plain
    return (np.rint(255.0 * mixed) / 255.0).astype(np.float32), share
