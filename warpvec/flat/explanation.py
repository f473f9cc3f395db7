"""Refuse a picture that a photo says more briefly than the regions of flat art."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from warpvec.arrays import Floats32
from warpvec.condition.jpeg import Jpeg
from warpvec.flat.evidence.coded import coded_nats
from warpvec.flat.evidence.evidence import Evidence
from warpvec.flat.price import words_of
from warpvec.flat.regions.regions import NotFlatArtError, Regions, find_regions
from warpvec.geometry.scene import Scene
from warpvec.watch.decisions import Decision, are_wanted, note
from warpvec.watch.watch import UNWATCHED, Watch

PHOTO_OVER_CODER = 1.33
"""What the paths of a photo take over what a coder takes. The files of twelve photos by 512 paths have 35,607 bytes
after gzip on average and 28.7 dB (`bench/kodak.py kodak --details`); JPEGs of as many dB have 26,729. Regions of 160
copies of drawings by `bench/strangers.py` take 0.03 to 1.28 times what the coder takes, those of photos 1.46 to 6.9."""

PART_SIDE, PART_COUNT = 128, 3
"""Side in pixels and count of the parts of a large picture that are looked at first: of a photo, they take a tenth of
the time that all of it takes. A side is a multiple of 16, as are the blocks of a JPEG."""


def photo_factor(regions: Regions, evidence: Evidence) -> float:
    """Return how many times the nats of a photo the ``regions`` of the picture of ``evidence`` take."""
    drawn, photo = regions.nats(evidence), PHOTO_OVER_CODER * coded_nats(evidence)
    if are_wanted():
        note(Decision("explanation", None, "photo", f"{len(regions)} regions", photo - drawn, 0.0, drawn <= photo))
    return drawn / max(photo, 1.0)


def drawing_factor(scene: Scene, shown: NDArray[np.uint8], image: Floats32, jpeg: Jpeg | None) -> float:
    """Return how many times the nats of a photo a drawing takes.

    Args:
        scene: the drawing, in pixels of the picture.
        shown: what it looks like [h, w, 3].
        image: the picture [h, w, 3], sRGB-encoded in [0, 1].
        jpeg: what the picture was saved as; None for no JPEG that is known.
    """
    evidence = Evidence.of(image, jpeg)
    nats = words_of(scene).nats(max(shown.shape)) + float(evidence.misfit(shown.astype(np.float64)).sum())
    return nats / max(PHOTO_OVER_CODER * coded_nats(evidence), 1.0)


def is_shorter_as_photo(image: Floats32, jpeg: Jpeg | None) -> bool:
    """Return whether a photo says ``image`` [h, w, 3 or 4] in [0, 1] more briefly than regions do.

    ``jpeg`` is what it was saved as; None for no JPEG that is known.
    """
    return photo_factor(find_regions(image, is_jpeg=jpeg is not None), Evidence.of(image, jpeg)) > 1.0


def require_shorter(regions: Regions, evidence: Evidence) -> None:
    """Refuse the picture of ``evidence`` if a photo says it more briefly than ``regions`` do.

    Raises:
        NotFlatArtError: it does.
    """
    _require(photo_factor(regions, evidence))


def require_shorter_parts(image: Floats32, jpeg: Jpeg | None, watch: Watch = UNWATCHED) -> None:
    """Refuse a large ``image`` [h, w, 3 or 4] that a photo says more briefly than regions, by a few parts of it.

    Args:
        image: the picture, sRGB-encoded in [0, 1]. A small one is not looked at.
        jpeg: what it was saved as; None for no JPEG that is known.
        watch: the watch over the run. No part is looked at once it is over.

    Raises:
        NotFlatArtError: it does.
    """
    if image[..., 0].size < 2 * PART_COUNT * PART_SIDE**2:
        return
    stated = coded = 0.0
    for part in _parts(image):
        if watch.is_over():
            return
        evidence = Evidence.of(part, jpeg)
        stated += find_regions(part, watch=watch, is_jpeg=jpeg is not None).nats(evidence)
        coded += coded_nats(evidence)
    _require(stated / max(PHOTO_OVER_CODER * coded, 1.0))


def _parts(image: Floats32) -> Iterator[Floats32]:
    """Yield parts of ``image`` [h, w, C], spread over it, on the grid of a JPEG."""
    height, width = image.shape[:2]
    for k in range(PART_COUNT):
        top, left = (
            int(max(size - PART_SIDE, 0) * (place + 0.5) / PART_COUNT) // 16 * 16
            for size, place in ((height, k), (width, 2 * k % PART_COUNT))
        )
        yield np.ascontiguousarray(image[top : top + PART_SIDE, left : left + PART_SIDE])


def _require(factor: float) -> None:
    if factor > 1.0:
        raise NotFlatArtError(f"plain areas take {factor:.1f} times the words of a photo")
