"""Every setting has a range, and every error is one line with the field, the rule and the value."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from warpvec.config.fit_config import FitConfig
from warpvec.config.limits import GROWTH_MIN
from warpvec.errors import InputError

COUNTS = ("curves", "iterations", "fit_size", "initial_curves", "inflation_gap")

LONGEST = 500
"""Most characters of a message, which is read as one line."""

BAD = [
    *[(name, value) for name in COUNTS for value in (0, -3)],
    ("segments", 1), ("precision", -1), ("seed", -1), ("recycle_gap", -1), ("threads", 0),
    ("curves", 1.5), ("curves", "512"), ("curves", True), ("iterations", math.nan),
    ("growth", 0.5), ("growth", math.inf), ("initial_radius", -1.0), ("radius_decay", 1.5), ("radius_decay", math.nan),
    ("prune_opacity", 2.0), ("recycle_share", -0.1), ("recycle_until", 1.1), ("lr_final", 1.1),
    *[(name, -1.0) for name in ("lr_points", "lr_color", "lr_opacity", "lr_scale")],
    *[(name, math.nan) for name in ("opacity_weight", "ssim_weight", "xing_weight", "bezier_weight")],
    ("time_budget", 0.0), ("time_budget", -1.0), ("time_budget", math.nan),
    ("time_budget", math.inf), ("time_budget", 10**400), ("time_budget", 10**480), ("precision", 7),
    ("precision", 400), ("seed", 2**63),
    ("growth", 1.00001), ("growth", math.nextafter(GROWTH_MIN, 1.0)), ("lr_points", 10**400),
    ("renderer", "fast"), ("z_order", "random"), ("color_parameter", "lab"), ("lr_decay", "step"),
    ("replace_gap", 0), ("backdrop", "black"), ("policy", "flat"), ("path_model", "cubics"),
    ("degree", 1), ("degree", 13), ("samples", 1),
    ("lines", 0),
]  # fmt: skip


@pytest.mark.parametrize(("name", "value"), BAD)
def test_bad_values_are_reported_in_one_line(name: str, value: Any) -> None:
    with pytest.raises(InputError) as caught:
        FitConfig(**{name: value})
    message = str(caught.value)
    assert message.startswith(f"{name} must") and "\n" not in message
    assert len(message) <= LONGEST
    assert repr(value)[:80] in message or str(value)[:80] in message


WRONG_TYPES = [
    ("lr_points", "a"), ("lr_points", None), ("lr_points", True), ("growth", 2j), ("growth", "2"),
    ("time_budget", "3"), ("time_budget", True),
    ("threads", "2"), ("threads", 1.5), ("threads", True), ("curves", None), ("curves", 5.0), ("curves", np.float32(5)),
    ("one_generation", "no"), ("one_generation", 1), ("one_generation", None), ("compensate", 0),
    ("renderer", 3), ("renderer", ["exact"]), ("z_order", None), ("lr_decay", np.zeros(2)), ("device", 0),
    ("backdrop", 1), ("policy", None), ("replace_gap", 1.5), ("interior_gradient", "on"),
    ("covariance_gradient", 1), ("path_model", None), ("degree", 5.0),
    ("lr_color", np.zeros((2, 2))), ("curves", np.zeros((2, 2))),
]  # fmt: skip


@pytest.mark.parametrize(("name", "value"), WRONG_TYPES)
def test_wrong_types_are_reported_like_wrong_values(name: str, value: Any) -> None:
    with pytest.raises(InputError, match=f"^{name} must .*, got ") as caught:
        FitConfig(**{name: value})
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("given", "kept"),
    [
        ("red,blue", "#ff0000,#0000ff"),
        ("#123, RebeccaPurple ,#A0B1C2,#112233", "#112233,#663399,#a0b1c2"),
        ("#010203", "#010203"),
    ],
)
def test_a_palette_is_kept_in_one_form(given: str, kept: str) -> None:
    assert FitConfig(palette=given).palette == kept
    assert FitConfig(palette=kept).palette == kept


@pytest.mark.parametrize("palette", ["", "red,", "red blue", "#12345", "crimsn", 5, ["red", 5], [], "rgb(1,2,3)"])
def test_other_palettes_are_refused(palette: Any) -> None:
    with pytest.raises(InputError, match="^palette must be colours such as 'red,#123,#a0b1c2', got .*; give one"):
        FitConfig(palette=palette)


def test_a_palette_of_every_grey_keeps_its_8_bits() -> None:
    greys = ",".join(f"#{level:02x}{level:02x}{level:02x}" for level in range(256))
    assert FitConfig(palette=greys).palette == greys


def test_only_splat_draws_sides() -> None:
    with pytest.raises(
        InputError, match="path_model must be segments with the renderer exact, got 'sides'; "
    ) as caught:
        FitConfig(path_model="sides")
    assert "\n" not in str(caught.value)
    assert "samples" not in FitConfig(samples=8).render_settings


@pytest.mark.parametrize(
    "settings",
    [
        {"curves": 1}, {"precision": 0}, {"seed": 0}, {"recycle_gap": 0}, {"threads": None}, {"threads": 1},
        {"time_budget": None}, {"time_budget": 0.5}, {"recycle_share": 0.0}, {"recycle_share": 1.0},
        {"initial_radius": 0.0}, {"opacity_weight": 0.0}, {"segments": 2},
        {"growth": GROWTH_MIN}, {"replace_gap": 1}, {"samples": 2},
        {"lines": 1}, {"degree": 2}, {"degree": 12}, {"precision": 6}, {"seed": 2**63 - 1},
    ],
)  # fmt: skip
def test_values_at_the_ends_of_their_ranges_are_accepted(settings: dict[str, Any]) -> None:
    config = FitConfig(**settings)
    assert all(getattr(config, name) == value for name, value in settings.items())


def test_a_population_that_does_not_grow_is_refused_unless_it_starts_full() -> None:
    with pytest.raises(
        InputError, match="growth must be above 1, because initial_curves 16 is below curves 512, got 1.0; give"
    ):
        FitConfig(growth=1.0)
    assert FitConfig(growth=1.0, one_generation=True).growth == 1.0
    assert FitConfig(growth=1.0, policy="replacement").growth == 1.0
    assert FitConfig(growth=1.0, curves=16).curves == 16
