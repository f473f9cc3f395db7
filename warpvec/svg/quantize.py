"""Round a scene to the values that its file states."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import torch
from torch import Tensor

from warpvec.geometry.forms.form import ANGLE
from warpvec.geometry.gradients import Gradients
from warpvec.geometry.paints.registry import FLAT, KINDS, kind_of
from warpvec.geometry.path_forms import Forms
from warpvec.geometry.scene import Scene, straightened
from warpvec.geometry.softness import Softness
from warpvec.geometry.stops import Stops
from warpvec.geometry.strokes import MITER, MITER_LIMIT, MITER_LIMIT_MAX, Strokes
from warpvec.geometry.structure import Structure

GRADIENT_DECIMALS = 1
"""Decimals of the ends of gradients: half a step moves a colour by less than a level unless the gradient is shorter
than 13 px from black to white."""

OFFSET_DECIMALS = 4
"""Decimals of the offsets of stops: half a step is 0.05 px on a gradient of 1000 px."""

STOP_OPACITY_DECIMALS = 3
"""Decimals of the opacities of stops, as exact as colours are."""

OPACITY_DECIMALS = 2
"""Decimals of opacities. Half a step changes a blend of black and white by 1.3 of 255 levels; a third decimal costs
4 % of a file's bytes."""

ANGLE_DECIMALS = 3
"""Decimals of the angles of forms in degrees: half a step moves a point that is 500 px away by 0.004 px."""

MITER_DECIMALS = 2
"""Decimals of the limits of miters, which only decide between two forms of a corner."""

SIGMA_DECIMALS = 2
"""Decimals of the standard deviations of soft paths. A hundredth of a pixel changes the edge of a path that is blurred
by one pixel by half of an 8-bit level at most."""

SIGMAS_MAX = 8
"""Most different standard deviations in a file, each of which is a filter of 150 bytes. Beyond, neighbours are merged:
eight from 0.3 to 30 px differ by a factor of 1.9, so that each is at most 40 % off, and few paths are as far."""

MIN_WIDTH_DECIMALS = 2
"""Fewest decimals of the widths of strokes. Zeros at the end are not written."""

MIN_HANDLE_DECIMALS = 1
"""Fewest decimals of handles, which have one fewer than anchors: see `quantize`."""

COLOR_LEVELS = 255
"""Largest level of a colour channel, which is written as two hexadecimal digits."""

TICK_ERROR, TICK_ERROR_SHARE = 1e-3, 2.5e-7
"""A point counts as at a tick within so many ticks, and this share of its place: float32 has 24 bits, and a drawing is
scaled to the file's units and back. That all points of a path lie so near by chance does not happen."""

MAX_TICKS = 2.0**53
"""Largest coordinate in ticks (units of the last decimal). Ticks are computed in float64, which is exact up to here."""


def quantize(scene: Scene, precision: int) -> Scene:
    """Return the scene as the file will state it, to render exactly what is exported.

    Coordinates have ``precision`` decimals, colours 8 bits, opacities ``OPACITY_DECIMALS``, ends of gradients
    ``GRADIENT_DECIMALS``. Colours and opacities outside [0, 1] are clamped. Gradients of one colour become flat.
    Handles are rounded more coarsely than anchors (to 0.1 px at two decimals), relative to the start of their segment.
    This saves 9 % of the file at 512 paths and costs 0.003 dB: a handle moves its curve by at most 4/9 of its own move.
    A path whose points all have ``precision`` decimals already keeps them. Handles of lines are at thirds. Of a path
    with a form, the numbers of the form are rounded, and its rows follow. A turned form that is soft or has a gradient
    becomes an outline: programs blur an element wrongly, or not at all, that has a transform too, which would also turn
    the gradient. Paths whose opacity rounds to 0, and strokes whose width does, are removed, as in the file. Quantizing
    twice changes nothing more. Device and dtype are kept, derivatives are not.

    Raises:
        ValueError: the paths are not cubic, a value is not finite (except for the ends of a gradient, which then
            shows its end colour), or a coordinate is 2**53 units of the last decimal or more.
    """
    scene = _without_painted_turns(_with_needed_gradients(_without_far_gradients(scene.detach())))
    _check(scene, precision)
    quantized = replace(
        scene,
        segments=_rounded_segments(scene.segments, scene.structure, precision),
        gradients=_rounded_gradients(scene.gradients),
        color=rounded(scene.color.clamp(0, 1), COLOR_LEVELS),
        opacity=rounded(scene.opacity.clamp(0, 1), 10**OPACITY_DECIMALS),
        background=rounded(scene.background.clamp(0, 1), COLOR_LEVELS),
        strokes=_rounded_strokes(scene.strokes, precision),
        softness=_rounded_softness(scene.softness),
    ).with_forms(_rounded_forms(scene.forms, precision))
    shown = _with_needed_gradients(_with_one_opacity(quantized))
    is_visible = shown.opacity > 0
    if scene.strokes is not None and shown.strokes is not None:
        is_visible &= shown.strokes.is_stroked | ~scene.strokes.is_stroked
    return _with_needed_strokes(_with_needed_gradients(shown.select(is_visible)))


def _check(scene: Scene, precision: int) -> None:
    if scene.degree != 3:
        remedy = "convert it with warpvec.geometry.cubics.to_cubics"
        raise ValueError(f"scene must have degree 3 to be written, got {scene.degree}; {remedy}")
    for name in ("segments", "color", "opacity", "background"):
        if not torch.isfinite(getattr(scene, name)).all():
            raise ValueError(f"{name} of a scene must be finite to be written; check what made it")
    if len(scene) and scene.segments.abs().max().double() * 10**precision >= MAX_TICKS:
        raise ValueError(f"points must be within 2**53 steps of 1e-{precision} of the origin to be written")
    if scene.forms is not None and not torch.isfinite(scene.forms.parameters).all():
        raise ValueError("parameters of forms must be finite to be written; check what made them")
    if scene.strokes is not None:
        for name in ("width", "miter_limit"):
            if not torch.isfinite(getattr(scene.strokes, name)).all():
                raise ValueError(f"{name} of strokes must be finite to be written; check what made it")
    if scene.softness is not None and not torch.isfinite(scene.softness.sigma).all():
        raise ValueError("softness of a scene must be finite to be written; check what made it")
    if scene.gradients is not None and not torch.isfinite(scene.gradients.end_color).all():
        raise ValueError("end colours of gradients must be finite to be written; check what made them")


def ticks_of(values: Tensor, per_unit: int) -> Tensor:
    """Return ``values`` as the nearest integers (int64) in units of ``1 / per_unit``.

    They are computed in float64, so that a value rounded to a tick and stored in float32 gives the same tick again.
    """
    return (values.double() * per_unit).round().long()


def rounded(values: Tensor, per_unit: int) -> Tensor:
    """Return ``values`` rounded to whole ticks of ``1 / per_unit``, as a file states them."""
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


def _rounded_forms(forms: Forms | None, precision: int) -> Forms | None:
    """Return ``forms`` with the numbers that a file states; those of no size become outlines."""
    if forms is None:
        return None
    parameters, is_lost = forms.parameters.clone(), torch.zeros_like(forms.is_form)
    for _, form, paths in forms.groups():
        exact = forms.parameters[paths].double()
        numbers = form.drawable(rounded(form.numbers(exact), 10**precision), 10.0**-precision)
        angle = torch.deg2rad(rounded(torch.rad2deg(exact[:, ANGLE]), 10**ANGLE_DECIMALS))
        parameters[paths] = form.parameters(numbers, angle).to(parameters.dtype)
        is_lost[paths] = (numbers[:, 2:] <= 0.0).any(1)
    return replace(forms, parameters=parameters).without(is_lost)


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
    geometry = gradients.whole_geometry.double()
    is_far = geometry.abs().amax(1) * 10**GRADIENT_DECIMALS >= MAX_TICKS
    is_far &= (gradients.kind != FLAT) & ~gradients.is_degenerate()
    if not is_far.any():
        return scene
    anchor = scene.segments[scene.structure.path_first_segment[:-1].long(), 0].double()
    shown, opacity = scene.color.clone(), scene.opacity.clone()
    for row in is_far.nonzero().flatten().tolist():
        paint = kind_of(int(gradients.kind[row]))
        share = paint.share(geometry[row].cpu().numpy(), *anchor[row].cpu().numpy()[:, None]).item()
        values = gradients.shown_at(row, scene.color[row], share)
        shown[row], opacity[row] = values[:3], opacity[row] * values[3]
    kind = torch.where(is_far, FLAT, gradients.kind)
    return replace(scene, color=shown, opacity=opacity, gradients=replace(gradients, kind=kind))


def _rounded_gradients(gradients: Gradients | None) -> Gradients | None:
    if gradients is None:
        return None
    geometry = rounded(gradients.whole_geometry, 10**GRADIENT_DECIMALS)
    for number, paint in KINDS.items():
        geometry[gradients.kind == number, paint.number_count :] = 0.0  # unused, and not in the file
    end_color = rounded(gradients.end_color.clamp(0, 1), COLOR_LEVELS)
    stops = None if gradients.stops is None else _rounded_stops(gradients.stops, geometry[:, 4].contiguous())
    return Gradients(gradients.kind, geometry[:, :4].contiguous(), end_color, stops)


def _rounded_stops(stops: Stops, breadth: Tensor) -> Stops:
    """Return the ``stops`` as a file states them; those that no path has are opaque, black and at 1."""
    is_used = stops.is_used()
    is_inner = is_used[:, 2:, None]  # a path of k stops has k - 2 between the first and the last
    return replace(
        stops,
        offset=rounded(stops.shown_offsets(), 10**OFFSET_DECIMALS),
        inner_color=torch.where(is_inner, rounded(stops.inner_color.clamp(0, 1), COLOR_LEVELS), 0.0),
        opacity=torch.where(is_used, rounded(stops.opacity.clamp(0, 1), 10**STOP_OPACITY_DECIMALS), 1.0),
        breadth=breadth,
    )


def width_decimals(precision: int) -> int:
    """Return the decimals of the widths of strokes in a file whose anchors have ``precision`` decimals."""
    return max(precision, MIN_WIDTH_DECIMALS)


def _rounded_strokes(strokes: Strokes | None, precision: int) -> Strokes | None:
    if strokes is None:
        return None
    width = rounded(strokes.width.clamp_min(0.0), 10 ** width_decimals(precision))
    limit = rounded(strokes.miter_limit.clamp(1.0, MITER_LIMIT_MAX), 10**MITER_DECIMALS)
    # A file states no limit where the join is no miter.
    return replace(strokes, width=width, miter_limit=torch.where(strokes.join == MITER, limit, MITER_LIMIT))


def _with_one_opacity(scene: Scene) -> Scene:
    """Return ``scene`` with the opacity of each path with a gradient in one place, which a file states by its stops.

    It is that of the path if all stops are alike, else that of the stops.
    """
    gradients = scene.gradients
    if gradients is None or gradients.stops is None:
        return scene
    stops = gradients.stops
    whole = rounded(stops.opacity * scene.opacity[:, None], 10**STOP_OPACITY_DECIMALS)
    even = rounded(whole[:, 0], 10**OPACITY_DECIMALS)
    is_even, is_flat = ((whole == even[:, None]) | ~stops.is_used()).all(1), gradients.kind == FLAT
    opacity = torch.where(is_flat, scene.opacity, torch.where(is_even, even, 1.0))
    of_stops = torch.where((is_even | is_flat)[:, None] | ~stops.is_used(), 1.0, whole)
    return replace(scene, opacity=opacity, gradients=replace(gradients, stops=replace(stops, opacity=of_stops)))


def _without_painted_turns(scene: Scene) -> Scene:
    """Return ``scene`` with outlines in place of turned forms that are soft or have a gradient."""
    if scene.forms is None or (scene.softness is None and scene.gradients is None):
        return scene
    angle = rounded(torch.rad2deg(scene.forms.parameters[:, ANGLE]), 10**ANGLE_DECIMALS)
    is_painted, is_turned = torch.zeros_like(scene.forms.is_form), torch.zeros_like(scene.forms.is_form)
    if scene.softness is not None:
        is_painted |= scene.softness.is_soft
    if scene.gradients is not None:
        is_painted |= scene.gradients.kind != FLAT
    for _, form, paths in scene.forms.groups():
        is_turned[paths] = form.turns and angle[paths] != 0.0
    return replace(scene, forms=scene.forms.without(is_painted & is_turned))


def _rounded_softness(softness: Softness | None) -> Softness | None:
    """Return ``softness`` with at most ``SIGMAS_MAX`` standard deviations; None if all paths are sharp."""
    if softness is None:
        return None
    bounded = torch.where(softness.is_soft, softness.sigma, 0.0)
    per_unit = 10**SIGMA_DECIMALS
    ticks = ticks_of(bounded, per_unit)
    values, sizes = torch.unique(ticks, return_counts=True)
    counts: list[list[float]] = [[t, n] for t, n in zip(values.tolist(), sizes.tolist(), strict=True) if t]
    groups = [[int(tick)] for tick, _ in counts]
    while len(groups) > SIGMAS_MAX:
        ratios = [after[0] / before[0] for before, after in pairwise(counts)]
        at = ratios.index(min(ratios))
        (a, n), (b, m) = counts[at : at + 2]
        counts[at : at + 2] = [[math.exp((n * math.log(a) + m * math.log(b)) / (n + m)), n + m]]
        groups[at : at + 2] = [groups[at] + groups[at + 1]]
    shown = ticks.clone()
    for (tick, _), group in zip(counts, groups, strict=True):
        shown[torch.isin(ticks, torch.tensor(group, device=ticks.device))] = round(tick)
    return Softness((shown.double() / per_unit).to(softness.sigma.dtype)).or_none()


def _with_needed_strokes(scene: Scene) -> Scene:
    """Return ``scene`` without strokes if all of its paths are filled."""
    if scene.strokes is None or scene.strokes.is_stroked.any():
        return scene
    return replace(scene, strokes=None)


def _with_needed_gradients(scene: Scene) -> Scene:
    """Return ``scene`` with gradients that show one opaque colour made flat, and without any if all are.

    A gradient that shows its end alone becomes flat too, with the opacity of its last stop.
    """
    gradients = scene.gradients
    if gradients is None:
        return scene
    is_flat, shows_end = gradients.kind == FLAT, gradients.is_degenerate()
    color = torch.where((shows_end & ~is_flat)[:, None], gradients.end_color, scene.color)
    last = gradients.last_opacity()
    opacity = torch.where(shows_end & (last < 1.0), rounded(scene.opacity * last, 10**OPACITY_DECIMALS), scene.opacity)
    is_flat = is_flat | shows_end | gradients.is_one_color(color)
    if is_flat.all():
        return replace(scene, color=color, opacity=opacity, gradients=None)
    flat = Gradients.none(color)
    flat = flat if gradients.stops is None else replace(flat, stops=Stops.two(color))
    own = torch.arange(len(scene), device=color.device)
    rows = torch.where(is_flat, own + len(scene), own)
    paints = gradients.joined(flat).map(lambda values: values[rows]).without_plain_stops()
    return replace(scene, color=color, opacity=opacity, gradients=paints)
