"""Draw the shapes of a drawing that are strokes by their centre lines, where the picture does not object."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import torch

from warpvec.arrays import Floats, Floats32, Integers, Mask
from warpvec.config.fit_config import FitConfig
from warpvec.flat.constants.simplification import SIMPLIFICATION
from warpvec.flat.constants.strokes import STROKES
from warpvec.flat.simplification.critic import Critic
from warpvec.flat.simplification.form_candidates import Candidate, candidates
from warpvec.flat.simplification.local_error import errors_in_boxes
from warpvec.flat.simplification.outline_samples import (
    OutlineSamples,
    control_points,
    cubic_points,
    cubic_slopes,
    segment_loops,
)
from warpvec.flat.simplification.path_removal import loop_areas, without_loops
from warpvec.flat.strokes.center_lines import center_lines, join_of
from warpvec.flat.strokes.inner_disks import boundary_of, inner_disks, stroke_width
from warpvec.flat.strokes.line_fitting import Rows, cost_of, fit_again, fit_line
from warpvec.geometry.forms.registry import form_of
from warpvec.geometry.paints.registry import FLAT
from warpvec.geometry.path_forms import Forms
from warpvec.geometry.scene import Scene, straightened
from warpvec.geometry.strokes import BUTT, MITER_LIMIT, ROUND, Strokes
from warpvec.geometry.structure import Structure
from warpvec.polish.polish import polish
from warpvec.watch.watch import Watch


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
    def cost(self) -> float:
        """The numbers that a file needs for it."""
        rows = zip(self.lines, self.forms, strict=True)
        return sum(cost_of(line) if form is None else len(form_of(form.kind).free) for line, form in rows)


def find_strokes(scene: Scene, critic: Critic, watch: Watch, detail: float = FitConfig.detail) -> dict[int, Stroke]:
    """Return the paths of ``scene`` that are strokes, by their generation, fitted to the picture.

    A shape is one if most of its outline has the same distance from the other side. Its centre lines are fitted with
    the rest of the drawing. It stays a shape if its file would need hardly fewer numbers, or if the squared error near
    it rises by more than an outline costs that moves by ``detail``.

    Args:
        scene: a scene of filled cubics, fitted to the image, with another generation for each path.
        critic: judges the changes against the image.
        watch: the watch over the run.
        detail: root mean square in pixels by which an outline may move, as the picture shows it.
    """
    tried = {} if watch.is_over() else _candidates(scene)
    judge = _Judge(scene, critic.samples(scene), critic.error(scene), critic) if tried else None
    while tried and judge is not None:
        first = _polished(with_strokes(scene, tried), critic, watch, STROKES.first_iterations)
        hopeful = judge.accepted(first, tried, STROKES.hopeless * detail)
        again = _read_back(first, tried)
        tried = {path: tried[path] for path in hopeful}
        if not tried or watch.is_over():
            break
        again = {path: _simpler(again[path], detail) for path in tried}
        drawn = _polished(with_strokes(scene, again), critic, watch, STROKES.iterations)
        good = judge.accepted(drawn, again, detail)
        if len(good) == len(tried):
            return _read_back(drawn, again)
        tried = {path: tried[path] for path in good}
    return {}


def _candidates(scene: Scene) -> dict[int, Stroke]:
    found = {}
    for path in range(len(scene)):
        is_flat = scene.gradients is None or int(scene.gradients.kind[path]) == FLAT
        stroke = _candidate(scene.select(torch.tensor([path]))) if is_flat else None
        if stroke is not None:
            found[int(scene.generation[path])] = stroke
    return found


class _Part(NamedTuple):
    """A connected part of a path that may be a stroke.

    Attributes:
        loops: its loops, numbered within the path.
        lines: the rows of its centre lines; none if it is no stroke.
        width, cap, join: as in `Strokes`.
        length: of its centre lines, in pixels.
    """

    loops: list[int]
    lines: list[Rows]
    width: float = 0.0
    cap: int = BUTT
    join: int = ROUND
    length: float = 0.0

    @property
    def has_ends(self) -> bool:
        return any(line.is_open for line in self.lines)

    @property
    def is_long(self) -> bool:
        """Whether it would be a stroke without others beside it."""
        is_round = self.cap == ROUND and self.has_ends
        least = STROKES.round_length_min if is_round else STROKES.length_min
        return bool(self.lines) and self.length >= least * self.width


def _candidate(scene: Scene) -> Stroke | None:
    """Return the stroke that a scene of one path is, or that some of its parts are."""
    control, loop = control_points(scene), segment_loops(scene)
    areas = loop_areas(control, loop, scene.structure.loop_count)
    parts = [_part(control, loop, areas, loops) for loops in _components(control, loop, areas)]
    widths = [part.width for part in parts if part.is_long]
    if not widths:
        return None
    common = float(np.median(widths))
    alike = [p for p in parts if p.lines and abs(p.width - common) <= STROKES.width_error * common]
    cap = _most([part.cap for part in alike if part.has_ends], BUTT)
    chosen = [part for part in alike if part.cap == cap or not part.has_ends]
    join = _most([part.join for part in chosen if part.is_long], ROUND)
    lines = [line for part in chosen for line in part.lines]
    loops = [number for part in chosen for number in part.loops]
    return Stroke(loops, lines, common, cap, join, [None] * len(lines)) if lines else None


def _most(kinds: list[int], otherwise: int) -> int:
    return max(set(kinds), key=kinds.count) if kinds else otherwise


def _components(control: Floats, loop: Integers, areas: Floats) -> list[list[int]]:
    """Return the loops of each connected part: one that runs like the largest loop, and the holes in it."""
    sign = np.sign(areas[np.argmax(np.abs(areas))])
    outer = np.flatnonzero(np.sign(areas) == sign)
    outer = outer[np.argsort(np.abs(areas[outer]))]
    polygons = {
        k: cubic_points(control[loop == k], np.linspace(0.0, 1.0, 9)[:-1]).reshape(-1, 2) for k in outer.tolist()
    }
    parts = {k: [k] for k in outer.tolist()}
    for hole in np.flatnonzero(np.sign(areas) != sign).tolist():
        place = control[loop == hole][0, 0]
        owner = next((k for k in outer.tolist() if _contains(polygons[k], place)), int(outer[-1]))
        parts[owner].append(hole)
    return list(parts.values())


def _contains(polygon: Floats, place: Floats) -> bool:
    start, end = polygon, np.roll(polygon, -1, axis=0)
    crosses = (start[:, 1] > place[1]) != (end[:, 1] > place[1])
    rise = np.where(crosses, end[:, 1] - start[:, 1], 1.0)
    x = start[:, 0] + (place[1] - start[:, 1]) / rise * (end[:, 0] - start[:, 0])
    return bool((crosses & (x > place[0])).sum() % 2)


def _part(control: Floats, loop: Integers, areas: Floats, loops: list[int]) -> _Part:
    """Return what is known of the part with these ``loops``."""
    boundary = boundary_of(control[np.isin(loop, loops)], float(areas[loops[0]]))
    if len(boundary.points) < STROKES.points_min:
        return _Part(loops, [])
    disks = inner_disks(boundary)
    width, has_width = stroke_width(boundary, disks)
    found = center_lines(boundary, disks, has_width, width) if width >= STROKES.width_min else None
    if found is None or not found.lines:
        return _Part(loops, [])
    length = sum(float(np.linalg.norm(np.diff(line.points, axis=0), axis=1).sum()) for line in found.lines)
    rows = [fit_line(line, width) for line in found.lines]
    return _Part(loops, rows, width, found.cap, join_of(rows, boundary, width), length)


def with_strokes(scene: Scene, strokes: dict[int, Stroke]) -> Scene:
    """Return ``scene`` with each of the ``strokes``, by the generation of its path, after what is left of the path."""
    if not strokes:
        return scene
    parts = []
    for path, generation in enumerate(scene.generation.tolist()):
        one = scene.select(torch.tensor([path]))
        stroke = strokes.get(generation)
        if stroke is None:
            parts.append(one)
            continue
        gone = np.isin(np.arange(one.structure.loop_count), stroke.loops)
        if not gone.all():
            parts.append(without_loops(one, gone))
        parts += _stroke_scenes(one, stroke)
    found = parts[0]
    for part in parts[1:]:
        found = found.joined(part)
    return found


def _stroke_scenes(one: Scene, stroke: Stroke) -> list[Scene]:
    """Return the paths of a stroke in the paint of a scene of ``one`` path: those with forms, and one for the rest."""
    own = [k for k, form in enumerate(stroke.forms) if form is not None]
    rest = [k for k in range(len(stroke.lines)) if k not in own]
    return [_stroke_scene(one, stroke, lines) for lines in [[k] for k in own] + ([rest] if rest else [])]


def _stroke_scene(one: Scene, stroke: Stroke, lines: list[int]) -> Scene:
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


def _polished(scene: Scene, critic: Critic, watch: Watch, iterations: int) -> Scene:
    return polish(
        critic.target, scene, critic.config, watch.side_part(), iterations=iterations,
        values_exact_max=SIMPLIFICATION.values_exact_max,
    ).scene  # fmt: skip


def _read_back(drawn: Scene, strokes: dict[int, Stroke]) -> dict[int, Stroke]:
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


def _simpler(stroke: Stroke, detail: float) -> Stroke:
    """Return a fitted stroke with as few rows as its lines need, and with forms for closed lines that have one."""
    lines = [fit_again(line, STROKES.again_share * detail) for line in stroke.lines]
    return replace(stroke, lines=lines, forms=[None if line.is_open else _form_of(line, detail) for line in lines])


def _form_of(line: Rows, detail: float) -> Candidate | None:
    curves = np.concatenate([line.control, np.roll(line.control[:, :1], -1, axis=0)], 1)
    count = SIMPLIFICATION.segment_samples
    t = (np.arange(count) + 0.5) / count
    lengths = np.linalg.norm(cubic_slopes(curves, t), axis=-1) / count
    return next(candidates(cubic_points(curves, t), lengths, line.is_line, STROKES.form_share * detail), None)


@dataclass(frozen=True, eq=False)
class _Judge:
    """What is known of a drawing before its shapes become strokes: samples of its outlines, and its error [h, w]."""

    scene: Scene
    samples: OutlineSamples
    error: Floats32
    critic: Critic

    def accepted(self, drawn: Scene, strokes: dict[int, Stroke], detail: float) -> list[int]:
        """Return the strokes in ``drawn``, by generation, that the picture and the file accept."""
        rise, loop = self.critic.error(drawn) - self.error, segment_loops(self.scene)
        first = self.scene.structure.path_first_loop.tolist()
        good = []
        for path, generation in enumerate(self.scene.generation.tolist()):
            stroke = strokes.get(generation)
            if stroke is None:
                continue
            rows = np.isin(loop, first[path] + np.array(stroke.loops))
            points = self.samples.control[rows].reshape(-1, 2)
            found = errors_in_boxes(rise, points.min(0)[None], points.max(0)[None])
            worth, reach = self.samples.worth[rows].sum(), STROKES.detail_share * detail
            is_close = float(found[0]) <= float(self.critic.allowed(worth, reach, SIMPLIFICATION.whole_noise))
            if is_close and stroke.cost <= STROKES.cost_share_max * _fill_cost(self.scene, rows, loop):
                good.append(generation)
        return good


def _fill_cost(scene: Scene, rows: Mask, loop: Integers) -> float:
    """Return the numbers that a file needs for the ``rows`` [R] of a scene."""
    is_line = scene.structure.lines.numpy()
    closing = np.append(loop[1:] != loop[:-1], True) & is_line
    cost = np.where(is_line, STROKES.line_cost, STROKES.cubic_cost)
    return float(cost[rows & ~closing].sum())
