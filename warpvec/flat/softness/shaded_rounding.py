"""The rounding of a JPEG for the picture without its shadows: they are added before it is rounded, and taken away."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpvec.arrays import Floats
from warpvec.condition.jpeg import Jpeg
from warpvec.condition.unrounding import Rounding


@dataclass(frozen=True, eq=False)
class ShadedRounding:
    """The rounding of a picture with shadows, for a drawing without them.

    Attributes:
        whole: how the picture with its shadows was rounded.
        added: what the shadows add to the picture, in levels [h, w, 3].
    """

    whole: Rounding
    added: Floats

    @property
    def jpeg(self) -> Jpeg:
        """What the picture was saved as."""
        return self.whole.jpeg

    @property
    def factor(self) -> float:
        """Enlargement of the drawing when it was rounded."""
        return self.whole.factor

    def nearest(self, drawn: Floats) -> Floats:
        """Return ``drawn`` [h, w, 3], in [0, 255], moved as little as its values with the shadows need to be."""
        found: Floats = np.clip(self.whole.nearest((drawn + self.added).clip(0.0, 255.0)) - self.added, 0.0, 255.0)
        return found
