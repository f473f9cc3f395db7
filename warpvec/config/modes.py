"""The modes by their names: what people call them, and which settings and hints follow."""

from __future__ import annotations

from typing import NamedTuple


class ModeName(NamedTuple):
    """What is known of a mode without loading it; `warpvec.modes` draws.

    Attributes:
        title: what the summary calls it.
        plural: what a batch calls pictures of this mode.
        likeliest_other: the mode that the summary offers if this one is wrong.
        is_outlined: whether it outlines what is there, instead of adding paths until the picture is close.
        label: its name on the page.
        tooltip: what it does, for the page.
    """

    title: str
    plural: str
    likeliest_other: str
    is_outlined: bool
    label: str
    tooltip: str


MODES = {
    "photo": ModeName(
        "photo", "photos", "flat", False, "Photo",
        "Photos and paintings: paths are laid over one another until the picture is close",
    ),
    "flat": ModeName(
        "flat art", "flat art", "photo", True, "Flat",
        "Flat art, such as logos, icons and drawings: each area becomes one clean path",
    ),
    "mono": ModeName(
        "black and white art", "black and white art", "flat", True, "Mono",
        "Monochrome: black outlines for all dark areas, as for stamps, stencils and line art",
    ),
    "lines": ModeName(
        "lines", "drawings of lines", "mono", True, "Lines",
        "Lines only: a stroke along the middle of each line, as for pen plotters, engravers and signatures",
    ),
    "pixel": ModeName(
        "pixels", "pixel art", "flat", True, "Pixel",
        "Pixel art and codes: each pixel is a square, and those of a colour are one exact path",
    ),
    "mixed": ModeName(
        "a drawing with photos", "drawings with photos", "photo", True, "Mixed",
        "Drawings with photos in them: the photos are painted inside of their outlines, and the rest is flat art",
    ),
}  # fmt: skip
"""Every mode that a picture can be drawn in, by the value of the setting "mode"."""


def is_outlined(mode: str) -> bool:
    """Return whether ``mode`` outlines what is there; the mode "auto" and unknown ones do not."""
    return mode in MODES and MODES[mode].is_outlined
