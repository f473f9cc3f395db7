"""The regions of a picture: areas of one paint, and how the pixels between them are mixed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warpvec.flat.paints import Paints
from warpvec.flat.region_growing import NONE, grow_seeds, without_small
from warpvec.flat.unmixing import best_mixes, nearest_labels

Floats = NDArray[np.float32]
Integers = NDArray[np.int32]

AREA_MIN = 4.0
"""Areas of fewer pixels are specks."""

STEP = 2.5 / 255
"""Largest difference of neighbours in one area: steep gradients change so much in a pixel, and edges change more."""

BORDER_SHARE_MIN = 0.5
"""Share of the picture's border that the canvas of an opaque picture has at least."""


@dataclass(frozen=True, eq=False)
class Regions:
    """K regions of a picture of h x w pixels. A pixel between two regions is a mix of both.

    Attributes:
        label: region with the largest share of each pixel [h, w] (int32).
        other: region that has the rest of each pixel [h, w] (int32); equal to ``label`` in pure pixels.
        share: share of ``label`` in each pixel [h, w] (float32), in [0.5, 1].
        color: sRGB-encoded fill [K, 3] (float32) in [0, 1]; of a gradient, that of the first stop.
        opacity: opacity [K] (float32) in [0, 1]; 0 for regions where the picture is transparent.
        kind: `warpvec.geometry.gradients.FLAT`, ``LINEAR`` or ``RADIAL`` [K] (int32).
        geometry: ends x1, y1, x2, y2 of a linear gradient, or cx, cy, r, 0 of a radial one, in pixels [K, 4] (float32).
        end_color: fill of the last stop [K, 3] (float32).
        canvas: region that fills the canvas behind all others; None if the picture has no such region.
    """

    label: NDArray[np.int32]
    other: NDArray[np.int32]
    share: NDArray[np.float32]
    color: NDArray[np.float32]
    opacity: NDArray[np.float32]
    kind: NDArray[np.int32]
    geometry: NDArray[np.float32]
    end_color: NDArray[np.float32]
    canvas: int | None = None

    def __len__(self) -> int:
        return len(self.color)

    @property
    def paints(self) -> Paints:
        """The paints of the regions."""
        return Paints(self.color, self.opacity, self.kind, self.geometry, self.end_color)

    def mixed(self) -> Floats:
        """Return the picture that the regions, their paints and shares state: premultiplied RGBA [h, w, 4]."""
        y, x = (grid.astype(np.float32) + np.float32(0.5) for grid in np.indices(self.label.shape))
        share = self.share[..., None]
        return share * self.paints.at(self.label, x, y) + (1 - share) * self.paints.at(self.other, x, y)


def find_regions(image: Floats, min_area: float = AREA_MIN) -> Regions:
    """Return the regions of flat art.

    Args:
        image: picture [h, w, 3 or 4], sRGB-encoded in [0, 1], with straight alpha if it has four channels.
        min_area: areas of fewer pixels are left out.
    """
    picture = premultiplied(image)
    labels = without_small(grow_seeds(picture, STEP), min_area)
    if labels.max() < 0:
        labels[...] = 0
    count = labels.max() + 1
    values = np.stack([np.median(picture[labels == index], 0) for index in range(count)])
    paints = Paints.flat(np.round(values * 255).astype(np.float32) / 255)
    label, other, share = _assigned(picture, labels, paints)
    return Regions(
        label, other, share, paints.color, paints.opacity, paints.kind, paints.geometry, paints.end_color,
        _canvas(label, paints),
    )  # fmt: skip


def premultiplied(image: Floats) -> Floats:
    """Return ``image`` [h, w, 3 or 4] as premultiplied RGBA [h, w, 4]."""
    alpha = image[..., 3:] if image.shape[-1] == 4 else np.ones((*image.shape[:2], 1), np.float32)
    return np.concatenate([image[..., :3] * alpha, alpha], -1).astype(np.float32)


def _assigned(picture: Floats, labels: Integers, paints: Paints) -> tuple[Integers, Integers, Floats]:
    """Return label, other and share of all pixels, from the labels of the pure ones."""
    from scipy import ndimage

    rows, columns = (place.astype(np.int32) for place in np.nonzero(labels == NONE))
    nearest = ndimage.distance_transform_edt(labels == NONE, return_distances=False, return_indices=True)
    label = labels[tuple(nearest)]
    other, share = label.copy(), np.ones(label.shape, np.float32)
    candidates = nearest_labels(labels, rows, columns)
    candidates[:, 0] = np.where(candidates[:, 0] == NONE, label[rows, columns], candidates[:, 0])
    mixes = best_mixes(picture, paints, candidates, rows, columns)
    label[rows, columns], other[rows, columns], share[rows, columns] = mixes.label, mixes.other, mixes.share
    return label, other, share


def _canvas(label: Integers, paints: Paints) -> int | None:
    """Return the region behind all others, or None."""
    border = np.concatenate([label[0], label[-1], label[:, 0], label[:, -1]])
    count = np.bincount(border, minlength=len(paints))
    clear = np.where(paints.opacity == 0, count, 0)
    if clear.any():
        return int(clear.argmax())
    return int(count.argmax()) if count.max() >= BORDER_SHARE_MIN * len(border) else None
