"""Figures of drawings that a search has made."""

from __future__ import annotations

from warpvec.goals.search import Trial


def trial(
    asked: int = 100, size: int = 10_000, psnr: float = 25.0, curves: int | None = None, eligible: bool = True
) -> Trial:
    """Return the figures of a drawing for goals of bytes and PSNR."""
    figures = {"max_bytes": size, "target_psnr": psnr}
    return Trial(asked, asked if curves is None else curves, size, psnr, figures, size, psnr, eligible)
