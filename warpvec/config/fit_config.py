"""All settings of a run. Each is stated once, as a field: default, kind of values, help, section, and who uses it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from warpvec.checks import as_float, check_count, show
from warpvec.config import cross_rules
from warpvec.config.control import Control, Step, doublings, slider, tick
from warpvec.config.kinds import (
    Choice,
    Custom,
    Flag,
    Positive,
    Real,
    Whole,
    or_auto,
    parse_real,
    parse_text,
    parse_whole,
)
from warpvec.config.limits import (
    BLUR_MAX,
    DETAIL_MAX,
    LEVEL_MAX,
    LINE_WIDTH_MAX,
    MAX_COUNT,
    MAX_CURVES,
    MAX_GRID,
    MAX_GROWTH,
    MAX_RADIUS,
    MAX_RATE,
    MAX_SCALE,
    MAX_SECONDS,
    MAX_SEGMENTS,
    MAX_THREADS,
    MAX_UNITS,
    MAX_WEIGHT,
)
from warpvec.config.modes import MODES
from warpvec.config.palette import check_palette, parse_palette_or_file
from warpvec.config.rooms import added_names, added_settings, with_added_names
from warpvec.config.setting import PHOTO, Setting, photo_setting, setting, settings_of
from warpvec.errors import InputError

AUTO, OFF = "auto", "off"
"""Values of settings that leave a choice to the picture, or that want none of it."""


def _check_gradients(name: str, value: object) -> float | str | None:
    if value is None:
        return None
    if isinstance(value, str) and value != AUTO:
        raise InputError(name, "must be a number or auto", show(value), "give for example 0.2")
    return AUTO if isinstance(value, str) else _COUNT_OR_SHARE.check(name, value)


def _check_threshold(name: str, value: object) -> str:
    """Return "auto", or the text of a whole level."""
    rule = f"must be auto or a level from 0 to {LEVEL_MAX}"
    return _auto_or_count(name, value, LEVEL_MAX, rule, "give one of these")


def _check_soft(name: str, value: object) -> str:
    """Return "auto", or the text of a number of paths."""
    rule = f"must be auto or a whole number from 0 to {MAX_CURVES}"
    return _auto_or_count(name, value, MAX_CURVES, rule, "give 0 for sharp paths only")


def _check_grid(name: str, value: object) -> str:
    """Return "auto" or "off", or the text of a whole number of units."""
    if value == OFF and isinstance(value, str):
        return OFF
    rule = f"must be auto, off or a whole number of units from 1 to {MAX_GRID}"
    found = _auto_or_count(name, value, MAX_GRID, rule, "give 24")
    if found == "0":
        raise InputError(name, rule, show(value), "give 24")
    return found


def _check_line_width(name: str, value: object) -> str:
    """Return "auto", or the text of a width in pixels."""
    rule = f"must be auto or a width above 0 and at most {LINE_WIDTH_MAX:g} pixels"
    return _auto_or_number(name, value, lambda width: 0.0 < width <= LINE_WIDTH_MAX, rule, "give 2.5")


def _check_blur(name: str, value: object) -> str:
    """Return "auto", or the text of a standard deviation in pixels."""
    rule = f"must be auto or a standard deviation from 0 to {BLUR_MAX:g} pixels"
    return _auto_or_number(name, value, lambda deviation: 0.0 <= deviation <= BLUR_MAX, rule, "give 1.5")


def _auto_or_count(name: str, value: object, most: int, rule: str, remedy: str) -> str:
    """Return "auto", or the text of a whole number up to ``most``; ``rule`` and ``remedy`` are those of the error."""
    if value == AUTO and isinstance(value, str):
        return AUTO
    try:
        count = int(value) if isinstance(value, str) else value
    except ValueError:
        raise InputError(name, rule, show(value), remedy) from None
    return str(check_count(name, count, 0, most))


def _auto_or_number(name: str, value: object, is_allowed: Callable[[float], bool], rule: str, remedy: str) -> str:
    """Return "auto", or the text of a number that is allowed; ``rule`` and ``remedy`` are those of the error."""
    if value == "auto" and isinstance(value, str):
        return "auto"
    try:
        number = float(value) if isinstance(value, str) else as_float(value)
    except ValueError:
        raise InputError(name, rule, show(value), remedy) from None
    if not is_allowed(number):
        raise InputError(name, rule, show(value), remedy)
    return f"{number:g}"


def _check_device(name: str, value: object) -> str:
    """Return ``value``. The fit checks later that the device exists: finding out takes seconds."""
    if not isinstance(value, str):
        raise InputError(name, "must be a name", show(value), "give 'auto', 'cpu', 'cuda' or 'cuda:K'")
    return value


_COUNT_OR_SHARE = Real(0.0, MAX_CURVES)
_DETAIL = Positive(DETAIL_MAX, f"must be above 0 and at most {DETAIL_MAX:g} pixels", "give 0.1 to 1")
_LINE_WIDTH = Custom(_check_line_width, parse_text, "X|auto", f"auto, above 0 to {LINE_WIDTH_MAX:g}", "float | str")
_GRID = Custom(_check_grid, parse_text, "N|auto|off", f"auto, off, 1 to {MAX_GRID}", "int | str")
_BLUR = Custom(_check_blur, parse_text, "X|auto", f"auto, 0 to {BLUR_MAX:g}", "float | str")
_THRESHOLD = Custom(_check_threshold, parse_text, "auto|N", f"auto, 0 to {LEVEL_MAX}", "int | str")
_SOFT = Custom(_check_soft, parse_text, "auto|N", f"auto, 0 to {MAX_CURVES}", "int | str")
_CURVES = Custom(
    Whole(1, MAX_CURVES).check,
    or_auto(parse_whole, "must be a whole number or auto"),
    "N|auto",
    f"1 to {MAX_CURVES}",
    'int | Literal["auto"]',
)
_GRADIENTS = Custom(
    _check_gradients,
    or_auto(parse_real, "must be a number or auto"),
    "X|auto",
    f"auto, 0 to {MAX_CURVES}",
    'float | Literal["auto"] | None',
)
_PALETTE = Custom(
    check_palette, parse_palette_or_file, "COLORS", "colours with commas between them", "str | Sequence[str]"
)
_SECONDS = Positive(
    MAX_SECONDS,
    f"must be a finite number of seconds above 0, and at most {MAX_SECONDS:g}",
    "leave it out for no limit",
    optional=True,
)
_DEVICE = Custom(_check_device, parse_text, "NAME", "auto, cpu, cuda, cuda:K", "str")
_RATE, _SHARE, _WEIGHT = Real(0.0, MAX_RATE), Real(0.0, 1.0), Real(0.0, MAX_WEIGHT)
_GAP = Whole(1, MAX_COUNT)

DETAIL_STEPS = 33
"""Steps of the page's slider, four for each doubling: 16 to 4,096 paths, or 3.2 to 0.0125 pixels. More paths than that
are not drawn smoothly while they are edited."""

_MODE_STEPS = (Step(name, mode.label, mode.tooltip) for name, mode in MODES.items())
_MODE_CONTROL = Control("choice", "Kind of picture", "", (Step("auto", "Auto", "The picture decides"), *_MODE_STEPS))
_DETAIL_TOOLTIP = "Photo: number of paths. Flat and mono: how closely outlines follow the picture"
_CUTOUT_TOOLTIP = "Cut each path out of those below, as cutting plotters and screen printing need it. Only for flat art"
_PAPER_TOOLTIP = "Nothing lies below what is drawn: the paper of a scan, or the ground of a logo. Not for photos"
_OPAQUE_TOOLTIP = "Make no path translucent: simpler to edit and to print"
_GRADIENTS_TOOLTIP = "Share of the paths that change smoothly from one colour to another. Only for photos"

KIND, GOAL, RESULT, RUN = "Kind of picture", "Goal", "Result", "Run"
POPULATION = "Adding and removing paths"
SCAFFOLDING = "Policy scaffolding: Algorithm 1 of the paper"
RECYCLING = "Policy scaffolding: recycling of the paths that matter least"
OPTIMIZER, LOSS = "Optimizer", "Loss"


@dataclass(frozen=True, kw_only=True)
class CoreSettings:
    """Settings of one run. Lengths are in pixels of the fitted image unless the name says otherwise.

    NumPy numbers are accepted and stored as Python numbers.

    Raises:
        InputError: a field has the wrong type or is out of range; the message gives its name, the rule and the value.
    """

    mode: str = setting(
        "auto", Choice(("auto", *MODES)), "auto, photo, flat, mono, lines, pixel or mixed.",
        KIND, is_daily=True, stated="never", page=_MODE_CONTROL,
    )  # fmt: skip
    """"auto": the picture decides. "photo": fit paths. "flat": outline the regions of a logo, an icon or a drawing.
    "mono": outline the dark areas in black. "lines": draw each line by a stroke along its middle. "pixel": draw each
    pixel as a square. "mixed": draw the photos in a drawing as photos, and the rest as flat art. A setting that only
    one mode has selects that mode."""
    detail: float = setting(
        0.1, _DETAIL, "Drawings: how far outlines may move, in pixels.", KIND, is_daily=True,
        modes=("flat", "mono", "lines", "mixed"),
        page=slider("Detail", _DETAIL_TOOLTIP, doublings(3.2, DETAIL_STEPS, -4), lambda pixels: f"{pixels:.2f} px"),
    )  # fmt: skip
    """Root mean square of the distance in pixels by which outlines of flat and mono, and lines, may move to save
    nodes."""
    cutout: bool = setting(
        False, Flag(), "Flat: make no overlaps, for cutters and plotters.", KIND, is_daily=True, modes=("flat",),
        is_binding=True, ignored_by=("mono",), page=tick("Cut out, without overlaps", _CUTOUT_TOOLTIP),
    )  # fmt: skip
    """Cut the paths of flat art out of the paths below, so that none overlap."""
    strokes: str = setting(
        "auto", Choice(("auto", "all", "off")), "Flat, mono: draw lines as strokes along their middle.",
        KIND, modes=("flat", "mono", "mixed"), is_binding=True,
    )  # fmt: skip
    """"auto": strokes in flat art and in clean black and white art are drawn by their centre lines, but for wide bars
    with square ends or corners, unless a round pen shows. "all": these too. "off": by their outlines."""
    threshold: str = setting(
        "auto", _THRESHOLD, "Black and white: level from 0 to 255 below which a pixel is dark, or auto (Otsu's).", KIND,
        modes=("mono",), is_binding=True,
    )  # fmt: skip
    """Level from "0" to "255" below which mono is dark, or "auto" for Otsu's."""
    line_width: str = setting(
        "auto", _LINE_WIDTH, "Lines: width of all strokes in pixels, or auto (as in the picture).", KIND,
        modes=("lines",), is_binding=True,
    )  # fmt: skip
    """Width of all strokes of lines in pixels of the picture, as a number, or "auto" for the widths in the picture."""
    pens: int = setting(
        0, Whole(0, 16), "Lines: most pens, each of a colour; 0 for as many as the picture has.", KIND,
        modes=("lines",), is_binding=True,
    )  # fmt: skip
    """Largest number of colours of lines; 0 for those of the picture."""

    smooth_pixels: bool = setting(
        False, Flag(), "Pixels: draw the curves that pixel art and bitmap fonts mean.", KIND,
        modes=("pixel",), is_binding=True,
    )  # fmt: skip
    """Draw pixel art as the curves that its pixels mean, in place of exact squares."""

    as_is: bool = setting(
        False,
        Flag(),
        "Drawings: do not undo an enlargement or uneven light.",
        KIND,
        modes=("flat", "mono", "lines", "pixel", "mixed"),
        stated="if used",
    )
    """Draw the pixels as they are. Else drawings are made from the picture before it was enlarged, or in even light."""

    blur: str = setting(
        "auto", _BLUR, "Drawings: blur to undo, a deviation in pixels (0: none), or auto (as measured).", KIND,
        modes=("flat", "mono", "mixed"), stated="if used",
    )  # fmt: skip
    """Standard deviation in pixels of the picture's blur, as a number, or "auto" for the measured one. The file is
    sharp: blurred by so much, it shows what the picture shows. "0" draws edges as soft as they are."""

    paper: str = setting(
        "auto", Choice(("auto", "keep", "remove")),
        "Flat, mono: paper below the drawing: keep (white), remove (transparent), or auto.", KIND,
        modes=("flat", "mono"), stated="if used",
        page=tick("Leave out the paper", _PAPER_TOOLTIP, "auto", "remove"),
    )  # fmt: skip
    """"keep": the drawing lies on white paper; coloured grounds stay. "remove": nothing lies below it. "auto": flat art
    has the ground of the picture, and black and white art has none."""

    curves: int = setting(
        512, _CURVES, "Number of paths, the most in drawings; auto chooses.",
        GOAL, is_daily=True,
        page=slider(
            "Detail", _DETAIL_TOOLTIP, map(round, doublings(16, DETAIL_STEPS)), lambda count: f"{count:,} paths",
            modes=PHOTO, moved_by="detail",
        ),
    )  # fmt: skip
    """N, the number of closed paths in the result. In flat art it is the largest number of paths."""

    colors: int = setting(
        0, Whole(0, 256), "Most colours, 0 for any; makes paths opaque.", RESULT, is_daily=True,
        modes=("photo", "flat", "pixel"), is_binding=True,
        page=slider(
            "Colours", "Largest number of different colours in the drawing",
            (0, 2, 3, 4, 5, 6, 8, 10, 12, 16, 24, 32, 48, 64), lambda count: str(count or "any"),
        ),
    )  # fmt: skip
    """Largest number of colours in a fitted palette for all fills, the canvas included; 0 for any colours."""
    palette: str | None = setting(
        None, _PALETTE, "Use only these colours: red,#a0b1c2, or a file.", RESULT, is_daily=True,
        modes=("photo", "flat"), is_binding=True,
    )  # fmt: skip
    """Colours that all fills must come from: CSS names, "#rgb" or "#rrggbb", with commas; stored as "#rrggbb,..."."""
    opacity: str = setting(
        "free", Choice(("free", "common", "opaque")), "Opacity of the paths: free, common (one for all) or opaque.",
        RESULT, page=tick("Opaque paths", _OPAQUE_TOOLTIP, "free", "opaque"),
    )  # fmt: skip
    """"free": each path has its own opacity. "common": all paths have one opacity, so that the file states it once.
    "opaque": every path has opacity 1."""
    gradients: float | str | None = photo_setting(
        None, _GRADIENTS, "Paths with a gradient: 40, a share (0.5), auto or 0.", RESULT, is_daily=True,
        is_binding=True, stated="if used",
        page=slider("Gradients", _GRADIENTS_TOOLTIP, (n / 20 for n in range(21)), lambda share: f"{100 * share:.0f} %"),
    )  # fmt: skip
    """Paths with a linear gradient, those that gain most: their share if this is at most 1, else their number. "auto":
    the paths for which a gradient gains more than another path of as many bytes. None: what the mode does, none in
    photos (stored as 0), the gradients of the picture in flat art. 0 forbids gradients there too."""
    soft: str = setting(
        "auto", _SOFT, "Most paths with a blurred edge, for shadows and smooth shades: auto, N or 0.", RESULT,
        modes=("photo", "flat", "mixed"),
    )  # fmt: skip
    """Most paths that are soft, as a whole number, or "auto". Photos: those that gain most, up to a twentieth of the
    paths, if they gain more than sharp ones of as many bytes. Fits to a quality, of fewer than 317 iterations, with
    `lod`, a palette or another renderer have none. Flat art: a shadow or glow that the picture has, with any number but
    0. "0" makes none."""
    min_area: float = setting(
        0.0, Real(0.0, math.inf), "Leave out paths smaller than X square pixels.", RESULT, is_daily=True
    )
    """Smallest area of a path on the canvas, in square pixels of the full-size image; smaller paths are left out."""
    lod: bool = photo_setting(
        False, Flag(), "Make levels of detail: the lowest K layers alone make a good picture, for every K.", RESULT,
        is_binding=True,
    )  # fmt: skip
    """Fit every prefix of the levels of detail as a picture of its own."""
    minify: bool = setting(
        False, Flag(), "Write the shortest file; on with --max-bytes.", RESULT,
        is_daily=True, stated="never",
    )  # fmt: skip
    """Write the shortest file, of whole numbers in a fine viewBox, and fit paths that take few bytes: see
    `warpvec.config.presets.MINIFIED`."""
    units: int = setting(
        0, Whole(0, MAX_UNITS), "Units per pixel of a minified file; 0 for as many as needed.", RESULT, stated="never"
    )
    """Units per pixel of a minified file; 0 for as many as the paths need."""
    grid: str = setting(
        "auto", _GRID, "Drawings: units along the longer side of the grid that it was made on; auto or off.", RESULT,
        modes=("flat", "mono"), stated="if used",
    )  # fmt: skip
    """Units along the longer side of the grid that the drawing was made on. "auto" finds it. Numbers that are meant to
    be on it are put there, and the file is in its units. "off" for pixels."""
    precision: int = setting(2, Whole(0, 6), "Decimals of the coordinates, 0 to 6.", RESULT)
    """Decimals of the coordinates in the SVG. float32 has seven digits, and at least one of them is before the
    point."""
    path_model: str = photo_setting(
        "segments", Choice(("segments", *added_names("path_models"))),
        with_added_names("Shape of a path: segments (a loop of cubics)", "path_models"), RESULT, is_binding=True,
    )  # fmt: skip
    """"segments": a path is a loop of cubics. "sides": a path is two curves with common ends, as in the paper; only the
    renderer "splat" draws these, and the file approximates them by cubics."""
    segments: int = photo_setting(
        4, Whole(2, MAX_SEGMENTS), "Average number of cubics per path.", RESULT, is_daily=True
    )
    """Average number of cubics per path in the model "segments"; a cubic has 3 control points."""
    fixed_segments: bool = photo_setting(False, Flag(), "Give each path exactly --segments cubics.", RESULT)
    """Give each path exactly ``segments`` cubics, instead of more to some and fewer to others at the same total. The
    renderer "splat", the model "sides", the policy "replacement" and fits without recycling always do."""
    closing_line: bool = photo_setting(
        False, Flag(), "Close every path by a straight line after its cubics.", RESULT, stated="if used"
    )
    """Close every path by a straight line, after its cubics. A file need not state such a line."""
    backdrop: str = photo_setting(
        "learned", Choice(("learned", "white")), "Canvas colour: learned (fitted) or white.", RESULT
    )
    """"learned": the canvas colour starts at the mean of the image and is fitted. "white": it stays white, as in the
    paper."""

    iterations: int = setting(2000, _GAP, "Optimization steps; more give a better picture.", RUN, is_daily=True)
    """Number of optimization steps. A fit of 10^9 iterations takes weeks."""
    time_budget: float | None = setting(
        None, _SECONDS, "Longest time for the optimization, in seconds.", RUN, is_daily=True, metavar="S"
    )
    """Longest time for the optimization, in seconds; the schedule is shortened to fit in it."""
    seed: int = setting(0, Whole(0, 2**63 - 1), "Start of the random numbers; equal seeds give equal files.", RUN)
    """Start of the random number generators, which take a signed 64-bit seed."""
    renderer: str = photo_setting(
        "exact", Choice(("exact", *added_names("renderers"))),
        with_added_names("Renderer: exact (areas, as SVG viewers draw them)", "renderers"), RUN, is_binding=True,
    )  # fmt: skip
    """"exact": a path covers its exact area. "splat": a path is Gaussians along its outline and through its interior,
    as in the paper."""
    device: str = setting(
        "auto", _DEVICE, "Processor: auto, cpu, cuda or cuda:K.", RUN, is_daily=True, is_of_machine=True
    )
    """"auto", "cpu", "cuda" or "cuda:K"."""
    threads: int | None = setting(
        None, Whole(1, MAX_THREADS, optional=True), "CPU threads; the result does not depend on them.", RUN,
        is_daily=True, is_of_machine=True,
    )  # fmt: skip
    """CPU threads for the kernels, of which at most four per core are started; None for all cores. The result does not
    depend on their number."""
    fit_size: int = setting(1024, _GAP, "Longest side of the image that is fitted, in pixels.", RUN)
    """Longest side, in pixels, of the image that is fitted; larger images are reduced to it."""

    policy: str = photo_setting(
        "scaffolding", Choice(("scaffolding", *added_names("policies"))),
        with_added_names("Policy: scaffolding (Algorithm 1)", "policies"), POPULATION, is_binding=True,
    )  # fmt: skip
    """"scaffolding": Algorithm 1 of the paper, with recycling. "stratification": the same as its authors' code has it,
    without recycling. "replacement": Bezier Splatting's, with all N paths from the start."""
    z_order: str = photo_setting(
        "creation", Choice(("creation", "area")), "Paths on top: creation (the newest) or area (the smallest).",
        POPULATION,
    )  # fmt: skip
    """"creation": newer paths are on top. "area": paths with smaller bounding boxes are on top."""

    initial_curves: int = photo_setting(16, _GAP, "Number of paths at the start, N0.", SCAFFOLDING)
    """N0, the number of paths at the start."""
    growth: float = photo_setting(
        2.0, Real(1.0, MAX_GROWTH), "Each inflation multiplies the paths by this, r_num: 1, or at least 1.01.",
        SCAFFOLDING,
    )  # fmt: skip
    """r_num: after k inflations there are min(N0 * growth**k, N) paths."""
    inflation_gap: int = photo_setting(30, _GAP, "Iterations between inflations, dT.", SCAFFOLDING)
    """dT, the number of iterations between inflations."""
    shorten_gap: bool = photo_setting(
        True, Flag(), "Shorten the gaps between inflations, and between removals, if the run is too short.", SCAFFOLDING
    )
    """Shorten dT if the last inflation would come after half of the run, and ``replace_gap`` to 5 % of the run.
    Otherwise a short run ends with fewer than N paths, as in the paper, or never replaces any."""
    initial_radius: float = photo_setting(
        0.25, Real(0.0, MAX_RADIUS), "Radius of the first paths, in units of half the longer side.", SCAFFOLDING
    )
    """Radius of the first generation, in units of half the longer side."""
    radius_decay: float = photo_setting(
        0.5, _SHARE, "Radius of new paths, as a share of the generation before, r_rad.", SCAFFOLDING
    )
    """r_rad, the radius of a generation divided by that of the generation before."""
    prune_opacity: float = photo_setting(
        0.01, _SHARE, "Largest opacity at which an inflation removes a path.", SCAFFOLDING
    )
    """Largest opacity at which an inflation removes a path."""
    compensate: bool = photo_setting(True, Flag(), "Replace the paths that an inflation removed.", SCAFFOLDING)
    """Replace the paths that an inflation pruned, in addition to the new ones."""
    one_generation: bool = photo_setting(
        False, Flag(), "Start with all paths, in one generation.", SCAFFOLDING, old_name="flat"
    )
    """Start with all N paths in one generation (the paper's flat baseline)."""

    recycle_gap: int = photo_setting(25, Whole(0, MAX_COUNT), "Iterations between recyclings; 0 for none.", RECYCLING)
    """Iterations between recyclings once the population is full; 0 for no recycling."""
    recycle_share: float = photo_setting(0.06, _SHARE, "Share of the paths that one recycling replaces.", RECYCLING)
    """Share of the paths that one recycling replaces: the paths with the lowest removal cost."""
    recycle_until: float = photo_setting(
        0.7, _SHARE, "Time of the last recycling, as a share of the iterations.", RECYCLING
    )
    """Time of the last recycling, as a share of the iterations."""

    lr_points: float = photo_setting(
        0.012, _RATE, "Learning rate of the control points, in units of half the longer side.", OPTIMIZER
    )
    """Learning rate of the control points, in units of half the longer side."""
    lr_color: float = photo_setting(0.01, _RATE, "Learning rate of the colours.", OPTIMIZER)
    """Learning rate of the colours."""
    lr_opacity: float = photo_setting(0.05, _RATE, "Learning rate of the opacities.", OPTIMIZER)
    """Learning rate of the opacities."""
    lr_scale: float = photo_setting(1.0, Real(0.0, MAX_SCALE), "Factor for every learning rate.", OPTIMIZER)
    """Factor for every learning rate."""
    lr_decay: str = photo_setting(
        "cosine", Choice(("cosine", "constant", "steps")),
        "Decay of the learning rates: cosine, constant or steps (Bezier Splatting's).", OPTIMIZER,
    )  # fmt: skip
    """"cosine": decays to lr_final. "constant". "steps": 1, 0.5, 0.2 and 0.1 from 0, 50, 60 and 90 % of the run, as in
    Bezier Splatting."""
    lr_final: float = photo_setting(
        0.02, _SHARE, "Ratio of the final and the initial learning rate, for cosine decay.", OPTIMIZER
    )
    """Final learning rate divided by the initial one, under cosine decay."""
    axis_rates: bool = photo_setting(
        False, Flag(), "Measure the rate of the control points by half of each side, not of the longer one.", OPTIMIZER,
        stated="if used",
    )  # fmt: skip
    """Take the learning rate of the control points in units of half the width across, and of half the height down."""
    common_age: bool = photo_setting(
        False, Flag(), "Let new paths take the optimizer's count of steps from the others.", OPTIMIZER,
        stated="if used",
    )  # fmt: skip
    """Give new paths the age of the first ones, as one counter for all does in the code of the published methods: their
    averages start at zero and count as old, so that their first steps are shorter."""
    color_parameter: str = photo_setting(
        "direct", Choice(("direct", "logit")), "Optimize colours directly (direct) or through a sigmoid (logit).",
        OPTIMIZER,
    )  # fmt: skip
    """"direct": optimize colours in [0, 1], clamped after each step. "logit": optimize the input of a sigmoid."""

    opacity_weight: float = photo_setting(1e-4, _WEIGHT, "Weight of the term for opaque paths.", LOSS)
    """Weight of the opacity term (equation 6). The paper's 0.01 makes nearly all paths opaque, which costs 0.7 dB at
    512 paths. Not used for a transparent image, whose soft edges need translucent paths."""
    ssim_weight: float = photo_setting(
        0.7, _WEIGHT, "Weight of the structural similarity (SSIM); 0 for the squared error alone.", LOSS
    )
    """Weight of 1 - SSIM at each of up to five scales, times the present mean squared error. kodim05, 13 and 23 at 512
    paths: 0 gives 25.92 dB, SSIM 0.650 and LPIPS (VGG) 0.500, 0.7 gives 26.08, 0.678 and 0.483, and 1 gives 25.91,
    0.670 and 0.488. Fits with ``lod`` leave it out."""
    xing_weight: float = photo_setting(0.02, _WEIGHT, "Weight of the term against crossing handles.", LOSS)
    """Weight of the Xing term (equation 6)."""
    bezier_weight: float = photo_setting(0.05, _WEIGHT, "Weight of the Bezier regularizer.", LOSS)
    """Weight of the Bezier term (equation 6). The paper's 1 costs 0.5 dB with the exact renderer, and 0.2 still 0.15
    dB."""

    def __post_init__(self) -> None:
        checked = {name: each.kind.check(name, getattr(self, name)) for name, each in SETTINGS.items()}
        for name, value in cross_rules.checked(checked, SETTINGS).items():
            object.__setattr__(self, name, value)

    @property
    def soft_max(self) -> int | None:
        """Most paths that are soft; None if what they gain decides."""
        return None if self.soft == AUTO else int(self.soft)

    @property
    def render_settings(self) -> dict[str, Any]:
        """Keyword arguments that make `warpvec.render` draw a scene as this fit does."""
        own = [name for name, each in SETTINGS.items() if each.renderer == self.renderer]
        return {name: getattr(self, name) for name in ("renderer", "threads", *own)}

    def to_dict(self) -> dict[str, Any]:
        """Return the settings as plain values, for the metadata of the file and for JSON."""
        return asdict(self)


if TYPE_CHECKING:  # rooms that add settings read them by a type of their own

    @dataclass(frozen=True, kw_only=True)
    class FitConfig(CoreSettings):
        """All settings of a run."""

else:
    FitConfig = dataclass(frozen=True, kw_only=True)(
        type("FitConfig", (*added_settings(), CoreSettings), {"__doc__": CoreSettings.__doc__, "__module__": __name__})
    )

SETTINGS: dict[str, Setting] = settings_of(FitConfig)
"""Every setting by its name, in the order of the help."""

OLD_NAMES = {each.old_name: name for name, each in SETTINGS.items() if each.old_name is not None}
"""Former name of a setting -> its name."""

MACHINE_SETTINGS = tuple(name for name, each in SETTINGS.items() if each.is_of_machine)
"""Settings that say where a fit runs. SVG files and batch records leave them out. A checkpoint has them, but a resumed
fit may change them. The number of threads does not change the result; another kind of device changes its last
digits."""
