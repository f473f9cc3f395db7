"""The table of purposes: what a file may use for each. To add one, add a row.

`bench/everywhere.py` shows which programs draw what.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from warpvec.errors import InputError


@dataclass(frozen=True)
class Purpose:
    """What a file is for.

    Attributes:
        help: programs and machines, in a few words.
        has_blur: whether paths may be soft. Else rings of sharp paths are drawn in their place, or nothing: see
            ``has_shades``.
        has_gradients: whether paths may have gradients.
        has_ellipses: whether gradients may be elliptic, which takes a matrix.
        has_shades: whether what shades into another colour is drawn, by paths of one colour each where the file has
            nothing else for it. Machines that cut and draw lines take one colour instead.
        has_forms: whether circles, ellipses and rectangles are elements of their own.
        has_turns: whether these may be turned by a transform.
        has_units: whether a unit may be another length than a pixel. paper.js makes strokes as many pixels wide as the
            file has units, and two.js knows no units.
        has_strokes: whether paths may be strokes.
        has_clear_strokes: whether these may be translucent, which two.js ignores.
        has_fills: whether paths may be filled. Else they are strokes of their outlines, thin and in their colours.
        has_arcs: whether path data may have arcs of circles.
        has_ground: whether the file has a rectangle of the background.
        has_groups: whether a group may state the opacity of its paths, or be a symbol.
        is_one_color: whether the file is one black shape.
        has_picture: whether commands write a PNG beside the file, for programs that show no SVG.
        dots: dots per pixel of what shows the file: with more, blurs are drawn in more and smoother rings.
        per_inch: pixels per inch in which a size in real units is stated; None for its unit.
        profile: attributes of the root, with a space before each.
        suffix: of the files that `warpvec batch` names.
    """

    help: str
    has_blur: bool = True
    has_gradients: bool = True
    has_ellipses: bool = True
    has_shades: bool = True
    has_forms: bool = True
    has_turns: bool = True
    has_units: bool = True
    has_strokes: bool = True
    has_clear_strokes: bool = True
    has_fills: bool = True
    has_arcs: bool = True
    has_ground: bool = True
    has_groups: bool = True
    is_one_color: bool = False
    has_picture: bool = False
    dots: float = 1.0
    per_inch: float | None = None
    profile: str = ""
    suffix: str = ".svg"

    def check_packages(self, name: str) -> None:
        """Check that what draws by other means is there; messages call the option ``name``.

        Raises:
            InputError: skia-pathops is missing.
        """
        has_bands = self.has_shades and not (self.has_gradients and self.has_ellipses)
        if not has_bands and self.has_strokes and self.has_clear_strokes:
            return
        from warpvec.svg.foreign.skia import load_skia  # not above: it loads NumPy, which the help does without

        if load_skia() is None:
            rule, found = "needs skia-pathops, which cuts paths", "it is not installed"
            raise InputError(name, rule, found, "pip install 'warpvec[refine]'")


WEB = Purpose("browsers, Inkscape and most programs")
"""Everything that warpvec writes."""

PRINT = Purpose("print, PDF and EPS", has_blur=False, dots=2.0)
"""What CairoSVG draws, which makes files of these kinds."""

ANDROID = Purpose("Android", has_blur=False, has_ellipses=False, has_forms=False, has_groups=False, suffix=".xml")
"""What a VectorDrawable can state."""

_PLAIN = Purpose(
    "PDF chains, Office, games", has_blur=False, has_gradients=False, has_forms=False, has_units=False,
    has_clear_strokes=False, has_arcs=False, has_groups=False,
)  # fmt: skip
"""What every program draws alike. WeasyPrint draws arcs of circles beside their place."""

_CUT = Purpose("machines", has_blur=False, has_gradients=False, has_shades=False, has_ground=False, has_groups=False)

PURPOSES: Mapping[str, Purpose] = {
    "web": WEB,
    "plain": _PLAIN,
    "word": replace(_PLAIN, help="Word and Office, with a PNG beside", has_picture=True),
    "print": PRINT,
    "android": ANDROID,
    "font": replace(_CUT, help="fonts: one black shape", has_forms=False, has_strokes=False, is_one_color=True),
    "tiny": Purpose(
        "SVG Tiny 1.2", has_blur=False, has_ellipses=False, has_arcs=False,
        profile=' version="1.2" baseProfile="tiny"',
    ),
    "pen": replace(_CUT, help="plotters, by vpype: outlines", has_fills=False),
    "cricut": replace(_CUT, help="Cricut Design Space: 72 px an inch", has_turns=False, per_inch=72.0),
}  # fmt: skip
"""Name -> purpose."""
