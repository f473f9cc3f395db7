"""Draw by other means what a file may not use for its purpose."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

import torch
from torch import Tensor

from warpvec.checks import counted
from warpvec.geometry.forms.form import ANGLE
from warpvec.geometry.forms.registry import CIRCLE
from warpvec.geometry.paints.registry import ELLIPTIC, FLAT
from warpvec.geometry.scene import Scene
from warpvec.geometry.strokes import Strokes
from warpvec.purposes.bands import bands_of
from warpvec.purposes.one_shape import one_shape
from warpvec.purposes.rings import rings_of
from warpvec.purposes.table import Purpose
from warpvec.svg.foreign.skia import Combiner
from warpvec.svg.stroke_outlines import without_strokes

PEN_WIDTH = 1.0
"""Width in pixels of the strokes that stand for fills: it is only for the screen, as a pen has its own."""


@dataclass(frozen=True)
class Replaced:
    """A scene that has only what its file may use.

    Attributes:
        scene: the scene.
        words: what is drawn by other means, in words; empty if nothing is.
    """

    scene: Scene
    words: list[str] = field(default_factory=list)


def replaced(scene: Scene, purpose: Purpose, width: float, height: float, threads: int | None = None) -> Replaced:
    """Return ``scene``, in pixels of a canvas of ``width`` x ``height``, with what a file for ``purpose`` may use.

    Raises:
        InputError: skia-pathops is needed and missing.
    """
    scene, words = scene.cpu(), list[str]()
    if not purpose.has_blur and scene.soft_count:
        count, before = scene.soft_count, len(scene)
        scene = (
            _with_rings(scene, width, height, purpose.dots, threads)
            if purpose.has_shades
            else replace(scene, softness=None)
        )
        more = f"as {counted(len(scene) - before + count, 'ring')} of paths" if purpose.has_shades else "sharp"
        words.append(f"{counted(count, 'soft path')} {more}")
    is_refused = _refused_gradients(scene, purpose)
    if bool(is_refused.any()):
        count, before = int(is_refused.sum()), len(scene)
        scene = _with_bands(scene, is_refused, width, height) if purpose.has_shades else _with_means(scene)
        more = (
            f"as {counted(len(scene) - before + count, 'band')} of one colour"
            if purpose.has_shades
            else "as one colour each"
        )
        words.append(f"{counted(count, 'gradient')} {more}")
    if not purpose.has_strokes:
        scene = without_strokes(scene)
    elif not purpose.has_clear_strokes and scene.strokes is not None:
        is_clear = scene.strokes.is_stroked & (scene.opacity < 1.0)
        scene = _changed(scene, is_clear, without_strokes) if bool(is_clear.any()) else scene
    if not purpose.has_forms:
        scene = scene.outlined()
    elif not purpose.has_turns:
        scene = _without_turns(scene)
    if purpose.is_one_color:
        scene = one_shape(scene, width, height)
        words.append("all colours as one black shape")
    if not purpose.has_fills:
        scene, count = _with_pens(scene)
        words += [f"{counted(count, 'filled path')} as their outlines"] if count else []
    if not purpose.has_ground and not scene.transparent:
        scene = replace(scene, background=torch.zeros(3), transparent=True)
        words.append("no background")
    return Replaced(scene, words)


def _refused_gradients(scene: Scene, purpose: Purpose) -> Tensor:
    """Return which paths [N] have a gradient that the file may not use."""
    if scene.gradients is None:
        return torch.zeros(len(scene), dtype=torch.bool)
    kind = scene.gradients.kind
    if not purpose.has_gradients:
        return kind != FLAT
    return (kind == ELLIPTIC) & (not purpose.has_ellipses)


def _with_rings(scene: Scene, width: float, height: float, dots: float, threads: int | None) -> Scene:
    assert scene.softness is not None

    def rings(one: Scene) -> Scene:
        made = rings_of(one.scaled(dots, dots), dots * width, dots * height, threads)
        return made.scaled(1.0 / dots, 1.0 / dots)

    return replace(_changed(scene, scene.softness.is_soft, rings), softness=None)


def _with_bands(scene: Scene, rows: Tensor, width: float, height: float) -> Scene:
    combiner = Combiner()

    def bands(one: Scene) -> Scene:
        return bands_of(without_strokes(one), width, height, combiner)

    return _changed(scene, rows, bands)


def _changed(scene: Scene, rows: Tensor, change: Callable[[Scene], Scene]) -> Scene:
    """Return ``scene`` with the paths ``rows`` (a mask) in the form that ``change`` gives to a scene of one."""
    parts = list(_parts(scene, rows, change))
    found = parts[0]
    for part in parts[1:]:
        found = found.joined(part)
    return found


def _parts(scene: Scene, rows: Tensor, change: Callable[[Scene], Scene]) -> Iterator[Scene]:
    start = 0
    for row in rows.nonzero().flatten().tolist():
        if start < row:
            yield scene.select(torch.arange(start, row))
        yield change(scene.select(torch.tensor([row])))
        start = row + 1
    if start < len(scene):
        yield scene.select(torch.arange(start, len(scene)))


def _with_means(scene: Scene) -> Scene:
    """Return ``scene`` with the mean colour and opacity of its stops in place of each gradient."""
    assert scene.gradients is not None
    stops = scene.gradients.all_stops()
    is_used = stops.is_used()
    weight = is_used / is_used.sum(1, keepdim=True)
    color = (stops.colors(scene.color, scene.gradients.end_color) * weight[..., None]).sum(1)
    is_flat = scene.gradients.kind == FLAT
    opacity = scene.opacity * torch.where(is_flat, 1.0, (stops.opacity * weight).sum(1))
    return replace(scene, color=torch.where(is_flat[:, None], scene.color, color), opacity=opacity, gradients=None)


def _with_pens(scene: Scene) -> tuple[Scene, int]:
    """Return ``scene`` with thin strokes in place of fills, and the number of these.

    vpype takes the colour of a pen from strokes alone.
    """
    strokes = Strokes.none(scene.color) if scene.strokes is None else scene.strokes
    is_filled = ~strokes.is_stroked
    width = torch.where(is_filled, PEN_WIDTH, strokes.width)
    return replace(scene, strokes=replace(strokes, width=width)), int(is_filled.sum())


def _without_turns(scene: Scene) -> Scene:
    """Return ``scene`` with outlines in place of turned forms."""
    if scene.forms is None:
        return scene
    is_turned = (scene.forms.parameters[:, ANGLE] != 0.0) & (scene.forms.kind != CIRCLE)
    return replace(scene, forms=scene.forms.without(is_turned))
