"""Give gradients fewer stops where the picture looks the same: idle stops go, and jumps become bends.

Stops are found in the pixels of a region before its outline is exact. Two of them may end at one place, where the
designer had one bend; a fit moves stops but never drops one.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import torch

from warpvec.arrays import Floats, Integers
from warpvec.flat.constants.simplification import SIMPLIFICATION
from warpvec.flat.regions.ramp_fitting import stop_weights
from warpvec.flat.simplification.critic import Critic
from warpvec.flat.simplification.outline_samples import top_paths
from warpvec.geometry.gradients import Gradients
from warpvec.geometry.paints.kind import GEOMETRY_SIZE, WHOLE_SIZE
from warpvec.geometry.paints.registry import FLAT, kind_of
from warpvec.geometry.scene import Scene
from warpvec.polish.polish import polish
from warpvec.watch.decisions import are_wanted, box_of
from warpvec.watch.watch import Watch


@dataclass(frozen=True, eq=False)
class GradientPaint:
    """The paint of one path: M stops along a gradient; a single stop is a flat paint.

    Attributes:
        kind, geometry: as in `Gradients`; five numbers [5].
        offset: places of the stops [M], ascending.
        color: their colours and opacities [M, 4].
    """

    kind: int
    geometry: Floats
    offset: Floats
    color: Floats

    def __len__(self) -> int:
        return len(self.offset)

    @staticmethod
    def of(scene: Scene, path: int) -> GradientPaint:
        """Return the paint of ``path`` of a ``scene`` with gradients."""
        gradients = scene.gradients
        assert gradients is not None
        stops = gradients.all_stops()
        count = int(stops.count[path])
        color = stops.colors(scene.color, gradients.end_color)[path, :count]
        values = torch.cat([color, stops.opacity[path, :count, None]], 1).double().numpy()
        geometry = torch.cat([gradients.geometry[path], stops.breadth[path, None]]).double().numpy()
        offset = stops.shown_offsets()[path, :count].double().numpy()
        return GradientPaint(int(gradients.kind[path]), geometry, offset, values)

    def simpler(self) -> Iterator[GradientPaint]:
        """Yield paints of fewer stops that may look alike, those of the fewest first."""
        yield replace(self, kind=FLAT, offset=np.zeros(1), color=self.color.mean(0, keepdims=True))
        if len(self) > 2:
            yield from self._with_bends()
            for stop in range(len(self)):
                yield from self._spread(np.delete(self.offset, stop), stop)

    def shares(self, points: Floats) -> Floats:
        """Return the share [K, M] of each stop in the colour at ``points`` [K, 2]."""
        if len(self) == 1:
            return np.ones((len(points), 1))
        place = kind_of(self.kind).share(self._numbers, *points.T)
        return np.asarray(stop_weights(self.offset, place), np.float64)

    def matched(self, points: Floats, shown: Floats) -> tuple[GradientPaint, float]:
        """Return the paint with colours as near as can be to those ``shown`` [K, 4] at ``points`` [K, 2].

        The second value is the root mean square of what differs.
        """
        shares = self.shares(points)
        matrix = shares.T @ shares + 1e-6 * len(points) * np.eye(len(self))
        target = shares.T @ shown + 1e-6 * len(points) * self.color
        color = np.linalg.solve(matrix, target).clip(0.0, 1.0)
        return replace(self, color=color), float(np.sqrt(np.square(shares @ color - shown).mean()))

    @property
    def _numbers(self) -> Floats:
        """The numbers of its geometry that its kind takes."""
        return self.geometry[: max(kind_of(self.kind).number_count, GEOMETRY_SIZE)]

    def _with_bends(self) -> Iterator[GradientPaint]:
        """Yield paints with one stop for two close ones: the slope beside one of them goes on to the other's colour."""
        for stop in np.nonzero(np.diff(self.offset) < SIMPLIFICATION.stop_gap)[0].tolist():
            for kept, beside, beyond in ((stop, stop + 1, stop + 2), (stop + 1, stop, stop - 1)):
                if 0 <= beyond < len(self):
                    slope, jump = self.color[beside] - self.color[beyond], self.color[kept] - self.color[beside]
                    share = float(slope @ jump) / max(float(slope @ slope), 1e-12)
                    offset = self.offset.copy()
                    offset[kept] = self.offset[beside] + share * (self.offset[beside] - self.offset[beyond])
                    yield from self._spread(np.delete(offset, beside), beside)

    def _spread(self, offset: Floats, gone: int) -> Iterator[GradientPaint]:
        """Yield the paint without the stop ``gone``, with the others at ``offset``, if these are in order.

        The last one comes to 1, and the first one to 0 if the gradient may start anywhere.
        """
        kind = kind_of(self.kind)
        start, end = float(offset[0]) if kind.has_free_start else 0.0, float(offset[-1])
        if np.diff(offset).min() < SIMPLIFICATION.stop_gap or offset[0] < 0.0:
            return
        geometry = np.zeros(WHOLE_SIZE)
        between = kind.between(tuple(self._numbers.tolist()), start, end)
        geometry[: len(between)] = between
        yield GradientPaint(self.kind, geometry, (offset - start) / (end - start), np.delete(self.color, gone, 0))


def with_fewer_stops(scene: Scene, critic: Critic, watch: Watch) -> Scene:
    """Return ``scene`` whose gradients have no more stops than the picture shows.

    Each round offers every gradient fewer stops, fits the paints, and takes back those that show their pixels worse.

    Args:
        scene: a scene fitted to the picture of ``critic``.
        critic: judges the changes.
        watch: the watch over the run. When it is over, the stops of the rounds so far must do.
    """
    if scene.gradients is None or not bool((scene.gradients.kind != FLAT).any()):
        return scene
    height, width = critic.image.shape[:2]
    top = top_paths(scene, height, width, critic.config.threads)
    work = _Work(critic, watch, np.zeros(len(scene), np.int64))
    for _ in range(SIMPLIFICATION.stop_rounds):
        offered = {} if watch.is_over() else work.offers(scene, top)
        if not offered:
            break
        new = work.fitted(scene, offered)
        refused = work.refused(scene, new, offered, top)
        for path in refused:
            work.least[path] = len(offered[path]) + 1
        kept = {path: GradientPaint.of(new, path) for path in offered if path not in refused}
        scene = new if not refused else _repainted(scene, kept)
    return scene


@dataclass(frozen=True, eq=False)
class _Work:
    """What a round needs. ``least`` [N] is the number of stops below which a path has nothing left to offer."""

    critic: Critic
    watch: Watch
    least: Integers

    def offers(self, scene: Scene, top: Integers) -> dict[int, GradientPaint]:
        """Return the paint of fewest stops for each path that looks as its gradient does, where that shows."""
        assert scene.gradients is not None
        found = {}
        for path in torch.nonzero(scene.gradients.kind != FLAT).flatten().tolist():
            rows, columns = np.nonzero(top == path)
            if len(rows) == 0:
                continue
            few = slice(None, None, -(-len(rows) // SIMPLIFICATION.stop_samples_max))
            points = np.column_stack([columns, rows])[few].astype(np.float64) + 0.5
            paint = GradientPaint.of(scene, path)
            shown = paint.shares(points) @ paint.color
            near = [each.matched(points, shown) for each in paint.simpler()]
            alike = [each for each in near if len(each[0]) >= self.least[path] and each[1] < SIMPLIFICATION.stop_alike]
            if alike:
                found[path] = min(alike, key=lambda each: (len(each[0]), each[1]))[0]
        return found

    def fitted(self, scene: Scene, offered: dict[int, GradientPaint]) -> Scene:
        """Return ``scene`` with the paints ``offered``, whose paths are fitted again."""
        locked = torch.ones(len(scene), dtype=torch.bool)
        locked[list(offered)] = False
        return polish(
            self.critic.target, _repainted(scene, offered), self.critic.config, self.watch.side_part(),
            iterations=SIMPLIFICATION.stop_iterations, locked=locked, unseen=SIMPLIFICATION.unseen,
            values_exact_max=SIMPLIFICATION.values_exact_max,
        ).scene  # fmt: skip

    def refused(self, old: Scene, new: Scene, offered: dict[int, GradientPaint], top: Integers) -> list[int]:
        """Return the paths ``offered`` another paint whose own pixels ``new`` shows worse than ``old``."""
        before, after = (
            np.bincount(top[top >= 0], self.critic.error(scene)[top >= 0], len(old)) for scene in (old, new)
        )
        allowed = SIMPLIFICATION.stop_noise + SIMPLIFICATION.stop_share * before
        for path in offered if are_wanted() else ():
            assert old.gradients is not None
            count = len(GradientPaint.of(old, path)), len(offered[path])
            words, cost = [f"{n} stops" for n in count], (float(after[path] - before[path]), float(allowed[path]))
            rows, columns = np.nonzero(top == path)
            place = box_of(np.column_stack([columns, rows]).astype(np.float64))
            self.critic.note("stops", place, words[0], words[1], 4.0 * (count[0] - count[1]), cost)
        return [path for path in offered if after[path] > before[path] + allowed[path]]


def _repainted(scene: Scene, paints: dict[int, GradientPaint]) -> Scene:
    """Return ``scene`` with other paints for some paths."""
    gradients = scene.gradients
    assert gradients is not None
    stops = gradients.all_stops().map(torch.clone)
    color, opacity, kind = scene.color.clone(), scene.opacity.clone(), gradients.kind.clone()
    geometry, end_color = gradients.geometry.clone(), gradients.end_color.clone()
    for path, paint in paints.items():
        count, values = len(paint), torch.from_numpy(paint.color).to(color)
        kind[path], stops.count[path] = paint.kind, max(count, 2)
        color[path], end_color[path] = values[0, :3], values[-1, :3]
        numbers = torch.from_numpy(paint.geometry).to(color)
        geometry[path], stops.breadth[path] = numbers[:GEOMETRY_SIZE], numbers[GEOMETRY_SIZE]
        if count == 1:
            opacity[path] *= values[0, 3]
        stops.offset[path], stops.opacity[path] = 1.0, 1.0
        stops.offset[path, :count] = torch.from_numpy(paint.offset).to(color)
        stops.opacity[path, :count] = values[:, 3]
        stops.inner_color[path] = 0.0
        stops.inner_color[path, : max(count - 2, 0)] = values[1:-1, :3]
    return replace(scene.detach(), color=color, opacity=opacity, gradients=Gradients(kind, geometry, end_color, stops))
