"""Every setting of a fit: one frozen object, validated once, passed whole."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, fields, replace
from typing import Any

from warpvec.checks import as_float, check_choice, check_count, check_flag, check_number, show
from warpvec.errors import InputError

RENDERER_SETTINGS: dict[str, tuple[str, ...]] = {
    "exact": (),
    "splat": ("samples", "lines", "interior_gradient", "covariance_gradient"),
}
"""Renderer -> the fields of `FitConfig` that are its settings. Each name is a module of this package."""

RENDERERS = tuple(RENDERER_SETTINGS)
PATH_MODELS = ("segments", "sides")
Z_ORDERS = ("creation", "area")
COLOR_PARAMETERS = ("direct", "logit")
LR_DECAYS = ("cosine", "constant", "steps")
BACKDROPS = ("learned", "white")
POLICIES = ("scaffolding", "replacement")

GROWTH_MIN = 1.01
"""Least growth other than 1: an inflation that adds no path to the first hundred is a mistake, not a schedule."""


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
    xing_weight: float = 0.02
    bezier_weight: float = 0.2
    """The paper's is 1, which costs 0.5 dB with the exact renderer; 0.2 costs nothing at 512 paths."""

    def __post_init__(self) -> None:
        for name, value in {**_counts(self), **_numbers(self)}.items():
            object.__setattr__(self, name, value)
        _check_choices(self)
        _check_path_model(self)
        _check_growth(self)

    @property
    def point_degree(self) -> int:
        """Degree of the curves that the control points make."""
        return self.degree if self.path_model == "sides" else 3

    @property
    def renderer_settings(self) -> dict[str, Any]:
        """Arguments of the renderer beyond the canvas, the device and the threads."""
        settings = {name: getattr(self, name) for name in RENDERER_SETTINGS[self.renderer]}
        return {**settings, "degree": self.point_degree} if settings else {}

    def to_dict(self) -> dict[str, Any]:
        """The settings as plain values, for the metadata of the file and for JSON."""
        return asdict(self)


_PAPERS_MODEL: dict[str, Any] = {
    "path_model": "sides",
    "backdrop": "white",
    "renderer": "splat",
    "color_parameter": "logit",
    "bezier_weight": 1.0,
}

PRESETS: dict[str, dict[str, Any]] = {
    "draft": {"iterations": 400, "inflation_gap": 20},
    "default": {},
    "best": {"iterations": 6000},
    "paper": {
        **_PAPERS_MODEL,
        "iterations": 5000,
        "inflation_gap": 100,
        "recycle_gap": 0,
        "lr_points": 0.01,
        "lr_color": 0.5,
        "lr_opacity": 0.5,
        "lr_decay": "constant",
    },
    # The flat baseline as its code has it; there the Xing term is switched off.
    "bezier-splatting": {
        **_PAPERS_MODEL,
        "iterations": 10_000,
        "interior_gradient": False,
        "policy": "replacement",
        "z_order": "area",
        "recycle_gap": 0,
        "lr_points": 2e-4,
        "lr_color": 0.01,
        "lr_opacity": 0.01,
        "lr_decay": "steps",
        "xing_weight": 0.0,
    },
}
"""Preset name -> the fields in which it differs from FitConfig's defaults."""


def make_config(preset: str = "default", **settings: Any) -> FitConfig:
    """A preset with some fields replaced.

    Raises:
        InputError: no such preset or setting, or a value outside its range.
    """
    check_choice("preset", preset, tuple(PRESETS))
    known = {field.name for field in fields(FitConfig)}
    for name in settings:
        if name not in known:
            raise InputError(f"{name} is not a setting; see warpvec.FitConfig for the names")
    return replace(FitConfig(), **{**PRESETS[preset], **settings})


def _counts(config: FitConfig) -> dict[str, int]:
    ranges = {
        "curves": (1, None), "segments": (2, None), "fit_size": (1, None), "iterations": (1, None),
        "initial_curves": (1, None), "inflation_gap": (1, None), "recycle_gap": (0, None),
        "replace_gap": (1, None),
        # float32 has seven digits, and one at least stands before the point.
        "precision": (0, 6), "degree": (2, 12), "samples": (2, None), "lines": (1, None),
        # The generators take a signed 64-bit seed.
        "seed": (0, 2**63 - 1),
    }  # fmt: skip
    counts = {name: check_count(name, getattr(config, name), *limits) for name, limits in ranges.items()}
    return counts if config.threads is None else {**counts, "threads": check_count("threads", config.threads, 1)}


def _numbers(config: FitConfig) -> dict[str, float]:
    ranges = {
        "growth": (1.0, math.inf), "initial_radius": (0.0, math.inf), "radius_decay": (0.0, 1.0),
        "prune_opacity": (0.0, 1.0), "recycle_share": (0.0, 1.0), "recycle_until": (0.0, 1.0),
        "lr_points": (0.0, math.inf), "lr_color": (0.0, math.inf), "lr_opacity": (0.0, math.inf),
        "lr_scale": (0.0, math.inf), "lr_final": (0.0, 1.0), "opacity_weight": (0.0, math.inf),
        "xing_weight": (0.0, math.inf), "bezier_weight": (0.0, math.inf), "coarse_until": (0.0, 1.0),
    }  # fmt: skip
    numbers = {name: check_number(name, getattr(config, name), *limits) for name, limits in ranges.items()}
    return numbers if config.time_budget is None else {**numbers, "time_budget": _time_budget(config.time_budget)}


def _time_budget(value: Any) -> float:
    seconds = as_float(value)
    if not seconds > 0:
        raise InputError(
            f"time_budget must be a finite number of seconds above 0, got {show(value)}; leave it out for no limit"
        )
    return seconds


def _check_choices(config: FitConfig) -> None:
    choices = {
        "renderer": RENDERERS, "path_model": PATH_MODELS, "backdrop": BACKDROPS, "policy": POLICIES,
        "z_order": Z_ORDERS, "color_parameter": COLOR_PARAMETERS, "lr_decay": LR_DECAYS,
    }  # fmt: skip
    for name, allowed in choices.items():
        check_choice(name, getattr(config, name), allowed)
    for name in ("shorten_gap", "compensate", "flat", "interior_gradient", "covariance_gradient"):
        check_flag(name, getattr(config, name))
    # Which devices there are is asked where the fit starts: to find out takes seconds.
    if not isinstance(config.device, str):
        raise InputError(f"device must be a name, got {show(config.device)}; give 'auto', 'cpu', 'cuda' or 'cuda:K'")


def _check_path_model(config: FitConfig) -> None:
    if config.path_model == "sides" and config.renderer != "splat":
        raise InputError(
            f"path_model must be segments with the renderer {config.renderer}, got 'sides'; give segments, or the"
            " renderer splat"
        )


def _check_growth(config: FitConfig) -> None:
    if 1.0 < config.growth < GROWTH_MIN:
        raise InputError(f"growth must be 1 or at least {GROWTH_MIN}, got {config.growth}; give {GROWTH_MIN} or more")
    starts_whole = config.flat or config.policy != "scaffolding" or config.initial_curves >= config.curves
    if config.growth == 1.0 and not starts_whole:
        raise InputError(
            f"growth must be more than 1 to get from initial_curves {config.initial_curves} to {config.curves} curves,"
            " got 1.0; set flat to start with all of them"
        )
