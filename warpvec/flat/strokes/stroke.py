"""A stroke in place of loops of a path, and the scene with it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import reduce
from itertools import pairwise
from typing import Any

import numpy as np
import torch

from warpvec.flat.constants.strokes import STROKES
from warpvec.flat.simplification.form_candidates import Candidate
from warpvec.flat.simplification.path_removal import without_loops
from warpvec.flat.strokes.line_fitting import Rows, cost_of, halved
from warpvec.geometry.forms.registry import form_of
from warpvec.geometry.path_forms import Forms
from warpvec.geometry.scene import Scene, straightened
from warpvec.geometry.strokes import MITER_LIMIT, Strokes
from warpvec.geometry.structure import Structure


@dataclass(frozen=True, eq=False)
class Stroke:
    """A stroke in place of some loops of a path.

    Attributes:
        loops: the loops that it replaces, numbered within the path.
        lines: the rows of its centre lines.
        width, cap, join: as in `Strokes`.
        forms: the form of each line, None for one without; a line with a form becomes a path of its own.
    """

    loops: list[int]
    lines: list[Rows]
    width: float
    cap: int
    join: int
    forms: list[Candidate | None]

    @property
    def has_ends(self) -> bool:
        """Whether a line has a cap."""
        return any(line.is_open and form is None for line, form in zip(self.lines, self.forms, strict=True))

    @property
    def cost(self) -> float:
        """The numbers that a file needs for it."""
        rows = zip(self.lines, self.forms, strict=True)
        return sum(cost_of(line) if form is None else len(form_of(form.kind).free) for line, form in rows)

    def with_halves(self) -> Stroke:
        """Return this with two cubics for each, but for forms: a fit then follows the picture, and shows its parts."""
        rows = zip(self.lines, self.forms, strict=True)
        return replace(self, lines=[halved(line) if form is None else line for line, form in rows])

    def joined(self, other: Stroke) -> Stroke:
        """Return this with the loops and lines of another stroke that looks alike."""
        loops, lines, forms = self.loops + other.loops, self.lines + other.lines, self.forms + other.forms
        return replace(self, loops=loops, lines=lines, forms=forms)

    @property
    def key(self) -> tuple[Any, ...]:
        """What only strokes of the very same values share."""
        lines = tuple((line.control.tobytes(), line.is_line.tobytes(), line.is_open) for line in self.lines)
        forms = tuple(None if form is None else (form.kind, form.parameters.tobytes()) for form in self.forms)
        return (*self.loops, self.width, self.cap, self.join, lines, forms)


def with_shared_looks(strokes: dict[int, Stroke]) -> dict[int, Stroke]:
    """Return ``strokes`` with the very same width where widths are nearly alike, the mean of these.

    Strokes without ends get the most frequent cap, which does not show.
    """
    groups: list[list[int]] = []
    for path in sorted(strokes, key=lambda path: strokes[path].width):
        if groups and strokes[path].width - strokes[groups[-1][0]].width <= STROKES.width_shared:
            groups[-1].append(path)
        else:
            groups.append([path])
    width = {path: float(np.mean([strokes[each].width for each in group])) for group in groups for path in group}
    caps = [stroke.cap for stroke in strokes.values() if stroke.has_ends]
    cap = max(set(caps), key=caps.count) if caps else None
    return {
        path: replace(stroke, width=width[path], cap=stroke.cap if cap is None or stroke.has_ends else cap)
        for path, stroke in strokes.items()
    }


def joined_strokes(strokes: dict[int, Stroke], generation_count: int) -> dict[int, Stroke]:
    """Return ``strokes``, by generations of `set_apart`; strokes of one path and one look become one stroke."""
    looks = dict[tuple[float, ...], int]()
    found = dict[int, Stroke]()
    for own, stroke in strokes.items():
        first = looks.setdefault((own % generation_count, stroke.width, stroke.cap, stroke.join), own)
        known = found.get(first)
        found[first] = stroke if known is None else known.joined(stroke)
    return found


def with_strokes(scene: Scene, strokes: dict[int, Stroke]) -> Scene:
    """Return ``scene`` with each of the ``strokes`` in place of the path of its generation; see `set_apart`."""
    parts = []
    for path, generation in enumerate(scene.generation.tolist()):
        one, stroke = scene.select(torch.tensor([path])), strokes.get(generation)
        parts += [one] if stroke is None else _stroke_scenes(one, stroke)
    return reduce(Scene.joined, parts) if strokes else scene


def set_apart(scene: Scene, strokes: dict[int, Stroke], generation_count: int) -> Scene:
    """Return ``scene`` with the loops that each of the ``strokes`` replaces in a path of their own.

    Its generation is that by which the stroke goes: that of its path, of which there are ``generation_count``, and some
    times as many.
    """
    parts, owned = [], dict[int, list[int]]()
    for own in strokes:
        owned.setdefault(own % generation_count, []).append(own)
    for path, generation in enumerate(scene.generation.tolist()):
        one = scene.select(torch.tensor([path]))
        number = np.arange(one.structure.loop_count)
        loops = {own: np.isin(number, strokes[own].loops) for own in owned.get(generation, [])}
        rest = ~np.logical_or.reduce([np.zeros(len(number), bool), *loops.values()])
        for own, is_own in {generation: rest, **loops}.items():
            if is_own.any():
                apart = one if is_own.all() else without_loops(one, ~is_own)
                parts.append(replace(apart, generation=torch.full_like(apart.generation, own)))
    return reduce(Scene.joined, parts)


def _stroke_scenes(one: Scene, stroke: Stroke) -> list[Scene]:
    """Return the paths of a stroke in the paint of a scene of ``one`` path: those with forms, and one for the rest."""
    own = [k for k, form in enumerate(stroke.forms) if form is not None]
    rest = [k for k in range(len(stroke.lines)) if k not in own]
    return [stroke_scene(one, stroke, lines) for lines in [[k] for k in own] + ([rest] if rest else [])]


def stroke_scene(one: Scene, stroke: Stroke, lines: list[int]) -> Scene:
    """Return the path of some ``lines`` of a ``stroke``, by their numbers, in the paint of a scene of ``one`` path."""
    form, rows = stroke.forms[lines[0]], [stroke.lines[k] for k in lines]
    if form is not None:
        rows = [Rows(form.curves, np.array(form_of(form.kind).is_line), False)]
    control = torch.from_numpy(np.concatenate([line.control for line in rows])).to(one.segments)
    is_line = torch.from_numpy(np.concatenate([line.is_line for line in rows]))
    is_open = torch.tensor([line.is_open for line in rows])
    structure = Structure.of_loops(
        [[len(line.control) for line in rows]], is_line if is_line.any() else None, is_open if is_open.any() else None
    )
    cap_kind, join_kind = (torch.tensor([kind], dtype=torch.int32) for kind in (stroke.cap, stroke.join))
    width = one.opacity.new_tensor([stroke.width])
    strokes = Strokes(width, cap_kind, join_kind, torch.full_like(width, MITER_LIMIT))
    scene = replace(one, segments=straightened(control, structure), structure=structure, strokes=strokes, forms=None)
    if form is None:
        return scene
    kind = torch.tensor([form.kind], dtype=torch.int32)
    return scene.with_forms(Forms(kind, torch.from_numpy(form.parameters)[None].to(one.segments)))


def read_back(drawn: Scene, strokes: dict[int, Stroke]) -> dict[int, Stroke]:
    """Return the ``strokes`` as they are in a drawing of `with_strokes`."""
    assert drawn.strokes is not None
    found = {}
    for generation, stroke in strokes.items():
        paths = (drawn.strokes.is_stroked & (drawn.generation == generation)).nonzero().flatten().tolist()
        lines, forms = list(stroke.lines), list(stroke.forms)
        own = [k for k, form in enumerate(forms) if form is not None]
        rest = [k for k in range(len(lines)) if k not in own]
        for path, members in zip(paths, [[k] for k in own] + ([rest] if rest else []), strict=True):
            one = drawn.select(torch.tensor([path]))
            rows, is_line = one.segments.double().numpy(), one.structure.lines.numpy()
            spans = pairwise(one.structure.loop_first_segment.tolist())
            for k, (start, stop) in zip(members, spans, strict=True):
                lines[k] = Rows(rows[start:stop], is_line[start:stop], lines[k].is_open and forms[k] is None)
            form = forms[members[0]]
            if form is not None:
                assert one.forms is not None
                forms[members[0]] = Candidate(form.kind, one.forms.parameters[0].double().numpy())
        width = float(drawn.strokes.width[paths].mean())
        found[generation] = replace(stroke, lines=lines, forms=forms, width=width)
    return found
