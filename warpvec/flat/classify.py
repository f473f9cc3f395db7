"""Choose the mode of a run from the picture: a photo, flat art, or black and white art."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Choice(NamedTuple):
    """The mode that suits a picture, and the reason in a few words."""

    mode: str
    reason: str


def choose_mode(image: NDArray[np.float32]) -> Choice:
    return Choice("photo", "")
