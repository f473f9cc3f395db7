"""The numbers that the paper (Vector Scaffolding) prints, by table and figure; all measure its own soft image."""

from __future__ import annotations

from typing import NamedTuple


class Quality(NamedTuple):
    """PSNR in dB, SSIM and LPIPS."""

    psnr: float
    ssim: float
    lpips: float


# The paper's "ours" is the preset "paper", its "Bezier Splatting" the preset "bezier-splatting".
Quantitative = dict[tuple[str, int], Quality]

TABLE_1: Quantitative = {
    ("bezier-splatting", 256): Quality(24.19, 0.621, 0.519),
    ("bezier-splatting", 512): Quality(25.61, 0.664, 0.485),
    ("bezier-splatting", 1024): Quality(26.91, 0.708, 0.448),
    ("paper", 256): Quality(25.18, 0.631, 0.427),
    ("paper", 512): Quality(26.68, 0.687, 0.353),
    ("paper", 1024): Quality(28.30, 0.749, 0.275),
}
"""The 24 photos of the Kodak set: (preset, curves) -> means."""

TABLE_2: Quantitative = {
    ("bezier-splatting", 256): Quality(20.74, 0.580, 0.546),
    ("bezier-splatting", 512): Quality(22.11, 0.607, 0.528),
    ("bezier-splatting", 1024): Quality(23.45, 0.639, 0.507),
    ("paper", 256): Quality(21.37, 0.564, 0.548),
    ("paper", 512): Quality(22.64, 0.598, 0.503),
    ("paper", 1024): Quality(23.99, 0.640, 0.450),
}
"""DIV2K: (preset, curves) -> means."""

BASELINE_NOTE_1 = "Its rows of Bezier Splatting are as Bezier Splatting prints them."
BASELINE_NOTE_2 = "Its rows of Bezier Splatting are as printed there, over 200 pictures of DIV2K; its own are over 800."
COLUMNS_NOTE = (
    "Its SSIM can be compared with SSIM (Gaussian 11) alone, and its LPIPS with LPIPS (VGG, fed [0, 1]) alone: the "
    "evaluation that its authors released takes both so. No other column has a value of the paper."
)
"""What can be compared with what. The paper's figure 1 (b) shows that it is 2.6, 2.1 and 1.5 times as fast as Bezier
Splatting at 256, 512 and 1024 curves; its times of Bezier Splatting are those that this prints."""

INTERIOR = {"off": 23.4553, "on": 28.0802}
"""Figure "Effect of Interior Gradients", kodim07. The number of curves is not printed; figures beside it have 512."""

HIERARCHY = {("flat", 1): 24.4731, ("flat", 50): 19.1911, ("hierarchical", 50): 24.6808}
"""Figure "Hierarchical Scaffolding vs. Flat Optimization", DIV2K 0383: (strategy, learning rate multiplier) -> dB."""


class Sweep(NamedTuple):
    """A panel of Table 3: mean PSNR in dB for each value of a setting, and its range, by number of iterations.

    The ranges are as printed; that of the inflation gap after 5000 iterations, 0.19, is 0.12 by the values beside it.
    """

    title: str
    setting: str
    values: tuple[float, ...]
    default: float
    psnr: dict[int, tuple[float, ...]]
    spread: dict[int, float]


TABLE_3 = {
    "lr": Sweep(
        "(a) learning rate multiplier",
        "lr_scale",
        (1, 5, 10, 50, 100),
        50,
        {1000: (23.48, 25.79, 26.16, 26.95, 26.91), 5000: (25.83, 27.07, 27.38, 27.95, 27.84)},
        {1000: 3.47, 5000: 2.12},
    ),
    "radius": Sweep(
        "(b) radius decay",
        "radius_decay",
        (0.1, 0.25, 0.5, 0.75, 1.0),
        0.5,
        {1000: (26.40, 26.68, 26.96, 26.93, 24.33), 5000: (27.80, 27.92, 27.94, 27.85, 25.30)},
        {1000: 2.63, 5000: 2.64},
    ),
    "gap": Sweep(
        "(c) inflation gap",
        "inflation_gap",
        (25, 50, 100, 200, 400),
        100,
        {1000: (27.27, 27.16, 26.97, 23.81, 21.39), 5000: (27.85, 27.93, 27.93, 27.97, 27.95)},
        {1000: 5.87, 5000: 0.19},
    ),
}
"""Table 3: four photos of the Kodak set. The paper prints neither their names nor the number of curves."""

LR_REFERENCE = 50
"""Multiplier of the paper's own learning rates. Its multipliers are in units of Bezier Splatting's rates."""

TRAJECTORY = (100, 600, 1600, 4000, 9980)
"""Iterations of the frames of kodim01 that the paper prints."""
