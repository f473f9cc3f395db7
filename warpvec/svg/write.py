"""Write a scene as SVG text, which states exactly the scene that `quantize` returns."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import replace
from typing import Any
from xml.sax.saxutils import escape, quoteattr

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from warpvec import __version__
from warpvec.geometry.scene import Scene

OPACITY_DECIMALS = 2
"""Decimals of opacities. Half a step changes a blend of black and white by 1.3 of 255 levels; a third decimal costs
4 % of a file's bytes."""

MIN_HANDLE_DECIMALS = 1
"""Fewest decimals of handles, which have one fewer than anchors: see `quantize`."""

COLOR_LEVELS = 255
"""Largest level of a colour channel, which is written as two hexadecimal digits."""

MAX_TICKS = 2.0**53
"""Largest coordinate in ticks (units of the last decimal). Ticks are computed in float64, which is exact up to here."""

# XML 1.0 forbids these characters even escaped, and file names may contain them.
_ILLEGAL_IN_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def quantize(scene: Scene, precision: int, opacity_decimals: int = OPACITY_DECIMALS) -> Scene:
    """Return the scene as its file will state it, for rendering exactly what is exported.

    Coordinates have ``precision`` decimals, colours 8 bits, opacities ``opacity_decimals`` decimals. Colours and
    opacities outside [0, 1] are clamped. Handles are rounded more coarsely than anchors (to 0.1 px at two decimals),
    relative to the start of their segment. This saves 9 % of the file at 512 paths and costs 0.003 dB: a handle moves
    its curve by at most 4/9 of its own move. Paths whose opacity rounds to 0 are removed, as in the file. Quantizing
    twice changes nothing more. Device and dtype are kept, gradients are not.

    Raises:
        ValueError: the paths are not cubic, a value is not finite, or a coordinate is 2**53 units of the last decimal
            or more.
    """
    scene = scene.detach()
    _check_cubic(scene)
    _check_finite(scene, precision)
    quantized = replace(
        scene.with_points(_rounded_points(scene.points, precision)),
        color=_rounded(scene.color.clamp(0, 1), COLOR_LEVELS),
        opacity=_rounded(scene.opacity.clamp(0, 1), 10**opacity_decimals),
        background=_rounded(scene.background.clamp(0, 1), COLOR_LEVELS),
    )
    return quantized.select(quantized.opacity > 0)


def write_svg(
    scene: Scene,
    width: int,
    height: int,
    *,
    precision: int = 2,
    opacity_decimals: int = OPACITY_DECIMALS,
    title: str | None = None,
    metadata: dict[str, Any] | None = None,
) -> str:
    """Return the SVG text of ``quantize(scene)`` on a canvas of ``width`` x ``height`` user units.

    The text has a background rectangle unless the scene is transparent, then one group per run of equal generation (a
    layer in Inkscape, a named group in other editors), with one path per line. Cubics of no length are left out, such
    as those that pad a path to the segment count of another. ``metadata`` is stored as JSON with the version of
    warpvec; None leaves out that element. The text depends on the arguments alone: it has no dates and no file paths.

    Raises:
        ValueError: as `quantize`, or ``metadata`` cannot be written as JSON.
    """
    scene = quantize(scene, precision, opacity_decimals).cpu()
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        '<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"'
        f' width="{width}" height="{height}" viewBox="0 0 {width} {height}">',
        *_description(title, metadata),
        *_background(scene, width, height),
        *_layers(scene.generation.numpy(), _path_elements(scene, precision, opacity_decimals)),
        "</svg>",
    ]
    return "\n".join(lines) + "\n"


def format_number(ticks: int, decimals: int) -> str:
    """Return ``ticks / 10**decimals`` in the fewest characters that SVG allows: "12.5", "-.25", "0"."""
    whole, fraction = divmod(abs(ticks), 10**decimals)
    digits = f"{fraction:0{decimals}d}".rstrip("0")
    text = (str(whole) if whole or not digits else "") + ("." + digits if digits else "")
    return "-" + text if ticks < 0 else text


def _check_cubic(scene: Scene) -> None:
    if scene.degree != 3:
        raise ValueError(
            f"scene must have degree 3 to be written, got {scene.degree};"
            " convert it with warpvec.geometry.cubics.to_cubics"
        )


def _check_finite(scene: Scene, precision: int) -> None:
    for name in ("segments", "color", "opacity", "background"):
        if not torch.isfinite(getattr(scene, name)).all():
            raise ValueError(f"{name} of a scene must be finite to be written; check what made it")
    if len(scene) and scene.segments.abs().max().double() * 10**precision >= MAX_TICKS:
        raise ValueError(f"points must be within 2**53 steps of 1e-{precision} of the origin to be written")


def _ticks(values: Tensor, per_unit: int) -> Tensor:
    """Return ``values`` as the nearest integers (int64) in units of ``1 / per_unit``.

    They are computed in float64, so that a value rounded to a tick and stored in float32 gives the same tick again.
    """
    return (values.double() * per_unit).round().long()


def _rounded(values: Tensor, per_unit: int) -> Tensor:
    return (_ticks(values, per_unit).double() / per_unit).to(values.dtype)


def _rounded_points(points: Tensor, precision: int) -> Tensor:
    """Round anchors to whole ticks, and the two handles of each segment to whole handle steps from its start."""
    ticks = points.double().reshape(len(points), points.shape[1] // 3, 3, 2) * 10**precision
    anchor = ticks[:, :, :1].round()
    step = 10 ** (precision - min(precision, max(precision - 1, MIN_HANDLE_DECIMALS)))
    rounded = anchor + ((ticks - anchor) / step).round() * step
    return (rounded.flatten(1, 2) / 10**precision).to(points.dtype)


def _description(title: str | None, metadata: dict[str, Any] | None) -> Iterator[str]:
    if title is not None:
        yield f"<title>{_xml_text(title)}</title>"
    if metadata is not None:
        origin = {"generator": f"warpvec {__version__}", **metadata}
        yield f"<metadata>{_xml_text(json.dumps(origin, allow_nan=False))}</metadata>"


def _xml_text(text: str) -> str:
    return escape(_ILLEGAL_IN_XML.sub("\N{REPLACEMENT CHARACTER}", text))


def _background(scene: Scene, width: int, height: int) -> Iterator[str]:
    if not scene.transparent:
        fill = _hex_colors(scene.background[None])[0]
        yield f'<rect id="background" width="{width}" height="{height}" fill="{fill}"/>'


def _layers(generation: NDArray[np.int64], elements: list[str]) -> Iterator[str]:
    """Yield ``elements`` in one group per run of equal generation; the running number keeps ids unique."""
    starts = np.flatnonzero(np.diff(generation, prepend=generation[:1] - 1)).tolist()
    stops = (np.flatnonzero(np.diff(generation, append=generation[-1:] + 1)) + 1).tolist()
    for number, (start, stop) in enumerate(zip(starts, stops, strict=True), 1):
        plural = "path" if stop - start == 1 else "paths"
        label = f"Layer {number}: generation {generation[start]}, {stop - start} {plural}"
        identifier = f"layer-{number}-generation-{generation[start]}"
        yield f'<g id="{identifier}" inkscape:groupmode="layer" inkscape:label={quoteattr(label)}>'
        yield from elements[start:stop]
        yield "</g>"


def _path_elements(scene: Scene, precision: int, opacity_decimals: int) -> list[str]:
    data = _path_data(_ticks(scene.points, 10**precision).numpy(), precision)
    opaque = 10**opacity_decimals
    opacity = _ticks(scene.opacity, opaque).tolist()
    return [
        f'<path fill="{fill}"{_opacity_attribute(ticks, opacity_decimals) if ticks < opaque else ""} d="{d}"/>'
        for fill, ticks, d in zip(_hex_colors(scene.color), opacity, data, strict=True)
    ]


def _opacity_attribute(ticks: int, decimals: int) -> str:
    return f' fill-opacity="{format_number(ticks, decimals)}"'


def _hex_colors(color: Tensor) -> list[str]:
    """Return ``#rrggbb``, or ``#rgb`` if that is the same colour, for each row of ``color`` [N, 3]."""
    names = (bytes(levels).hex() for levels in _ticks(color, COLOR_LEVELS).tolist())
    return ["#" + (name[::2] if name[::2] == name[1::2] else name) for name in names]


def _path_data(ticks: NDArray[np.int64], decimals: int) -> list[str]:
    """Return path data of closed cubics with control points ``ticks`` [N, 3 S, 2], without those of no length.

    The data has differences of rounded positions, not rounded differences, so that a reader's sum is exact.
    """
    anchor = ticks[:, ::3]
    control = np.stack([ticks[:, 1::3], ticks[:, 2::3], np.roll(anchor, -1, axis=1)], axis=2)
    relative = (control - anchor[:, :, None]).reshape(len(ticks), anchor.shape[1], 6)
    drawn = (relative != 0).any(axis=2)
    # A path that is a single point keeps one cubic, because "c" needs arguments.
    drawn[:, 0] |= ~drawn.any(axis=1)
    heads = _number_lists(ticks[:, 0].ravel(), np.full(len(ticks), 2), decimals)
    tails = _number_lists(relative[drawn].ravel(), 6 * drawn.sum(axis=1), decimals)
    return [f"M{head}c{tail}z" for head, tail in zip(heads, tails, strict=True)]


def _number_lists(ticks: NDArray[np.int64], counts: NDArray[np.int64], decimals: int) -> list[str]:
    """Format ``ticks`` [sum of ``counts``] as SVG number lists of ``counts`` [N] numbers each, none of them empty.

    Two numbers need no space between them if the second starts with a minus sign, or with a point while the first
    already contains one.
    """
    per_unit = 10**decimals
    distinct, index = np.unique(ticks, return_inverse=True)
    words = [format_number(value, decimals) for value in distinct.tolist()]
    vocabulary = np.array([*words, *(" " + word for word in words)], dtype=object)
    has_point = ticks % per_unit != 0
    separates = ticks < 0
    separates[1:] |= (ticks[1:] < per_unit) & has_point[1:] & has_point[:-1]
    stops = counts.cumsum()
    starts = stops - counts
    separates[starts] = True
    chosen = vocabulary[index + np.where(separates, 0, len(words))].tolist()
    return ["".join(chosen[start:stop]) for start, stop in zip(starts.tolist(), stops.tolist(), strict=True)]
