"""Write a scene as SVG text, which states exactly the scene that `quantize` returns."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import pairwise
from typing import Any
from xml.sax.saxutils import escape, quoteattr

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from warpvec import __version__
from warpvec.geometry.gradients import FLAT, LINEAR, RADIAL, Gradients
from warpvec.geometry.scene import Scene, straightened
from warpvec.geometry.structure import Structure
from warpvec.svg.path_data import format_curves, format_number, format_path

GRADIENT_DECIMALS = 1
"""Decimals of the ends of gradients: half a step moves a colour by less than a level unless the gradient is shorter
than 13 px from black to white."""

GRADIENT_ELEMENTS = {
    LINEAR: ("linearGradient", ("x1", "y1", "x2", "y2")),
    RADIAL: ("radialGradient", ("cx", "cy", "r")),
}
"""Kind of paint -> its element, and the attributes that hold its geometry."""

OPACITY_DECIMALS = 2
"""Decimals of opacities. Half a step changes a blend of black and white by 1.3 of 255 levels; a third decimal costs
4 % of a file's bytes."""

MIN_HANDLE_DECIMALS = 1
"""Fewest decimals of handles, which have one fewer than anchors: see `quantize`."""

COLOR_LEVELS = 255
"""Largest level of a colour channel, which is written as two hexadecimal digits."""

TICK_ERROR, TICK_ERROR_SHARE = 1e-3, 2.5e-7
"""A point counts as at a tick within so many ticks, and this share of its place: float32 has 24 bits, and a drawing is
scaled to the file's units and back. That all points of a path lie so near by chance does not happen."""

MAX_TICKS = 2.0**53
"""Largest coordinate in ticks (units of the last decimal). Ticks are computed in float64, which is exact up to here."""

# XML 1.0 forbids these characters even escaped, and file names may contain them.
_ILLEGAL_IN_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def quantize(scene: Scene, precision: int, opacity_decimals: int = OPACITY_DECIMALS) -> Scene:
    """Return the scene as its file will state it, for rendering exactly what is exported.

    Coordinates have ``precision`` decimals, colours 8 bits, opacities ``opacity_decimals`` decimals, ends of gradients
    ``GRADIENT_DECIMALS``. Colours and opacities outside [0, 1] are clamped. Gradients of one colour become flat.
    Handles are rounded more coarsely than anchors (to 0.1 px at two decimals), relative to the start of their segment.
    This saves 9 % of the file at 512 paths and costs 0.003 dB: a handle moves its curve by at most 4/9 of its own move.
    A path whose points all have ``precision`` decimals already keeps them. Handles of lines are at thirds. Paths whose
    opacity rounds to 0 are removed, as in the file. Quantizing twice changes nothing more. Device and dtype are kept,
    derivatives are not.

    Raises:
        ValueError: the paths are not cubic, a value is not finite (except for the ends of a gradient, which then
            shows its end colour), or a coordinate is 2**53 units of the last decimal or more.
    """
    scene = _with_needed_gradients(_without_far_gradients(scene.detach()))
    _check_cubic(scene)
    _check_finite(scene, precision)
    quantized = replace(
        scene,
        segments=_rounded_segments(scene.segments, scene.structure, precision),
        gradients=_rounded_gradients(scene.gradients),
        color=_rounded(scene.color.clamp(0, 1), COLOR_LEVELS),
        opacity=_rounded(scene.opacity.clamp(0, 1), 10**opacity_decimals),
        background=_rounded(scene.background.clamp(0, 1), COLOR_LEVELS),
    )
    return _with_needed_gradients(quantized.select(quantized.opacity > 0))


def write_svg(
    scene: Scene,
    width: int,
    height: int,
    *,
    precision: int = 2,
    opacity_decimals: int = OPACITY_DECIMALS,
    title: str | None = None,
    metadata: dict[str, Any] | None = None,
    sides: tuple[str, str] | None = None,
    layer_names: Mapping[int, str] | None = None,
) -> str:
    """Return the SVG text of ``quantize(scene)`` on a canvas of ``width`` x ``height`` user units.

    The text has a background rectangle unless the scene is transparent, then one group per run of equal generation (a
    layer in Inkscape, a named group in other editors), with one path per line. Cubics of no length are left out, such
    as those that pad a path to the segment count of another. Gradients stand before the background. ``metadata`` is
    stored as JSON with the version of warpvec; None leaves out that element. ``sides`` are the attributes width and
    height with their units, None for pixels. ``layer_names`` maps a generation to its name; a name must not occur
    twice. The text depends on the arguments alone: it has no dates and no file paths.

    Raises:
        ValueError: as `quantize`, or ``metadata`` cannot be written as JSON.
    """
    scene = quantize(scene, precision, opacity_decimals).cpu()
    fills, definitions = fills_of(scene)
    sides = sides or (str(width), str(height))
    elements = _path_elements(scene, precision, opacity_decimals, fills)
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        '<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"'
        f' width="{sides[0]}" height="{sides[1]}" viewBox="0 0 {width} {height}">',
        *_description(title, metadata),
        *definitions,
        *_background(scene, width, height),
        *_layers(scene.generation.numpy(), elements, layer_names or {}),
        "</svg>",
    ]
    return "\n".join(lines) + "\n"


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
    if scene.gradients is None:
        return
    if not torch.isfinite(scene.gradients.end_color).all():
        raise ValueError("end colours of gradients must be finite to be written; check what made them")


def ticks_of(values: Tensor, per_unit: int) -> Tensor:
    """Return ``values`` as the nearest integers (int64) in units of ``1 / per_unit``.

    They are computed in float64, so that a value rounded to a tick and stored in float32 gives the same tick again.
    """
    return (values.double() * per_unit).round().long()


def _rounded(values: Tensor, per_unit: int) -> Tensor:
    return (ticks_of(values, per_unit).double() / per_unit).to(values.dtype)


def _rounded_segments(segments: Tensor, structure: Structure, precision: int) -> Tensor:
    """Round anchors to whole ticks, and the two handles of each segment to whole handle steps from its start.

    Points of paths that are at ticks stay. The handles of lines are at thirds of the rounded line.
    """
    ticks = segments.double() * 10**precision
    anchor = ticks[:, :1].round()
    step = 10 ** (precision - min(precision, max(precision - 1, MIN_HANDLE_DECIMALS)))
    rounded = anchor + ((ticks - anchor) / step).round() * step
    rounded = torch.where(at_ticks(ticks, structure)[:, None, None], ticks.round(), rounded) / 10**precision
    return straightened(rounded, structure).to(segments.dtype)


def at_ticks(ticks: Tensor, structure: Structure) -> Tensor:
    """Return the segments [R] of paths with all points at whole ``ticks``, up to the rounding of float32."""
    off = (ticks - ticks.round()).abs() > TICK_ERROR + TICK_ERROR_SHARE * ticks.abs()
    if structure.is_line is not None:
        off[structure.is_line, 1:] = False
    owner = structure.segment_path.long()
    is_off = torch.zeros(structure.path_count, dtype=torch.int32, device=ticks.device)
    return is_off.index_add_(0, owner, off.flatten(1).any(1).int())[owner] == 0


def _without_far_gradients(scene: Scene) -> Scene:
    """Return ``scene`` with gradients that end too far out to be written made flat, in their colour at the path."""
    gradients = scene.gradients
    if gradients is None:
        return scene
    geometry = gradients.geometry.double()
    is_far = geometry.abs().amax(1) * 10**GRADIENT_DECIMALS >= MAX_TICKS
    is_far &= (gradients.kind != FLAT) & ~gradients.is_degenerate()
    if not is_far.any():
        return scene
    anchor = scene.segments[scene.structure.path_first_segment[:-1].long(), 0].double()
    along, axis = anchor - geometry[:, :2], geometry[:, 2:] - geometry[:, :2]
    linear, radial = (along * axis).sum(1) / axis.square().sum(1), along.norm(dim=1) / geometry[:, 2]
    share = torch.where(gradients.kind == RADIAL, radial, linear).clamp(0.0, 1.0)[:, None].to(scene.color)
    shown = torch.where(is_far[:, None], torch.lerp(scene.color, gradients.end_color, share), scene.color)
    kind = torch.where(is_far, FLAT, gradients.kind)
    return replace(scene, color=shown, gradients=replace(gradients, kind=kind))


def _rounded_gradients(gradients: Gradients | None) -> Gradients | None:
    if gradients is None:
        return None
    geometry = _rounded(gradients.geometry, 10**GRADIENT_DECIMALS)
    geometry[gradients.kind == RADIAL, 3] = 0.0  # unused, and not in the file
    return replace(gradients, geometry=geometry, end_color=_rounded(gradients.end_color.clamp(0, 1), COLOR_LEVELS))


def _with_needed_gradients(scene: Scene) -> Scene:
    """Return ``scene`` with gradients that show one colour made flat, and without any if all are."""
    gradients = scene.gradients
    if gradients is None:
        return scene
    is_flat, shows_end = gradients.kind == FLAT, gradients.is_degenerate()
    color = torch.where((shows_end & ~is_flat)[:, None], gradients.end_color, scene.color)
    is_flat = is_flat | shows_end | (gradients.end_color == color).all(1)
    if is_flat.all():
        return replace(scene, color=color, gradients=None)
    flat = Gradients.flat(color)
    kept = [
        torch.where(is_flat if none.ndim == 1 else is_flat[:, None], none, own)
        for none, own in zip(vars(flat).values(), vars(gradients).values(), strict=True)
    ]
    return replace(scene, color=color, gradients=Gradients(*kept))


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
        fill = hex_colors(scene.background[None])[0]
        yield f'<rect id="background" width="{width}" height="{height}" fill="{fill}"/>'


def _layers(generation: NDArray[np.int64], elements: list[str], names: Mapping[int, str]) -> Iterator[str]:
    """Yield ``elements`` in one group per run of equal generation; the running number keeps ids unique."""
    starts = np.flatnonzero(np.diff(generation, prepend=generation[:1] - 1)).tolist()
    stops = (np.flatnonzero(np.diff(generation, append=generation[-1:] + 1)) + 1).tolist()
    for number, (start, stop) in enumerate(zip(starts, stops, strict=True), 1):
        level = int(generation[start])
        plural = "path" if stop - start == 1 else "paths"
        label = names.get(level, f"Layer {number}: generation {level}, {stop - start} {plural}")
        identifier = layer_id(names[level]) if level in names else f"layer-{number}-generation-{level}"
        yield f'<g id="{identifier}" inkscape:groupmode="layer" inkscape:label={quoteattr(label)}>'
        yield from elements[start:stop]
        yield "</g>"


def layer_id(name: str) -> str:
    """Return the id of a layer called ``name``: its letters and digits, with hyphens between."""
    return re.sub(r"[^a-zA-Z0-9]+", "-", name).strip("-")


def _path_elements(scene: Scene, precision: int, opacity_decimals: int, fills: list[str]) -> list[str]:
    data = path_data(scene, precision)
    opaque = 10**opacity_decimals
    opacity = ticks_of(scene.opacity, opaque).tolist()
    return [
        f'<path fill="{fill}"{_opacity_attribute(ticks, opacity_decimals) if ticks < opaque else ""} d="{d}"/>'
        for fill, ticks, d in zip(fills, opacity, data, strict=True)
    ]


def path_data(scene: Scene, precision: int) -> list[str]:
    """Return the ``d`` of each path.

    The choice between the two forms depends only on what a reader of the file finds as well, so that a file that is
    read and written again has the same bytes: not on rows of no length, which are left out.
    """
    ticks, structure = ticks_of(scene.segments, 10**precision).numpy(), scene.structure
    is_line = np.zeros(len(ticks), np.bool_) if structure.is_line is None else structure.is_line.numpy()
    has_lines = bool(_drawn_lines(ticks, structure).any())
    if structure.loop_count == len(scene) and not has_lines:
        return format_curves(ticks, structure.loop_first_segment.numpy().astype(np.int64), precision)
    rows, loops = structure.loop_first_segment.tolist(), structure.path_first_loop.tolist()
    parts = [(ticks[start:stop], is_line[start:stop]) for start, stop in pairwise(rows)]
    return [format_path(parts[start:stop], precision) for start, stop in pairwise(loops)]


def closes_by_lines(scene: Scene) -> NDArray[np.bool_] | None:
    """Return the rows [R] that are the line which closes a path; None if a path has several loops or other lines.

    ``scene`` has whole numbers of ticks, as those of its file.
    """
    structure = scene.structure
    if structure.loop_count != len(scene):
        return None
    is_line = np.zeros(len(scene.segments), np.bool_) if structure.is_line is None else structure.is_line.numpy()
    is_last = np.zeros_like(is_line)
    is_last[structure.loop_first_segment.numpy()[1:] - 1] = True
    return None if (is_line & ~is_last).any() else is_line & is_last


def _drawn_lines(ticks: NDArray[np.int64], structure: Structure) -> NDArray[np.bool_]:
    """Return the rows [R] that are lines of some length."""
    if structure.is_line is None:
        return np.zeros(len(ticks), np.bool_)
    ends = ticks[structure.segment_next.numpy(), 0]
    return structure.is_line.numpy() & (ends != ticks[:, 0]).any(1)


def _opacity_attribute(ticks: int, decimals: int) -> str:
    return f' fill-opacity="{format_number(ticks, decimals)}"'


def fills_of(scene: Scene) -> tuple[list[str], list[str]]:
    """Return the ``fill`` of each path, and the lines that define its gradients; equal gradients are one."""
    fills = hex_colors(scene.color)
    if scene.gradients is None:
        return fills, []
    gradients, names = scene.gradients, dict[str, str]()
    ends, places = hex_colors(gradients.end_color), ticks_of(gradients.geometry, 10**GRADIENT_DECIMALS).tolist()
    for row, kind in enumerate(gradients.kind.tolist()):
        if kind != FLAT:
            text = _gradient(kind, places[row], fills[row], ends[row])
            fills[row] = f"url(#{names.setdefault(text, f'g{len(names) + 1}')})"
    lines = [text.replace(" ", f' id="{name}" ', 1) for text, name in names.items()]
    return fills, ["<defs>", *lines, "</defs>"]


def _gradient(kind: int, geometry: list[int], start: str, end: str) -> str:
    element, sides = GRADIENT_ELEMENTS[kind]
    places = (
        f'{side}="{format_number(ticks, GRADIENT_DECIMALS)}"' for side, ticks in zip(sides, geometry, strict=False)
    )
    stops = f'<stop stop-color="{start}"/><stop offset="1" stop-color="{end}"/>'
    return f'<{element} gradientUnits="userSpaceOnUse" {" ".join(places)}>{stops}</{element}>'


def hex_colors(color: Tensor) -> list[str]:
    """Return ``#rrggbb``, or ``#rgb`` if that is the same colour, for each row of ``color`` [N, 3]."""
    names = (bytes(levels).hex() for levels in ticks_of(color, COLOR_LEVELS).tolist())
    return ["#" + (name[::2] if name[::2] == name[1::2] else name) for name in names]
