"""The settings of the splat renderer, of paths of two sides, and of the policy "replacement"."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, cast

from warpvec.config.kinds import Flag, Whole
from warpvec.config.limits import MAX_COUNT
from warpvec.config.setting import photo_setting
from warpvec.errors import InputError

SPLAT, REPLACEMENT = "Renderer splat", "Policy replacement"

COUNT_MAX = 1024
"""Most Gaussians on a line, and most lines of a path. A path of a thousand pixels needs no more."""

MAX_GAUSSIANS = 2**26
"""Largest number of Gaussians of all paths, enough for a goal with the default of a path; they take gigabytes."""


@dataclass(frozen=True, kw_only=True)
class PaperSettings:
    """Settings that this room adds to `warpvec.config.fit_config.FitConfig`."""

    degree: int = photo_setting(5, Whole(2, 12), "Degree of the curves of --path-model sides.", SPLAT)
    """M, the degree of both curves in the model "sides"; a path has 2 * degree control points."""
    samples: int = photo_setting(
        64, Whole(2, COUNT_MAX), "Number of Gaussians along each side and line of a path.", SPLAT, renderer="splat"
    )
    """Gaussians along each side of a path, and along each line between the sides."""
    lines: int = photo_setting(
        40, Whole(1, COUNT_MAX), "Number of lines of Gaussians between the two sides of a path.", SPLAT,
        renderer="splat",
    )  # fmt: skip
    """Lines of Gaussians between the two sides of a path."""
    interior_gradient: bool = photo_setting(
        True, Flag(), "Let the Gaussians inside a path move its control points.", SPLAT, renderer="splat"
    )
    """Interior Gradient Aggregation: the Gaussians inside a path move its control points too, not only the Gaussians on
    its sides."""
    covariance_gradient: bool = photo_setting(
        False, Flag(), "Let the sizes and directions of Gaussians move the control points.", SPLAT, renderer="splat"
    )
    """Differentiate the sizes and directions of the Gaussians too, not only their positions."""
    released_adjoint: bool = photo_setting(
        False, Flag(), "Clip opacities in the adjoint as the code of Vector Scaffolding does.", SPLAT,
        renderer="splat", stated="if used",
    )  # fmt: skip
    """In the adjoint, clip the alpha of a Gaussian at 0.99 and not at 0.999, and let it have a derivative where it is
    clipped, as the released code does."""
    side_opacities: bool = photo_setting(
        False, Flag(), "Let opacity change from side A over the middle to side B of a path.", SPLAT, stated="if used"
    )
    """Give each path three opacities, as the released code does; pruning and the file take that in the middle. Only the
    policy "stratification" does so, if opacities are free."""
    color_falloff: bool = photo_setting(
        False, Flag(), "Let Gaussians near the middle of a path count less for its colour.", SPLAT, renderer="splat",
        stated="if used",
    )  # fmt: skip
    """Weaken the gradient of a path's colour through the Gaussians near its middle, as the code of both papers does."""
    without_projection: bool = photo_setting(
        False, Flag(), "Leave the projection out of the Bezier regularizer of --path-model sides.", SPLAT,
        stated="if used",
    )  # fmt: skip
    """Leave out the term that keeps the inner control points of a side between its ends, with Bezier Splatting's weight
    of 0.01 inside the Bezier regularizer. Vector Scaffolding's code has none."""
    replace_gap: int = photo_setting(
        500, Whole(1, MAX_COUNT), "Iterations from removing paths to adding as many, and until the next removal.",
        REPLACEMENT,
    )  # fmt: skip
    """Iterations from removing paths to adding as many, and from the addition to the next removal."""


def paper_settings(config: object) -> PaperSettings:
    """Return the settings of a run as settings of this room."""
    return cast(PaperSettings, config)


def check(settings: Mapping[str, Any]) -> None:
    """Raise InputError for values that do not go together."""
    if settings["policy"] == "stratification" and settings["path_model"] != "sides":
        rule = "must be sides with the policy stratification"
        raise InputError("path_model", rule, repr(settings["path_model"]), "give sides, or the policy scaffolding")
    if settings["path_model"] == "sides" and settings["renderer"] != "splat":
        rule = f"must be segments with the renderer {settings['renderer']}"
        raise InputError("path_model", rule, "'sides'", "give segments, or the renderer splat")
    curves, samples, lines = settings["curves"], settings["samples"], settings["lines"]
    if settings["renderer"] == "splat" and curves * samples * (lines + 2) > MAX_GAUSSIANS:
        rule = f"times lines + 2 times curves must be at most {MAX_GAUSSIANS} Gaussians"
        raise InputError("samples", rule, f"{samples} times {lines + 2} times {curves}", "give fewer of any")
