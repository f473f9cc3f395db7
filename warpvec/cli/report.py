"""What a command says of a file, for people or as JSON."""

from __future__ import annotations

import json
import math
from typing import Any

import click

from warpvec.vectorization.goal import describe

_INTERNAL_IMAGES = {"exact": "internally", "splat": "in the soft image"}
"""Renderer of the fit -> where the summary says the internal PSNR is from."""


def report(metrics: dict[str, Any], out: str, as_json: bool) -> None:
    text = json.dumps(_finite(metrics), allow_nan=False) if as_json else _summary(metrics, out)
    click.echo(text, err=out == "-")


def _finite(value: Any) -> Any:
    """``value`` with None for each infinite number in it."""
    if isinstance(value, dict):
        return {name: _finite(item) for name, item in value.items()}
    if isinstance(value, list):
        return [_finite(item) for item in value]
    return None if value in (math.inf, -math.inf) else value


def _summary(metrics: dict[str, Any], out: str) -> str:
    """What a person wants to know of the file, and of the fit where there was one."""
    lines = [
        "{out}: {curves} curves, {segments} segments, {bytes:,} bytes, {gzip_bytes:,} gzipped",
        "PSNR {psnr:.2f} dB, SSIM {ssim:.4f}, as resvg draws the file",
    ]
    if metrics["transparent"]:
        lines[1] += " over black and over white"
    if "internal_psnr" in metrics:
        lines[1] += "; {internal_psnr:.2f} dB " + _INTERNAL_IMAGES[metrics["renderer"]]
        if metrics["degree"] != 3:
            lines.append("sides of degree {degree} written as cubics within {conversion_px:.3f} px")
        lines.append("{iterations} iterations in {seconds:.1f} s on {device}")
    if metrics.get("levels"):
        parts = (f"{level['curves']} curves {level['psnr']:.2f} dB" for level in metrics["levels"])
        lines.append("up to each level: " + ", ".join(parts))
    if metrics.get("goal"):
        lines.append(describe(metrics["goal"]))
    return "\n".join(lines).format(out="SVG" if out == "-" else out, **metrics)
