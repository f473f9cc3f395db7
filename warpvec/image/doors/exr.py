"""OpenEXR files: linear light with associated alpha (OpenEXR's technical introduction)."""

from __future__ import annotations

from io import BytesIO
from typing import Any

import numpy as np
import OpenEXR
from numpy.typing import NDArray

from warpvec.image.decode import check_size, guarded
from warpvec.image.decode_work import sent
from warpvec.image.decoded import Decoded, refuse_page
from warpvec.image.png_colors import srgb_encoded

_COLORS = (("R", "G", "B"), ("Y",))
"""Names of the channels of colours, or of grey."""


def work(data: bytes, label: str, name: str, page: int | None) -> list[bytes | memoryview]:
    """Return what `warpvec.image.decode_work.work` does."""
    refuse_page(page)
    with guarded(label, name):
        head = OpenEXR.File(BytesIO(data), header_only=True, num_threads=0).header()
        low, high = head["dataWindow"]
        width, height = (int(side) for side in high - low + 1)
        check_size(width, height, any(channel.name == "A" for channel in head["channels"]), label, name)
        channels = OpenEXR.File(BytesIO(data), separate_channels=True, num_threads=0).channels()
        return sent(_decoded(channels))


def _decoded(channels: dict[str, Any]) -> Decoded:
    colors = next((names for names in _COLORS if all(name in channels for name in names)), None)
    if colors is None or "RY" in channels:
        raise ValueError(f"channels {', '.join(sorted(channels))[:60]}; save it with R, G and B")
    planes = [channels[name].pixels for name in (*(colors * 3)[:3], *(["A"] if "A" in channels else []))]
    pixels: NDArray[np.float32] = np.stack(planes, -1).astype(np.float32)
    if not np.isfinite(pixels).all():
        raise ValueError("values that are not finite")
    if pixels.shape[2] == 4:
        pixels[..., 3] = pixels[..., 3].clip(0.0, 1.0)
        pixels[..., :3] = _colors_of(pixels)
    is_bright = bool((pixels > 1.0).any())
    pixels[..., :3] = srgb_encoded(pixels[..., :3].clip(0.0, 1.0))
    return Decoded(pixels, "light that is brighter than white" if is_bright else None)


def _colors_of(pixels: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the straight colours of ``pixels`` [h, w, 4], also those that are brighter than white."""
    alpha = pixels[..., 3:]
    return np.divide(pixels[..., :3], alpha, out=np.zeros_like(pixels[..., :3]), where=alpha > 0.0)
