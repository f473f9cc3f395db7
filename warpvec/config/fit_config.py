"""Every setting of a fit: one frozen object, validated once, passed whole."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from warpvec.config.renderers import RENDERER_SETTINGS
from warpvec.config.rules import checked


@dataclass(frozen=True, kw_only=True)
class FitConfig:
    """Settings of one fit. Lengths are in pixels of the fitted image unless the name says otherwise.

    Numbers may be NumPy's; they are kept as Python's.

    Raises:
        InputError: a field is of the wrong type or outside its range; the message names field, rule, value and remedy.
    """

    # what is made
    curves: int = 512
    """N, the number of closed paths in the result."""
    path_model: str = "segments"
    """"segments": a path is cubics in a loop. "sides": it is two curves with common ends, the paper's, which only the
    renderer splat draws; the file then has cubics that come close."""
    segments: int = 4
    """Cubics per path of the model segments; a path has 3 * segments control points."""
    degree: int = 5
    """M, of either curve of the model sides; a path has 2 * degree control points."""
    precision: int = 2
    """Decimals of the coordinates in the SVG."""
    fit_size: int = 1024
    """Longest side, in pixels, of the image that is fitted; larger photos are reduced to it."""
    opacity: str = "free"
    """"free": each path has its own. "opaque": all have 1."""
    colors: int = 0
    """All fills, the canvas's too, are from a palette of at most so many colours, which is fitted; 0 for any."""
    palette: str | None = None
    """All fills are from these colours, "#123,#a0b1c2"."""
    min_area: float = 0.0
    """No path of less than these square pixels of the photo is in the file."""
    lod: bool = False
    """Each level of detail, with those below it, is fitted as a picture of its own."""
    backdrop: str = "learned"
    """"learned": the canvas starts in the photo's mean colour and is fitted. "white": it is white and stays so, as in
    the paper."""

    # how it runs
    iterations: int = 2000
    coarse_until: float = 0.0
    """Until this share of the iterations the fit sees the photo at half size, where a step costs half."""
    time_budget: float | None = None
    """At most these wall-clock seconds for the optimisation loop; the schedule is shortened to fit in them."""
    seed: int = 0
    renderer: str = "exact"
    """"exact": a path is its area. "splat": it is Gaussians along its outline and through its interior, the paper's."""
    device: str = "auto"
    """"auto", "cpu", "cuda" or "cuda:K"."""
    threads: int | None = None
    """CPU threads for the kernels; None takes all cores. The result does not depend on it."""

    # the renderer "splat"
    samples: int = 64
    """Gaussians along each side of a path, and along each line between them."""
    lines: int = 40
    """Lines of Gaussians between the two sides of a path."""
    interior_gradient: bool = True
    """Interior Gradient Aggregation: Gaussians of the lines, not of the sides alone, move the control points."""
    covariance_gradient: bool = False
    """Control points feel the sizes and directions of Gaussians too, not their positions alone."""

    # who decides when paths come and go
    policy: str = "scaffolding"
    """"scaffolding": Algorithm 1 of the paper, and recycling. "replacement": Bezier Splatting's, all N at once."""
    z_order: str = "creation"
    """"creation": the newest path is on top, for life. "area": smaller bounding boxes are on top."""

    # the policy "scaffolding": Algorithm 1
    initial_curves: int = 16
    """N0."""
    growth: float = 2.0
    """r_num: the population is min(N0 * growth**k, N) after k inflations."""
    inflation_gap: int = 30
    """dT: iterations between inflations."""
    shorten_gap: bool = True
    """Shorten dT where the last inflation would come after half the run, and replace_gap to 5 % of the run. Off, a
    short run ends with fewer paths than N, as in the paper, or replaces none."""
    initial_radius: float = 0.25
    """Radius of the first generation, in units of half the longer side."""
    radius_decay: float = 0.5
    """r_rad: the radius of a generation over that of the one before it."""
    prune_opacity: float = 0.01
    """Paths whose opacity is at most this are removed at each inflation."""
    compensate: bool = True
    """Spawn as many paths as were pruned, on top of the inflation."""
    flat: bool = False
    """All N paths at once with no stratification (the paper's flat baseline)."""

    # the policy "scaffolding": recycling, beyond the paper
    recycle_gap: int = 25
    """Iterations between recyclings at full population; 0 switches recycling off."""
    recycle_share: float = 0.06
    """Share of the paths that one recycling replaces: those whose removal costs least."""
    recycle_until: float = 0.7
    """Last recycling, as a share of the iterations."""

    # the policy "replacement"
    replace_gap: int = 500
    """Iterations from a removal of paths to the addition of as many, and from that to the next removal."""

    # optimizer
    lr_points: float = 0.012
    """Learning rate of control points, in units of half the longer side."""
    lr_color: float = 0.01
    lr_opacity: float = 0.05
    lr_scale: float = 1.0
    """Multiplies every learning rate."""
    lr_decay: str = "cosine"
    """"cosine": down to lr_final. "constant". "steps": 1, 0.5, 0.2 and 0.1 from 0, 50, 60 and 90 % of the run, Bezier
    Splatting's."""
    lr_final: float = 0.02
    """Final learning rate over the initial one under cosine decay."""
    color_parameter: str = "direct"
    """"direct": colours in [0, 1], clamped after a step. "logit": the sigmoid of a free parameter."""

    # loss (equation 6)
    opacity_weight: float = 0.01
    """Not used for a transparent image, whose soft edges are made of translucent paths."""
    xing_weight: float = 0.02
    bezier_weight: float = 0.2
    """The paper's is 1, which costs 0.5 dB with the exact renderer; 0.2 costs nothing at 512 paths."""

    def __post_init__(self) -> None:
        for name, value in checked(vars(self)).items():
            object.__setattr__(self, name, value)

    @property
    def point_degree(self) -> int:
        """Degree of the curves that the control points make."""
        return self.degree if self.path_model == "sides" else 3

    @property
    def render_settings(self) -> dict[str, Any]:
        """The keywords of `warpvec.render` with which it draws a scene as this fit does."""
        names = ("renderer", "threads", *RENDERER_SETTINGS[self.renderer])
        return {name: getattr(self, name) for name in names}

    def to_dict(self) -> dict[str, Any]:
        """The settings as plain values, for the metadata of the file and for JSON."""
        return asdict(self)


MACHINE_SETTINGS = ("threads", "device")
"""Fields that say where a fit runs: files, records and checkpoints do not depend on them. On another kind of device the
last digits are others."""
