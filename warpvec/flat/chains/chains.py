"""Say outlines and centre lines again, as lines, circular arcs and cubics that meet smoothly or in corners."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import torch
from scipy.spatial import cKDTree

from warpvec.arrays import Floats, Integers, Mask
from warpvec.config.fit_config import OFF, FitConfig
from warpvec.flat.chains.chain import Chain, Cover
from warpvec.flat.chains.choice import NUMBERS
from warpvec.flat.chains.grid import (
    Grid,
    arcs_of,
    determined_numbers,
    grid_of,
    on_grid,
    stated_numbers,
)
from warpvec.flat.chains.parts import ARC, CUBIC, LINE
from warpvec.flat.chains.saying import (
    LoopRows,
    Sheet,
    are_curves,
    are_ellipse,
    has_size,
    move_allowed,
    said_rows,
    sketched,
    with_rows,
)
from warpvec.flat.chains.verdict import ALLOWED, Verdict
from warpvec.flat.constants.simplification import SIMPLIFICATION
from warpvec.flat.price import number_nats
from warpvec.flat.simplification.critic import Critic
from warpvec.flat.simplification.outline_samples import cubic_points, segment_loops
from warpvec.geometry.bezier import whole_curves
from warpvec.geometry.scene import Scene
from warpvec.polish.polish import polish
from warpvec.watch.watch import Watch


class _Attempt(NamedTuple):
    """A way to say chains: the deviation of places in that of the picture, whether with relations and on the grid."""

    share: float
    is_regular: bool
    is_on_grid: bool = False


TRIED = (
    _Attempt(0.5, True, True), _Attempt(0.5, True, True), _Attempt(0.5, True, True),
    _Attempt(1.0, True), _Attempt(1.0, True), _Attempt(1.0, False), _Attempt(0.5, False),
)  # fmt: skip
"""What the picture refuses is tried in the next way, and must be nearer where it was refused. Parts on a grid must be
nearer from the start, as the picture says less of them. Where the picture accepts the parts, but
refuses some on the grid, only these leave the grid."""

WORTH, SHARE_MIN = 2.0, 0.1
"""A loop that says half as many numbers may cause all of the error that is allowed; none saves less than the second, as
numbers that are equal are worth something too."""

REFIT_ITERATIONS = 8
"""Most iterations of the fit of the first parts to the picture."""

WIDTH_STEP = 0.5
"""Step in pixels of the widths of strokes that have one look: fits leave a tenth."""

CURVES_MAX = 400
"""Most curves of a chain that is looked at: longer ones are no designer's."""


def with_chains(scene: Scene, critic: Critic, watch: Watch, detail: float = FitConfig.detail) -> Scene:
    """Return ``scene`` with chosen parts where the exact error hardly rises.

    Args:
        scene: a drawing of filled and stroked cubics, fitted to the picture. Its forms stay.
        critic: judges the changes against the picture.
        watch: the watch over the run. When it is over, nothing more is changed.
        detail: root mean square in pixels by which an outline may move, as the picture shows it.
    """
    if not len(scene) or watch.is_over():
        return scene
    work = _Work.of(scene, critic, watch, detail)
    work.find_grid()
    for attempt in TRIED:
        if work.left and not watch.is_over():
            work.make(attempt)
    return work.settled()


@dataclass(eq=False)
class _Work:
    """The work on the chains of one drawing.

    Attributes:
        verdict: judges them.
        nats: of a number.
        watch: as in `with_chains`.
        left: the chains that are not said yet, by their loops.
        drawing: the scene in which loops are replaced: that of the verdict, with its forms and widths on its grid.
        grid: of the drawing; None for none.
        found: what was accepted, by loops.
        held: the loops of these whose numbers are on the grid.
    """

    verdict: Verdict
    nats: float
    watch: Watch
    left: dict[int, Chain]
    drawing: Scene
    grid: Grid | None = None
    found: dict[int, LoopRows] = field(default_factory=dict)
    held: set[int] = field(default_factory=set)

    @staticmethod
    def of(scene: Scene, critic: Critic, watch: Watch, detail: float) -> _Work:
        """Return the work on a ``scene``, whose chains are those of a fit of the right parts where that comes near."""
        left, verdict = _chains_of(scene), Verdict(scene, critic, detail)
        nats = number_nats(max(critic.image.shape[:2]))
        if left:
            left |= _fitted(verdict, left, said_rows(left, detail, nats), watch)
        return _Work(verdict, nats, watch, left, scene)

    @property
    def _sheet(self) -> Sheet:
        scene, (height, width) = self.verdict.scene, self.verdict.critic.image.shape[:2]
        middle, fixed = (width / 2.0, height / 2.0), _points_but(scene, self.left)
        return Sheet(middle, _widths_of(scene), _looks_of(scene), fixed, self._forms)

    @cached_property
    def _forms(self) -> dict[int, Chain]:
        return _stroked_forms(self.verdict.scene)

    def find_grid(self) -> None:
        """Find the grid of the drawing by the numbers of its chains with their relations, if one is wanted."""
        if self.verdict.critic.config.grid == OFF:
            return
        scene, spread = self.verdict.scene, self.verdict.spread
        numbers = [stated_numbers(scene, self.left)]
        if self.left:
            numbers.append(determined_numbers(sketched(self.left, spread, self.nats, self._sheet).sketch))
        image, config = self.verdict.critic.image, self.verdict.critic.config
        size = image.shape[0], image.shape[1]
        self.grid = grid_of(np.concatenate(numbers), size, move_allowed(spread), config.grid)
        if self.grid is not None:
            self.drawing = _on_grid(self.verdict, self.grid)

    def make(self, attempt: _Attempt) -> None:
        """Say the chains that are left in one way, and take what the picture accepts."""
        grid, scene = self.grid if attempt.is_on_grid else None, self.verdict.scene
        if attempt.is_on_grid and grid is None:
            return
        sheet = self._sheet if attempt.is_regular else None
        said = said_rows(self.left, attempt.share * self.verdict.spread, self.nats, sheet, grid)
        tried = {loop: rows for loop, rows in said.items() if has_size(rows[0], self.left[loop].is_closed)}
        if attempt.is_on_grid and tried:
            _, unfit, boxes = _fit(self.verdict, with_rows(scene, tried), tried, self.watch, self.verdict.fitted)
            tried = {loop: rows for loop, rows in tried.items() if not unfit[loop]}
            self.left |= {loop: self.left[loop].firmer_in(boxes) for loop in said if loop not in tried}
            self.held |= set(tried)
        new = with_rows(self.drawing, self.found | tried)
        refused, boxes = self._refused(new, tried)
        self.found |= {loop: rows for loop, rows in tried.items() if not refused[loop]}
        self.held &= set(self.found)
        self.left = {loop: chain for loop, chain in self.left.items() if loop not in self.found}
        for loop in self.left if not attempt.is_on_grid else set(tried) & set(self.left):
            chain = self.left[loop]
            self.left[loop] = chain.freed_in(boxes) if attempt.is_on_grid else chain.firmer_in(boxes)

    def settled(self) -> Scene:
        """Return the drawing with what was found. What was refused may have covered what others do wrong."""
        while self.found:
            new = with_rows(self.drawing, self.found)
            refused, _ = self._refused(new, self.found)
            if not refused.any():
                return new
            self.found = {loop: rows for loop, rows in self.found.items() if not refused[loop]}
        return self.drawing

    def _refused(self, new: Scene, loops: Iterable[int]) -> tuple[Mask, Floats]:
        scene = self.verdict.scene
        return self.verdict.refused(new, _mask(scene, loops), shares_of(scene, new), _mask(scene, self.held))


def _on_grid(verdict: Verdict, grid: Grid) -> Scene:
    """Return the drawing of ``verdict`` with forms and widths on the ``grid`` where the picture accepts them."""
    scene = verdict.scene
    new, loops = on_grid(scene, grid), np.ones(scene.structure.loop_count, bool)
    refused, _ = verdict.refused(new, loops, np.ones(len(loops)), loops)
    first = scene.structure.path_first_loop.long().numpy()
    stays = torch.from_numpy(np.logical_or.reduceat(refused, first[:-1]))
    return on_grid(scene, grid, stays) if stays.any() else new


def _widths_of(scene: Scene) -> Floats:
    """Return the width of the stroke of each loop [L], 0 for outlines."""
    if scene.strokes is None:
        return np.zeros(scene.structure.loop_count)
    widths: Floats = scene.strokes.width.double().numpy()[_owners(scene)]
    return widths


def shares_of(old: Scene, new: Scene) -> Floats:
    """Return the share of the allowed error that each loop of ``new`` may cause, by the numbers that it saves [L]."""
    before, after = (_numbers_of(scene) for scene in (old, new))
    return np.clip(WORTH * (before - after) / np.maximum(before, 1.0), SHARE_MIN, 1.0)


def _numbers_of(scene: Scene) -> Floats:
    """Return the numbers that a file says of each loop of ``scene`` [L]."""
    structure, (is_arc, goes_on, _) = scene.structure, arcs_of(scene)
    numbers = np.where(is_arc, NUMBERS[ARC], NUMBERS[CUBIC]) * ~goes_on
    numbers = np.where(structure.lines.numpy(), NUMBERS[LINE], numbers) * ~structure.end_rows.numpy()
    return np.bincount(segment_loops(scene), numbers, structure.loop_count).astype(np.float64)


def _mask(scene: Scene, loops: Iterable[int]) -> Mask:
    """Return which loops of ``scene`` are among ``loops`` [L]."""
    return np.isin(np.arange(scene.structure.loop_count), list(loops))


def _fitted(verdict: Verdict, chains: dict[int, Chain], said: dict[int, LoopRows], watch: Watch) -> dict[int, Chain]:
    """Return the ``chains`` whose parts match the picture: ``said`` has their rows, which are fitted to it first.

    A chain of other parts is off by as much as the detail: only parts of the right kinds come as near as the picture
    tells.
    """
    first = with_rows(verdict.scene, said)
    drawn, refused, _ = _fit(verdict, first, chains, watch, ALLOWED)
    return {loop: chain for loop, chain in _chains_of(drawn).items() if not refused[loop]}


def _fit(
    verdict: Verdict, first: Scene, loops: Iterable[int], watch: Watch, allowed: float
) -> tuple[Scene, Mask, Floats]:
    """Return ``first`` fitted to the picture, which of its ``loops`` the picture refuses then [L], and where [B, 2, 2].

    They may cause the error of a move that is ``allowed``; see `verdict.ALLOWED`.
    """
    critic = verdict.critic
    locked = None if first.forms is None else first.forms.is_form
    drawn = polish(
        critic.target, first, critic.config, watch.side_part(), iterations=REFIT_ITERATIONS,
        values_exact_max=SIMPLIFICATION.values_exact_max, unseen=SIMPLIFICATION.unseen, locked=locked, keeps_stops=True,
    ).scene  # fmt: skip
    shares = np.ones(first.structure.loop_count)
    fitted = replace(first, segments=drawn.segments)
    return drawn, *verdict.refused(fitted, _mask(first, loops), shares, allowed=allowed)


def _chains_of(scene: Scene) -> dict[int, Chain]:
    """Return the chain of each loop that has no form, and is no ellipse: that is its shortest word already."""
    found = {}
    for loop, (curves, is_open, is_form) in enumerate(_loops_of(scene)):
        if not is_form and 0 < len(curves) <= CURVES_MAX and not are_ellipse(curves):
            found[loop] = Chain.of(curves, not is_open)
    return _covered(found, scene)


def _stroked_forms(scene: Scene) -> dict[int, Chain]:
    """Return the centre lines of the stroked forms of ``scene``, by their loops."""
    widths, loops = _widths_of(scene), enumerate(_loops_of(scene))
    return {
        loop: Chain.of(curves, not is_open)
        for loop, (curves, is_open, is_form) in loops
        if is_form and len(curves) and widths[loop] > 0.0
    }


def _loops_of(scene: Scene) -> Iterator[tuple[Floats, bool, bool]]:
    """Yield the curves [S, 4, 2] of each loop that are more than points, whether it is open, and part of a form."""
    control, structure = whole_curves(scene).double().numpy(), scene.structure
    owner, forms = structure.segment_path.numpy(), scene.forms
    for loop, (start, stop) in enumerate(pairwise(structure.loop_first_segment.tolist())):
        is_open = structure.is_open is not None and bool(structure.is_open[loop])
        curves = control[start : stop - is_open]
        yield curves[are_curves(curves)], is_open, forms is not None and bool(forms.is_form[owner[start]])


def _covered(chains: dict[int, Chain], scene: Scene) -> dict[int, Chain]:
    """Return ``chains``, those of strokes with the other strokes of their look as their cover."""
    widths, looks, found = _widths_of(scene), _looks_of(scene), dict(chains)
    stroked = [loop for loop in chains if widths[loop] > 0.0]
    lines = _stroked_forms(scene) | chains if stroked else chains
    for loop in stroked:
        chain, half = chains[loop], float(widths[loop]) / 2.0
        others = [each.dense for other, each in lines.items() if other != loop and looks[other] == looks[loop]]
        if others:
            cover = Cover(cKDTree(np.concatenate(others)), half)
            found[loop] = Chain.of(chain.curves, chain.is_closed, cover=cover)
    return found


def _looks_of(scene: Scene) -> Integers:
    """Return the number of the look of each loop [L]: its colour, and its width but for what fits leave."""
    width = np.zeros(len(scene)) if scene.strokes is None else scene.strokes.width.double().numpy()
    values = np.concatenate([scene.color.double().numpy(), scene.opacity.double().numpy()[:, None]], 1)
    values = np.concatenate([np.round(255.0 * values), np.round(width / WIDTH_STEP)[:, None]], 1)
    numbers: Integers = np.unique(values, axis=0, return_inverse=True)[1].reshape(-1)[_owners(scene)]
    return numbers


def _owners(scene: Scene) -> Integers:
    """Return the path of each loop [L]."""
    first = scene.structure.path_first_loop.long()
    return np.repeat(np.arange(len(scene)), first.diff().numpy())


def _points_but(scene: Scene, chains: dict[int, Chain]) -> Floats:
    """Return points [K, 2] along the outlines of ``scene`` that are none of ``chains``."""
    control, loop = whole_curves(scene).double().numpy(), segment_loops(scene)
    stays = ~np.isin(loop, list(chains)) & ~scene.structure.end_rows.numpy()
    return cubic_points(control[stays], (np.arange(8) + 0.5) / 8).reshape(-1, 2)
