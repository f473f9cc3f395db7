"""The entries of this room in the registries of warpvec."""

from __future__ import annotations

from typing import Any

from warpvec.config.preset import Preset
from warpvec.config.rooms import Room
from warpvec.paper.settings import PaperSettings, check

_MODEL: dict[str, Any] = {
    "mode": "photo",
    "path_model": "sides",
    "backdrop": "white",
    "renderer": "splat",
    "color_parameter": "logit",
    "opacity_weight": 0.01,
    "ssim_weight": 0.0,
    "bezier_weight": 1.0,
    "axis_rates": True,
    "common_age": True,
    "color_falloff": True,
}
"""What both papers, or their authors' codes, have in common."""

RELEASED_PRUNE_OPACITY = 0.5024999791668749
"""The sigmoid of 0.01. The code compares the logit of an opacity, not the opacity, with the paper's 0.01."""

_PAPER: dict[str, Any] = {
    **_MODEL,
    "iterations": 5000,
    "policy": "stratification",
    "inflation_gap": 100,
    "recycle_gap": 0,
    "samples": 128,
    "lr_points": 0.01,
    "lr_color": 0.5,
    "lr_opacity": 0.5,
    "lr_decay": "constant",
    "without_projection": True,
}
"""The settings of the paper. Where the paper is silent, they are those of its authors' code."""

PRESETS = {
    "paper": Preset("Vector Scaffolding as published (splat renderer); slow.", _PAPER),
    "paper-released": Preset(
        "The same as its authors' code has it; slow.",
        {
            **_PAPER,
            "prune_opacity": RELEASED_PRUNE_OPACITY,
            "compensate": False,
            "released_adjoint": True,
            "side_opacities": True,
        },
    ),
    "bezier-splatting": Preset(
        "The paper's flat baseline: all paths at once; very slow.",
        {
            **_MODEL,
            "iterations": 10_000,
            "interior_gradient": False,
            "policy": "replacement",
            "z_order": "area",
            "recycle_gap": 0,
            "lr_points": 2e-4,
            "lr_color": 0.01,
            "lr_opacity": 0.01,
            "lr_decay": "steps",
            "xing_weight": 0.0,  # the published code of the baseline switches this term off
        },
    ),
}

ROOM = Room(
    settings=PaperSettings,
    check=check,
    presets=PRESETS,
    renderers={"splat": "warpvec.paper.splat:SplatRenderer"},
    path_models={"sides": "warpvec.paper.sides:Sides"},
    policies={
        "replacement": "warpvec.paper.replacement:Replacement",
        "stratification": "warpvec.paper.stratification:Stratification",
    },
    words={
        "splat": "the paper's Gaussians",
        "sides": "two curves, for splat",
        "replacement": "Bezier Splatting's",
        "stratification": "its code's",
    },
    short_fits=(
        {"preset": "paper", "samples": 2, "lines": 1},
        {"preset": "paper", "samples": 2, "lines": 1, "covariance_gradient": True, "color_falloff": False},
        {"preset": "paper-released", "samples": 2, "lines": 1},
    ),
)
