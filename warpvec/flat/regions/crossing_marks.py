"""Letters on several grounds, such as a name across a road: found by the ink of the word beside them.

Each pixel is a mix of that ink and the nearest ground. Without a known ink, a mark on two grounds could be anything.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpvec.arrays import Floats32, Integers, Integers32, Places
from warpvec.flat.constants.lettering import LETTERING
from warpvec.flat.regions.box_gaps import are_close
from warpvec.flat.regions.noise import Tolerances


@dataclass(frozen=True, eq=False)
class CrossingMark:
    """An island in several grounds.

    Attributes:
        pixels: its pixels [n], numbered by rows.
        beside: region of the nearest ground of each pixel [n].
        behind: premultiplied colour of that ground there [n, 4].
        colors: premultiplied colours of the pixels [n, 4].
        box: first row, first column, and the last ones [4].
    """

    pixels: Places
    beside: Integers32
    behind: Floats32
    colors: Floats32
    box: Integers

    def covered(self, ink: Floats32, tolerances: Tolerances) -> Floats32 | None:
        """Return the share of the premultiplied ``ink`` [4] in each pixel [n]; None if it does not explain the mark."""
        full = ink - self.behind
        share = np.clip(((self.colors - self.behind) * full).sum(1) / (full**2).sum(1).clip(1e-6), 0.0, 1.0)
        rest = self.colors - self.behind - share[:, None] * full
        is_mix = np.sqrt(((rest @ tolerances.metric) ** 2).mean(1)) <= tolerances.mix
        is_apart = np.abs(full).max() >= LETTERING.ink_contrast_min
        return share.astype(np.float32) if is_apart and is_mix.mean() >= LETTERING.crossing_part else None


def joined(
    boxes: Floats32, ink: Floats32, crossing: list[CrossingMark], tolerances: Tolerances
) -> list[tuple[CrossingMark, Floats32]]:
    """Return the marks on several grounds that go on with a word, and the ink in each; ``crossing`` loses them.

    Args:
        boxes: those of the marks of the word [n, 4].
        ink: its premultiplied ink [4].
        crossing: all such marks that are left.
        tolerances: those of the picture.
    """
    found: list[tuple[CrossingMark, Floats32]] = []
    while len(boxes) and crossing:
        is_near = are_close(np.array([mark.box for mark in crossing], np.float32)[:, None], boxes).any(1)
        near = [crossing[index] for index in np.flatnonzero(is_near)]
        parts = [(mark, mark.covered(ink, tolerances)) for mark in near]
        new = [(mark, part) for mark, part in parts if part is not None]
        for mark, _ in new:
            crossing.remove(mark)
        found += new
        boxes = np.array([mark.box for mark, _ in new], np.float32)  # those before have been asked
    return found
