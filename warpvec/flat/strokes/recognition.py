"""Draw the shapes of a drawing that are strokes by their centre lines, where the picture does not object."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from warpvec.arrays import Floats, Floats32, Integers, Mask, counted
from warpvec.flat.constants.simplification import SIMPLIFICATION
from warpvec.flat.constants.strokes import STROKES
from warpvec.flat.price import CUBIC, LINE, number_nats
from warpvec.flat.simplification.critic import Critic
from warpvec.flat.simplification.local_error import errors_near
from warpvec.flat.simplification.outline_samples import OutlineSamples, cubic_points, segment_loops
from warpvec.flat.strokes.attempts import Attempt, Match
from warpvec.flat.strokes.candidates import stroke_candidates
from warpvec.flat.strokes.stroke import Stroke, joined_strokes, read_back, set_apart, with_shared_looks, with_strokes
from warpvec.geometry.scene import Scene
from warpvec.polish.polish import polish
from warpvec.watch.decisions import are_wanted, box_of
from warpvec.watch.watch import Watch


def find_strokes(
    scene: Scene, critic: Critic, watch: Watch, detail: float, generation_count: int
) -> tuple[Scene, dict[int, Stroke]]:
    """Return ``scene`` with the parts that are strokes in paths of their own, and these strokes by their generation.

    The strokes are fitted to the picture. A connected shape is one if most of its outline has the same distance from
    the other side. Its centre lines are fitted with the rest of the drawing. It stays a shape if its file would need
    hardly fewer numbers, or if the squared error near it rises by more than an outline costs that moves by ``detail``.

    Args:
        scene: a scene of filled cubics, fitted to the image, with another generation for each path.
        critic: judges the changes against the image.
        watch: the watch over the run.
        detail: root mean square in pixels by which an outline may move, as the picture shows it.
        generation_count: more than any generation; that of a stroke is that of its path, and some times as many.
    """
    share = math.inf if critic.config.strokes == "all" else STROKES.outline_share
    outline_width = share * max(critic.image.shape[:2])
    tried = {} if watch.is_over() else stroke_candidates(scene, generation_count, outline_width)
    found = _accepted(set_apart(scene, tried, generation_count), tried, critic, watch, detail) if tried else {}
    found = joined_strokes(found, generation_count)
    return (set_apart(scene, found, generation_count) if found else scene), found


def _accepted(scene: Scene, tried: dict[int, Stroke], critic: Critic, watch: Watch, detail: float) -> dict[int, Stroke]:
    """Return those of the strokes that are ``tried`` that the picture accepts; see `find_strokes`."""
    judge = _Judge(scene, critic.samples(scene), critic.error(scene), critic)
    drawn = _polished(with_strokes(scene, tried), critic, watch, STROKES.gain_min)
    found = judge.hopeful_verdict(drawn, tried, detail, watch)
    nats = number_nats(max(critic.image.shape[:2]))
    attempts = {path: Attempt.of(found.fitted[path], found.of(path), detail, nats) for path in found.hopeful}
    known: dict[Any, _Verdict] = {}  # simpler lines are often those of the attempt before
    while any(not attempt.is_over for attempt in attempts.values()) and not watch.is_over():
        tried = {path: attempt.stroke for path, attempt in attempts.items() if attempt.stroke is not None}
        key = tuple((path, stroke.key) for path, stroke in tried.items())
        if key not in known:
            drawn = _polished(with_strokes(scene, tried), critic, watch, STROKES.gain_min)
            known[key] = judge.verdict(drawn, tried, detail)
        found = known[key]
        for path in tried:
            attempts[path] = attempts[path].after(found.fitted[path], found.of(path), found.rise)
    best = with_shared_looks({path: each.best for path, each in attempts.items() if each.best is not None})
    if not best or watch.is_over():
        return best
    best = {path: stroke.with_halves() for path, stroke in best.items()}
    return with_shared_looks(
        read_back(_polished(with_strokes(scene, best), critic, watch, STROKES.last_gain_min), best)
    )


def _polished(scene: Scene, critic: Critic, watch: Watch, gain_min: float) -> Scene:
    """Return ``scene`` with its strokes fitted to the picture; the other paths stay."""
    assert scene.strokes is not None
    return polish(
        critic.target, scene, critic.config, watch.side_part(), iterations=STROKES.iterations,
        values_exact_max=SIMPLIFICATION.values_exact_max, locked=~scene.strokes.is_stroked, gain_min=gain_min,
    ).scene  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Verdict:
    """What the picture says of strokes, by the generation of their paths.

    Attributes:
        fitted: the strokes as they are drawn.
        rise: by how much the squared error of each pixel rose [h, w].
        moved: how far the outlines of each seem to have moved, as a root mean square in pixels.
        hopeless: those that are not worth a try with other lines.
        accepted: those that make the file shorter and that the picture accepts.
        close: those of these that show no difference.
        long: those that show none either, but do not make the file shorter.
    """

    fitted: dict[int, Stroke]
    rise: Floats32
    moved: dict[int, float]
    hopeless: set[int]
    accepted: set[int]
    close: set[int]
    long: set[int]

    @property
    def hopeful(self) -> list[int]:
        """Those that are worth a try with other lines."""
        return [path for path in self.fitted if path not in self.hopeless]

    def of(self, path: int) -> Match:
        """Return how well the stroke of a path matches the picture."""
        if path in self.accepted:
            return Match.CLOSE if path in self.close else Match.ACCEPTED
        return Match.LONG if path in self.long else Match.REFUSED


@dataclass(frozen=True, eq=False)
class _Judge:
    """What is known of a drawing before its shapes become strokes: samples of its outlines, and its error [h, w]."""

    scene: Scene
    samples: OutlineSamples
    error: Floats32
    critic: Critic

    def hopeful_verdict(self, drawn: Scene, strokes: dict[int, Stroke], detail: float, watch: Watch) -> _Verdict:
        """Return what the picture says of those of the ``strokes`` that are not hopeless; see `verdict`.

        Hopeless ones go, the worst first: they also raise the error near others.
        """
        found = self.verdict(drawn, strokes, detail)
        while found.hopeless and not watch.is_over():
            least = STROKES.worst_share * max(found.moved.values())
            gone = {path for path in found.hopeless if found.moved[path] >= least}
            rest = {path: stroke for path, stroke in found.fitted.items() if path not in gone}
            if not rest:
                return found
            found = self.verdict(with_strokes(self.scene, rest), rest, detail)
        return found

    def verdict(self, drawn: Scene, strokes: dict[int, Stroke], detail: float) -> _Verdict:
        """Return what the picture says of the ``strokes``, by generation, as they are in ``drawn``."""
        loop, replaced, rise = segment_loops(self.scene), self._replaced(strokes), self.critic.error(drawn) - self.error
        moved = self._moved(rise, replaced)
        most = {path: STROKES.cost_share_max * _fill_cost(self.scene, rows, loop) for path, rows in replaced.items()}
        short = {path for path in replaced if strokes[path].cost <= most[path]}
        if are_wanted():
            self._note(strokes, replaced, moved, most, detail)
        farthest = {path: self._farthest(rise, rows) for path, rows in replaced.items()}

        def within(share: float, peak: float) -> set[int]:
            return {path for path in replaced if moved[path] <= share * detail and farthest[path] <= peak * detail}

        close, hopeless = within(STROKES.close_share, STROKES.close_peak), STROKES.hopeless * detail
        return _Verdict(
            read_back(drawn, strokes), rise, moved, {path for path in replaced if moved[path] > hopeless},
            within(STROKES.detail_share, STROKES.detail_peak) & short, close & short, close - short,
        )  # fmt: skip

    def _note(
        self, strokes: dict[int, Stroke], replaced: dict[int, Mask], moved: dict[int, float], most: dict[int, float],
        detail: float,
    ) -> None:  # fmt: skip
        """Note the ``strokes`` that are tried, by generation, and how far each moves the outlines that it replaces."""
        for path, rows in replaced.items():
            control, allowed = self.samples.control[rows], STROKES.detail_share * detail
            saved = most[path] / STROKES.cost_share_max - strokes[path].cost
            cost = (moved[path] ** 2, allowed**2) if strokes[path].cost <= most[path] else (1.0, 0.0)
            self.critic.note("strokes", box_of(control), f"{int(rows.sum())} segments", "stroke", saved, cost)

    def _replaced(self, strokes: dict[int, Stroke]) -> dict[int, Mask]:
        """Return the rows that each of the strokes replaces."""
        owner = self.scene.generation[self.scene.structure.segment_path.long()].numpy()
        return {generation: owner == generation for generation in strokes}

    def _moved(self, rise: Floats32, replaced: dict[int, Mask]) -> dict[int, float]:
        """Return how far the outlines of the rows [R] of each path seem to have moved, as a root mean square in pixels.

        A pixel counts for the path whose outline is nearest: paths lie in each other's boxes.

        Args:
            rise: by how much the squared error of each pixel rose [h, w].
            replaced: rows of each path, by its generation.
        """
        points = [_dense(self.samples.control[rows]) for rows in replaced.values()]
        owner, is_changed = np.repeat(np.arange(len(points)), [len(each) for each in points]), rise != 0.0
        nearest = owner[cKDTree(np.concatenate(points)).query(np.argwhere(is_changed)[:, ::-1] + 0.5)[1]]
        found = np.bincount(nearest, rise[is_changed], len(points)).tolist()
        worth = (self.samples.worth[rows].sum() for rows in replaced.values())
        details = (self.critic.detail_of(*each, SIMPLIFICATION.whole_noise) for each in zip(worth, found, strict=True))
        return dict(zip(replaced, details, strict=True))

    def _farthest(self, rise: Floats32, rows: Mask) -> float:
        """Return how far the one of ``rows`` [R] that has moved most seems to have, as `_moved` does."""
        found = zip(self.samples.worth[rows].tolist(), errors_near(self.samples.control[rows], rise), strict=True)
        return max((self.critic.detail_of(worth, float(error), SIMPLIFICATION.noise) for worth, error in found
                   if worth >= STROKES.worth_min), default=0.0)  # fmt: skip


def _dense(control: Floats) -> Floats:
    """Return points [D, 2] along segments [R, 4, 2], at most about a pixel apart."""
    counts = np.ceil(np.linalg.norm(np.diff(control, axis=1), axis=2).sum(1)).astype(np.int64) + 1
    row, number = np.repeat(np.arange(len(control)), counts), counted(counts)
    return cubic_points(control[row], (number / counts[row])[:, None])[:, 0]


def _fill_cost(scene: Scene, rows: Mask, loop: Integers) -> float:
    """Return the numbers that a file needs for the ``rows`` [R] of a scene."""
    is_line = scene.structure.lines.numpy()
    closing = np.append(loop[1:] != loop[:-1], True) & is_line
    cost = np.where(is_line, LINE, CUBIC)
    return float(cost[rows & ~closing].sum())
