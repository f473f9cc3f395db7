"""Draw pixel art and codes: each pixel is a square, and those of a colour are one path."""

from __future__ import annotations

from dataclasses import dataclass

from warpvec.drawing.drawing import Drawing
from warpvec.errors import InputError
from warpvec.flat.constants.pixels import PIXELS
from warpvec.flat.pixels.cells import find_cells
from warpvec.flat.pixels.outlines import scene_of_cells
from warpvec.flat.pixels.smooth import smooth_scene
from warpvec.modes.flat import finished
from warpvec.modes.request import Request

CELLS_MAX = 2**20
"""Most pixels of a picture in the mode pixel, before its enlargement: as many as those of a picture of 1024 x 1024."""


@dataclass(frozen=True)
class Pixel:
    """The mode of pixel art and codes.

    Attributes:
        tolerance: largest difference of a channel, in levels, between colours that were one.
    """

    tolerance: int = 0

    def draw(self, request: Request) -> Drawing:
        """Return the drawing of the pixels, or of the curves that they mean. A goal changes nothing.

        Raises:
            InputError: the picture has too many pixels.
        """
        reduced, settings = request.picture.reduced, request.settings
        if reduced[..., 0].size > CELLS_MAX:
            size = f"{reduced.shape[1]} x {reduced.shape[0]} pixels"
            raise InputError("image", f"must have at most {CELLS_MAX} pixels in the mode pixel", size, "reduce it")
        cells = find_cells(reduced, self.tolerance, settings.colors or PIXELS.colors_max)
        scene_of = smooth_scene if settings.smooth_pixels else scene_of_cells
        scene = scene_of(cells, is_opaque=reduced.shape[2] == 3)
        return finished(request, scene, settings.detail, {})
