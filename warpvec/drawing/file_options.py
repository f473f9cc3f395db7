"""Choices about how a file is written."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass

from warpvec.checks import show
from warpvec.config.fit_config import RESULT
from warpvec.config.kinds import Choice, Custom, Flag, Positive, parse_text
from warpvec.config.limits import LINE_WIDTH_MAX
from warpvec.config.palette import parse_palette
from warpvec.config.setting import setting, settings_of
from warpvec.config.world_file import check_world_file, parse_world_file
from warpvec.errors import InputError
from warpvec.purposes.table import PURPOSES
from warpvec.svg.on_pages import DARKEST, check_id
from warpvec.svg.units import check_size, in_pixels_of, sides_of


def _check_size(name: str, value: object) -> str | None:
    del name
    return None if value is None else check_size(value)


def _check_color(name: str, value: object) -> str | None:
    """Return "#rrggbb" or ``DARKEST``; None stays None."""
    if value is None or value == DARKEST:
        return value if isinstance(value, str) else None
    with suppress(InputError):
        found = parse_palette(value)
        if found.count("#") == 1:
            return found
    raise InputError(name, "must be a colour", show(value), "give one such as black, or put the option last")


@dataclass(frozen=True, kw_only=True)
class FileOptions:
    """Choices about the file alone. They do not change the fit, and the metadata does not state them.

    Raises:
        InputError: a field has the wrong type, or the size is none.
    """

    size: str | None = setting(
        None, Custom(_check_size, parse_text, "WIDTH", "90mm, 3in, 50%", "str"),
        "Width: 90mm, also in, cm, pt, px, %; Qt, Skia: --ppi.", RESULT, is_daily=True,
    )  # fmt: skip
    """Width of the drawing with its unit, such as "90mm"; see `warpvec.svg.units.check_size`. None for its pixels."""
    purpose: str = setting(
        "web", Choice(tuple(PURPOSES)), "What it is for, such as plain, android, word or pen.",
        RESULT, flag="for", old_name="purpose",
    )  # fmt: skip
    """What the file is for, a key of `warpvec.purposes.table.PURPOSES`: it has only what programs for this show."""
    trim: bool = setting(False, Flag(), "Cut the paths off at the edges of the canvas.", RESULT, is_daily=True)
    """Cut the paths off at the edges of the canvas."""
    plain_paths: bool = setting(False, Flag(), "Write paths only, no circles, ellipses or rectangles.", RESULT)
    """Write paths in place of forms, for programs that read nothing else."""
    no_dashes: bool = setting(
        False, Flag(), "Write each dash of a dashed line as a line, for cutters and pens.", RESULT
    )
    """Write each dash of a straight dashed line as a line, in place of one line with a ``stroke-dasharray``."""
    line_width_min: float = setting(
        0.3, Positive(LINE_WIDTH_MAX, f"must be above 0 and at most {LINE_WIDTH_MAX:g} pixels", "give 0.3"),
        "Say so if strokes are thinner, in pixels of the picture.", RESULT,
    )  # fmt: skip
    """Width in pixels of the picture below which the summary counts strokes, which pens and small screens lose."""
    no_metadata: bool = setting(False, Flag(), "Leave the settings (1 KB) out of the file.", RESULT)
    """Leave the settings of the fit, about 1 KB, out of the file."""

    dxf_splines: bool = setting(False, Flag(), "DXF: write curves as splines, not as arcs.", RESULT)
    """Write outlines with curves as splines in DXF files, in place of lines and arcs within 0.01 mm."""

    dxf_strokes: str = setting(
        "auto", Choice(("auto", "edges", "center")), "DXF: strokes as both edges, or for pens as the center lines.",
        RESULT,
    )  # fmt: skip
    """What a stroke is in files for cutters: both its edges, or its centre line. "auto" takes the centre line for pens:
    in the mode lines, and for the purpose "pen"."""

    world_file: str | None = setting(
        None, Custom(check_world_file, parse_world_file, "FILE", "six numbers", "str | Sequence[float]"),
        "GeoJSON: place it on the map by this world file, such as map.pgw.", RESULT,
    )  # fmt: skip
    """The numbers A, D, B, E, C, F of a world file, with which a GeoJSON file has the coordinates of the map; None for
    pixels. A command gets the name of the file. See `warpvec.config.world_file.placing`."""

    ppi: str = setting(
        "mm", Choice(("mm", "96", "72")),
        "State --size as is (mm), or in px of 1/96 or 1/72 inch: Qt and Skia take mm at 90 dpi, sharp at 72.",
        RESULT,
    )  # fmt: skip
    """Unit of a size in real units: as given, or pixels of so many per inch, for programs that read no units.

    Of a size in mm, Qt and Skia make pixels of 1/90 inch, sharp of 1/72; Android and paper.js drop the unit; browsers,
    Inkscape, resvg and cutters' programs read it. LibreOffice opens every DXF 10 cm long: scale it there."""
    current_color: str | None = setting(
        None, Custom(_check_color, parse_text, "COLOR", "a colour, or darkest", "str"),
        "Give this colour (or the darkest) the page's text colour.", RESULT, bare=DARKEST,
    )  # fmt: skip
    """Colour that becomes "currentColor" in the file, which web pages set: the paint nearest to it, or "darkest"."""
    symbol: str | None = setting(
        None, Custom(check_id, parse_text, "ID", "letters, digits, - and _", "str"),
        "Write a <symbol> with this id, for a sprite.", RESULT,
    )  # fmt: skip
    """Id of the symbol that the file consists of, for sprites of web pages; None for a drawing."""

    @property
    def per_inch(self) -> float | None:
        """Pixels per inch; None for real units."""
        return PURPOSES[self.purpose].per_inch if self.ppi == "mm" else float(self.ppi)

    def sides(self, width: float, height: float) -> tuple[str, str] | None:
        """Return the attributes width and height of a drawing of this many pixels; None without a size."""
        if self.size is None:
            return None
        sides = sides_of(self.size, width, height)
        return sides if self.per_inch is None else in_pixels_of(sides, self.per_inch)

    def __post_init__(self) -> None:
        for name, each in settings_of(FileOptions).items():
            object.__setattr__(self, name, each.kind.check(name, getattr(self, name)))
        purpose = PURPOSES[self.purpose]
        purpose.check_packages("purpose")
        if self.symbol is not None and not purpose.has_groups:
            raise InputError("symbol", "must not be given for this purpose", self.purpose, "leave one of them out")


DEFAULT_FILE_OPTIONS = FileOptions()
"""The file states the settings, and the paths are not cut."""
