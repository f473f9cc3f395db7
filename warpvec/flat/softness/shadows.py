"""Describe shadows, glows and soft spots, and return the picture without one.

A transparent picture is looked at over black and over white at once: it has C = 6 channels here where an opaque one,
and an opaque shape of a transparent one, has 3.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from warpvec.arrays import Floats, Floats32
from warpvec.flat.constants.softness import SOFTNESS
from warpvec.flat.softness.shadow_fitting import FoundShadow
from warpvec.flat.softness.traced_grounds import TracedGround
from warpvec.image.alpha import over_mattes
from warpvec.svg.quantize import OPACITY_DECIMALS


@dataclass(frozen=True)
class Shadow:
    """A shadow, a glow or a soft spot.

    Attributes:
        casters: coverage of what casts it [h, w], in [0, 1]; of the spot itself if nothing does.
        ground: what it lies on.
        look: how it is moved, blurred and painted.
        clean: the picture without it [h, w, 3 or 4].
        spot: the parameters [6] of a soft spot, an ellipse that no shape of the drawing casts; None for no spot.
        mark: the colour [3] in ``clean`` of what casts it in the very colour of its ground; None if nothing does.
    """

    casters: Floats
    ground: TracedGround
    look: FoundShadow
    clean: Floats32
    spot: Floats | None = None
    mark: Floats | None = None

    @property
    def paint(self) -> tuple[Floats, float]:
        """The colour [3] and the opacity that look like this on the ground.

        On an opaque one of one colour many do; they are the most extreme colour that can be, and the least opacity.
        """
        ground, amplitude = self.ground.color / 255.0, self.look.amplitude / 255.0
        if len(amplitude) > 3:
            black, white = amplitude[:3], amplitude[3:]
            opacity = float(np.clip((black - white).mean(), 0.0, 1.0))
            return np.clip(black / max(opacity, 1e-6), 0.0, 1.0), opacity
        room = np.where(amplitude < 0.0, ground, 1.0 - ground)
        least = float((np.abs(amplitude) / np.maximum(room, 1e-6)).max())
        opacity = float(np.clip(max(least, self.look.opacity), 0.0, 1.0))
        opacity = math.ceil(opacity * 10**OPACITY_DECIMALS - 1e-6) / 10**OPACITY_DECIMALS  # the colour makes up for it
        return np.clip(ground + amplitude / max(opacity, 1e-6), 0.0, 1.0), opacity


def is_soft(ground: TracedGround, found: FoundShadow) -> bool:
    """Return whether a fit is blurred, shows, has room, and a colour that can be painted."""
    is_seen = bool(np.abs(found.amplitude).max() >= SOFTNESS.amplitude_min)
    opaque = ground.color + found.amplitude
    can_be = bool(opaque.min() >= -SOFTNESS.jump and opaque.max() <= 255.0 + SOFTNESS.jump)
    has_room = bool(ground.region.sum() >= SOFTNESS.room * found.sigma**2)
    return found.sigma >= SOFTNESS.sigma_min and is_seen and can_be and has_room


def channels_of(image: Floats32, count: int | None = None) -> Floats:
    """Return ``image`` [h, w, 3 or 4] as it is, or over black and white if it is transparent [h, w, C].

    If a ``count`` of 3 channels is asked for, a transparent one is over black alone.
    """
    channels: Floats = over_mattes(image).astype(np.float64)
    return channels[..., :count]
