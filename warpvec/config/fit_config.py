"""All settings of a fit, in one frozen and validated object."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from warpvec.config.renderers import RENDERER_SETTINGS
from warpvec.config.rules import check_settings


@dataclass(frozen=True, kw_only=True)
class FitConfig:
    """Settings of one fit. Lengths are in pixels of the fitted image unless the name says otherwise.

    NumPy numbers are accepted and stored as Python numbers.

    Raises:
        InputError: a field has the wrong type or is out of range; the message gives its name, the rule and the value.
    """

    # the kind of picture
    mode: str = "auto"
    """"auto": the picture decides. "photo": paths are fitted. "flat": the regions of a logo, an icon or a drawing are
    outlined. "mono": one black path for the dark areas. Settings that only one of them has decide it too."""
    detail: float = 0.1
    """Root mean square in pixels by which outlines of flat and mono may move to save nodes."""
    cutout: bool = False
    """Cut the paths of flat art out of those below, so that none overlap."""
    threshold: str = "auto"
    """Level from "0" to "255" below which mono is dark, or "auto" for Otsu's."""

    # the result
    curves: int = 512
    """N, the number of closed paths in the result; of flat art the most, and fewer are used when fewer do."""
    path_model: str = "segments"
    """"segments": a path is a loop of cubics. "sides": a path is two curves with common ends, as in the paper; only the
    renderer "splat" draws these, and the file approximates them by cubics."""
    segments: int = 4
    """Mean number of cubics per path in the model "segments"; a cubic has 3 control points."""
    fixed_segments: bool = False
    """Give each path exactly ``segments`` cubics, instead of more to some and fewer to others at the same total. It is
    so in any case for the renderer "splat", the model "sides", the policy "replacement" and fits without recycling."""
    degree: int = 5
    """M, the degree of both curves in the model "sides"; a path has 2 * degree control points."""
    closing_line: bool = False
    """Close every path by a straight line, after its cubics. A file need not state such a line."""
    precision: int = 2
    """Decimals of the coordinates in the SVG."""
    minify: bool = False
    """Write the shortest file, of whole numbers in a fine viewBox, and fit paths that it states in few bytes: see
    `warpvec.config.presets.MINIFIED`."""
    grid: int = 0
    """Units per pixel of a minified file, 0 for as many as the paths need."""
    fit_size: int = 1024
    """Longest side, in pixels, of the image that is fitted; larger images are reduced to it."""
    opacity: str = "free"
    """"free": each path has its own opacity. "common": all have the same, so that the file states it once. "opaque":
    every path has opacity 1."""
    colors: int = 0
    """Largest number of colours in a fitted palette for all fills, the canvas included; 0 for any colours."""
    palette: str | None = None
    """Colours that all fills must come from: CSS names, "#rgb" or "#rrggbb", with commas; stored as "#rrggbb,..."."""
    gradients: float | str | None = None
    """Paths with a linear gradient, those that gain most: their share if this is at most 1, else their number. "auto":
    the paths for which a gradient gains more than another path of as many bytes. None: what the mode does, none in
    photos (stored as 0), those of the picture in flat art. 0 forbids them there too."""
    min_area: float = 0.0
    """Smallest area of a path on the canvas, in square pixels of the full-size image; smaller paths are left out."""
    lod: bool = False
    """Fit every prefix of the levels of detail as a picture of its own."""
    backdrop: str = "learned"
    """"learned": the canvas colour starts at the mean of the image and is fitted. "white": it stays white, as in the
    paper."""

    # the run
    iterations: int = 2000
    time_budget: float | None = None
    """Longest time for the optimization loop, in seconds; the schedule is shortened to fit in it."""
    seed: int = 0
    renderer: str = "exact"
    """"exact": a path covers its exact area. "splat": a path is Gaussians along its outline and through its interior,
    as in the paper."""
    device: str = "auto"
    """"auto", "cpu", "cuda" or "cuda:K"."""
    threads: int | None = None
    """CPU threads for the kernels, of which at most four per core are started; None for all cores. The result does not
    depend on it."""

    # the renderer "splat"
    samples: int = 64
    """Gaussians along each side of a path, and along each line between the sides."""
    lines: int = 40
    """Lines of Gaussians between the two sides of a path."""
    interior_gradient: bool = True
    """Interior Gradient Aggregation: the Gaussians inside a path move its control points too, not only those on its
    sides."""
    covariance_gradient: bool = False
    """Differentiate the sizes and directions of the Gaussians too, not only their positions."""

    # adding and removing paths
    policy: str = "scaffolding"
    """"scaffolding": Algorithm 1 of the paper, with recycling. "replacement": Bezier Splatting's, with all N paths from
    the start."""
    z_order: str = "creation"
    """"creation": newer paths are on top. "area": paths with smaller bounding boxes are on top."""

    # the policy "scaffolding": Algorithm 1
    initial_curves: int = 16
    """N0, the number of paths at the start."""
    growth: float = 2.0
    """r_num: after k inflations there are min(N0 * growth**k, N) paths."""
    inflation_gap: int = 30
    """dT, the number of iterations between inflations."""
    shorten_gap: bool = True
    """Shorten dT if the last inflation would come after half of the run, and replace_gap to 5 % of the run. Otherwise a
    short run ends with fewer than N paths, as in the paper, or never replaces any."""
    initial_radius: float = 0.25
    """Radius of the first generation, in units of half the longer side."""
    radius_decay: float = 0.5
    """r_rad, the radius of a generation divided by that of the generation before."""
    prune_opacity: float = 0.01
    """Largest opacity at which an inflation removes a path."""
    compensate: bool = True
    """Replace the paths that an inflation pruned, in addition to the new ones."""
    flat: bool = False
    """Start with all N paths in one generation (the paper's flat baseline)."""

    # the policy "scaffolding": recycling, beyond the paper
    recycle_gap: int = 25
    """Iterations between recyclings once the population is full; 0 for no recycling."""
    recycle_share: float = 0.06
    """Share of the paths that one recycling replaces, those with the lowest removal cost."""
    recycle_until: float = 0.7
    """Time of the last recycling, as a share of the iterations."""

    # the policy "replacement"
    replace_gap: int = 500
    """Iterations from removing paths to adding as many, and from that to the next removal."""

    # the optimizer
    lr_points: float = 0.012
    """Learning rate of the control points, in units of half the longer side."""
    lr_color: float = 0.01
    lr_opacity: float = 0.05
    lr_scale: float = 1.0
    """Factor for every learning rate."""
    lr_decay: str = "cosine"
    """"cosine": decays to lr_final. "constant". "steps": 1, 0.5, 0.2 and 0.1 from 0, 50, 60 and 90 % of the run, as in
    Bezier Splatting."""
    lr_final: float = 0.02
    """Final learning rate divided by the initial one, under cosine decay."""
    color_parameter: str = "direct"
    """"direct": optimize colours in [0, 1], clamped after each step. "logit": optimize the input of a sigmoid."""

    # the loss (equation 6)
    opacity_weight: float = 1e-4
    """Weight of the opacity term. The paper's 0.01 makes nearly all paths opaque, which costs 0.7 dB at 512 paths. Not
    used for a transparent image, whose soft edges need translucent paths."""
    ssim_weight: float = 1.0
    """Weight of 1 - SSIM, times the present mean squared error. At 512 paths 1 gains 0.016 of SSIM and 0.16 dB of PSNR
    (twelve photos at full size); 2 gains another 0.007 of SSIM for 0.05 dB (six at half size). Fits with ``lod`` leave
    it out."""
    xing_weight: float = 0.02
    bezier_weight: float = 0.05
    """Weight of the Bezier term. The paper's 1 costs 0.5 dB with the exact renderer, and 0.2 still 0.15 dB."""

    def __post_init__(self) -> None:
        for name, value in check_settings(vars(self)).items():
            object.__setattr__(self, name, value)

    @property
    def point_degree(self) -> int:
        """Degree of the curves between the control points."""
        return self.degree if self.path_model == "sides" else 3

    @property
    def render_settings(self) -> dict[str, Any]:
        """Keyword arguments that make `warpvec.render` draw a scene as this fit does."""
        names = ("renderer", "threads", *RENDERER_SETTINGS[self.renderer])
        return {name: getattr(self, name) for name in names}

    def to_dict(self) -> dict[str, Any]:
        """Return the settings as plain values, for the metadata of the file and for JSON."""
        return asdict(self)


MACHINE_SETTINGS = ("threads", "device")
"""Fields that say where a fit runs. SVG files and batch records leave them out. A checkpoint has them, but a resumed
fit may change them. The number of threads does not change the result; another kind of device changes its last
digits."""
