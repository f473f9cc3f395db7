"""Estimate a picture before JPEG rounded it, by a drawing of it.

JPEG rounds the cosine transform of each block to multiples of steps. So each value was within half a step of the stored
one. The transform of the drawing is moved into these ranges, and no farther. Source: Zakhor, Iterative procedures for
reduction of blocking effects in transform image coding, 1992.

A picture that was enlarged before is drawn at its size before that. The drawing is enlarged, moved, and reduced again.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.fft import dctn, idctn

from warpvec.arrays import Floats
from warpvec.condition.enlargement import Enlargement
from warpvec.condition.jpeg import JFIF, Jpeg, color_steps_of, steps_of
from warpvec.condition.restoration import after_enlargement, before_enlargement

_TO_RGB = np.linalg.inv(JFIF)


@dataclass(frozen=True, eq=False)
class JpegRounding:
    """The rounding of a picture that was saved as JPEG.

    Attributes:
        levels: the decoded picture [h, w, 3] in [0, 255], with its first block in the upper left corner.
        jpeg: what it was saved as.
    """

    levels: NDArray[np.floating[Any]]
    jpeg: Jpeg

    factor: ClassVar[float] = 1.0
    """Enlargement of the drawing when it was rounded."""

    def nearest(self, drawn: Floats) -> Floats:
        """Return ``drawn`` [h, w, 3], in [0, 255], moved as little as its values need to be in their ranges."""
        values = self._transformed(drawn)
        moves = []
        for value, stored, steps in zip(values, self._stored(values), self.steps, strict=True):
            moves.append(np.clip(value, stored - steps / 2.0, stored + steps / 2.0) - value)
        return np.asarray((drawn + self._picture_of(moves)).clip(0.0, 255.0))

    @property
    def steps(self) -> list[Floats]:
        """The steps [8, 8] of brightness and of both colour differences."""
        color = color_steps_of(self.jpeg.quality)
        return [steps_of(self.jpeg.quality), color, color]

    def _stored(self, values: list[Floats]) -> list[Floats]:
        """Return the values that are stored, which those of the drawing, ``values``, help to know.

        A decoder cuts off what is below 0 or above 255, where the drawing tells how far it went.
        """
        rounded = [_rounded(value, steps) for value, steps in zip(values, self.steps, strict=True)]
        likely = self._picture_of(rounded) + 128.0
        whole = np.where(self.levels >= 255.0, likely.clip(255.0), self.levels)
        whole = np.where(self.levels <= 0.0, likely.clip(None, 0.0), whole)
        return [_rounded(value, steps) for value, steps in zip(self._transformed(whole), self.steps, strict=True)]

    def _transformed(self, levels: Floats) -> list[Floats]:
        """Return the `transforms_of` ``levels`` [h, w, 3] about the middle of their range."""
        return self.transforms_of(levels - 128.0)

    def transforms_of(self, values: Floats) -> list[Floats]:
        """Return the cosine transforms [rows, columns, 8, 8] of the brightness and colours of ``values`` [h, w, 3]."""
        planes = np.moveaxis(values @ JFIF.T, -1, 0)
        blocks = [self._blocks_of(plane, index > 0) for index, plane in enumerate(planes)]
        return [dctn(each, axes=(2, 3), norm="ortho") for each in blocks]

    def _blocks_of(self, plane: Floats, is_color: bool) -> Floats:
        """Return the blocks [rows, columns, 8, 8] in which a ``plane`` [h, w] is stored."""
        is_halved = is_color and self.jpeg.is_subsampled
        side = 16 if is_halved else 8
        whole = np.pad(plane, [(0, -length % side) for length in plane.shape], mode="edge")
        if is_halved:
            whole = whole.reshape(whole.shape[0] // 2, 2, -1, 2).mean((1, 3))
        return whole.reshape(whole.shape[0] // 8, 8, -1, 8).transpose(0, 2, 1, 3)

    def _picture_of(self, values: list[Floats]) -> Floats:
        """Return the red, green and blue [h, w, 3], less 128, that the transforms ``values`` make."""
        height, width = self.levels.shape[:2]
        planes = []
        for index, value in enumerate(values):
            blocks = idctn(value, axes=(2, 3), norm="ortho")
            plane = blocks.transpose(0, 2, 1, 3).reshape(8 * blocks.shape[0], -1)
            is_halved = index > 0 and self.jpeg.is_subsampled
            planes.append((_doubled(_doubled(plane, 0), 1) if is_halved else plane)[:height, :width])
        return np.asarray(np.stack(planes, -1) @ _TO_RGB.T)


@dataclass(frozen=True, eq=False)
class EnlargedRounding:
    """The rounding of a picture that was enlarged before it was saved as JPEG.

    Attributes:
        large: the rounding of the large picture.
        enlargement: how the picture was enlarged.
    """

    large: JpegRounding
    enlargement: Enlargement

    @property
    def jpeg(self) -> Jpeg:
        """What the picture was saved as."""
        return self.large.jpeg

    @property
    def factor(self) -> float:
        """Enlargement of the drawing when it was rounded."""
        return self.enlargement.factor

    def nearest(self, drawn: Floats) -> Floats:
        """Return ``drawn`` [h, w, 3], in [0, 255], moved little, so that its enlargement is nearly in the ranges."""
        height, width = self.large.levels.shape[:2]
        moved = self.large.nearest(after_enlargement(drawn, self.enlargement, height, width).clip(0.0, 255.0))
        return 255.0 * before_enlargement(np.asarray(moved / 255.0, np.float32), self.enlargement).astype(np.float64)


class Rounding(Protocol):
    """How the picture that is drawn was rounded by JPEG."""

    @property
    def jpeg(self) -> Jpeg:
        """What the picture was saved as."""

    @property
    def factor(self) -> float:
        """Enlargement of the drawing when it was rounded."""

    def nearest(self, drawn: Floats) -> Floats:
        """Return ``drawn`` [h, w, 3], in [0, 255], moved as little as its values need to be in their ranges."""


def _rounded(values: Floats, steps: Floats) -> Floats:
    return np.asarray(np.rint(values / steps) * steps)


def _doubled(plane: Floats, axis: int) -> Floats:
    """Return ``plane`` [h, w] with twice the samples along ``axis``, as decoders enlarge colours."""
    rows = np.moveaxis(plane, axis, 0)
    around = np.pad(rows, [(1, 1), (0, 0)], mode="edge")
    pairs = np.stack([0.75 * rows + 0.25 * around[:-2], 0.75 * rows + 0.25 * around[2:]], 1)
    return np.moveaxis(pairs.reshape(-1, rows.shape[1]), 0, axis)
