"""The base class of the renderers: paths cover the pixels of (path, tile) pairs, and the pairs are composited."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import torch
import warp as wp
from torch import Tensor

from warpvec.geometry.scene import Scene
from warpvec.geometry.stops import STOPS_MAX
from warpvec.geometry.structure import Structure
from warpvec.kernels.compositing_adjoint import CANVAS_TERMS
from warpvec.kernels.constants import COLUMNS, TILE, TRANSMITTANCE_MIN
from warpvec.kernels.lanes import make_lanes
from warpvec.kernels.removal_costs import make_kernels as make_cost_kernels
from warpvec.rendering.capacity import Counts
from warpvec.rendering.launch import Launcher, as_warp, start_warp
from warpvec.rendering.stages.binning import Binning, TileGrid
from warpvec.rendering.stages.compositing import Compositing, Paint, PaintAdjoints, from_tiles, to_tiles

Hits = tuple[Binning, wp.array, wp.array, Paint]
"""Pairs, the lowest visible hit of each tile, coverage of the pairs' pixels, and the paint of the paths."""


@dataclass(frozen=True)
class Adjoints:
    """dL/d(each input) of a render, in the inputs' shapes.

    Attributes:
        canvas_sums: sums over the canvas [4]: dL/d(background), and the mean squared error of a fused step.
        removal_cost: rise of that error when a path is removed [N], if it was asked for.
        end_color, geometry: adjoints of the gradients, if the scene has some.
        width: adjoint of the widths of strokes [N], if the scene has some.
        inner_color, offset, stop_opacity, breadth: adjoints of their stops, if the scene has those.
        softness: adjoint of the standard deviations of soft paths [N], if the scene has some.
        side_opacity: adjoint of the opacities at the sides of paths [N, 2], if the scene has some.
    """

    segments: Tensor
    color: Tensor
    opacity: Tensor
    canvas_sums: Tensor
    removal_cost: Tensor | None = None
    end_color: Tensor | None = None
    geometry: Tensor | None = None
    width: Tensor | None = None
    inner_color: Tensor | None = None
    offset: Tensor | None = None
    stop_opacity: Tensor | None = None
    breadth: Tensor | None = None
    softness: Tensor | None = None
    side_opacity: Tensor | None = None

    @property
    def whole_color(self) -> Tensor:
        """Adjoint of the colour of each path [N, 3]; a gradient divides each pixel between its colours."""
        ends = self.color if self.end_color is None else self.color + self.end_color
        return ends if self.inner_color is None else ends + self.inner_color.sum(1)

    @property
    def background(self) -> Tensor:
        """Adjoint of the canvas colour [3]."""
        return self.canvas_sums[:3]

    @property
    def loss(self) -> Tensor:
        """The mean squared error of a fused step."""
        return self.canvas_sums[3]

    def contrast(self, opacity: Tensor) -> Tensor:
        """Return the change of the loss by each path's removal without its linear part [N], from the ``opacity`` [N].

        The loss is a parabola in the opacity of a path, so this is half of its second derivative times the square of
        the opacity. The adjoints must hold removal costs.
        """
        assert self.removal_cost is not None
        return self.removal_cost + opacity * self.opacity


def mean_adjoints(adjoints: Sequence[Adjoints], without: Sequence[str] = ()) -> Adjoints:
    """Return the mean of ``adjoints``; those that are named in ``without`` are the memory of the first one."""
    names = [name for name, value in vars(adjoints[0]).items() if value is not None and name not in without]
    return replace(adjoints[0], **{name: torch.stack([getattr(a, name) for a in adjoints]).mean(0) for name in names})


class _Covered(NamedTuple):
    """What the last step has covered, and the coverage before its adjoint took its memory.

    Attributes:
        structure: that of the scene.
        values: tensors of the scene. They are kept, so that no other tensor gets their address.
        versions: of these tensors then.
    """

    structure: Structure
    values: list[Tensor]
    versions: list[int]
    hits: Hits
    coverage: Tensor

    def is_of(self, scene: Scene) -> bool:
        """Return whether ``scene`` has these paths."""
        values = _values_of(scene)
        if scene.structure is not self.structure or len(values) != len(self.values):
            return False
        if self.versions != [value._version for value in values]:
            return False
        return all(map(_is_same_memory, values, self.values))


def _is_same_memory(one: Tensor, other: Tensor) -> bool:
    return one.data_ptr() == other.data_ptr() and one.shape == other.shape


def _values_of(scene: Scene) -> list[Tensor]:
    values = [scene.segments, scene.color, scene.opacity]
    if scene.gradients is not None:
        values += [scene.gradients.kind, scene.gradients.geometry, scene.gradients.end_color]
        stops = scene.gradients.stops
        values += [] if stops is None else [stops.inner_color, stops.offset, stops.opacity, stops.breadth]
    strokes = scene.strokes
    values += [] if strokes is None else [strokes.width, strokes.cap, strokes.join, strokes.miter_limit]
    values += [] if scene.softness is None else [scene.softness.sigma]
    values += [] if scene.side_opacity is None else [scene.side_opacity.value]
    return values


class TileRenderer(ABC):
    """Renderer of scenes of one canvas size, with curves of one ``degree``. It keeps its buffers between calls.

    The tensors of a scene must be on the renderer's device, in its dtype (torch.float32, or torch.float64 for checks).
    """

    def __init__(
        self,
        height: int,
        width: int,
        *,
        degree: int = 3,
        device: str = "cpu",
        threads: int | None = None,
        dtype: torch.dtype = torch.float32,
        lane_width: int | None = None,
        transmittance_min: float = TRANSMITTANCE_MIN,
    ) -> None:
        start_warp()
        self.grid, self.degree = TileGrid(height, width), degree
        self._launch = Launcher(device, threads)
        self._lanes = make_lanes(lane_width or (1 if self._launch.device.is_cuda else TILE), wp.dtype_from_torch(dtype))
        self.dtype = dtype
        self.device = torch.device(wp.device_to_torch(self._launch.device))
        self._compositing = Compositing(self._launch, self._lanes, self.grid, transmittance_min)
        self._kept: _Covered | None = None

    def render(self, scene: Scene) -> Tensor:
        """Return the image [h, w, 3]."""
        return from_tiles(self._composite(self._cover(scene)), self.grid)

    def render_over(self, scene: Scene, backgrounds: Sequence[Tensor]) -> Iterator[Tensor]:
        """Yield the image [h, w, 3] over each of the ``backgrounds`` [3]; each path is covered once for all of them.

        Nothing else may be drawn before the last one is taken.
        """
        for tiles in self._tiles_over(scene, backgrounds):
            yield from_tiles(tiles, self.grid)

    def squared_error(self, scene: Scene, views: Sequence[tuple[Tensor, Tensor]]) -> Tensor:
        """Return the squared error of each pixel [h, w], summed over the channels, as a mean over several ``views``.

        A view is a prepared target, and its background [3].
        """
        tiles = self._tiles_over(scene, [background for _, background in views])
        return self.error_of([target for target, _ in views], tiles)

    def error_of(self, targets: Sequence[Tensor], pictures: Iterable[Tensor]) -> Tensor:
        """Return the squared error [h, w] of ``pictures`` [tiles, 3, TILE, TILE], which it overwrites.

        It is summed over the channels, as a mean over the pictures, each against one of the prepared ``targets``.
        """
        total = torch.zeros((self.grid.count, 1, TILE, TILE), dtype=self.dtype, device=self.device)
        for target, tiles in zip(targets, pictures, strict=True):
            squares = tiles.sub_(target[:, :3]).square_()
            total += squares[:, :1].add_(squares[:, 1:2]).add_(squares[:, 2:])
        return from_tiles(total / len(targets), self.grid)[..., 0]

    def _tiles_over(self, scene: Scene, backgrounds: Sequence[Tensor]) -> Iterator[Tensor]:
        """Yield the image over each of the ``backgrounds`` [3] in tiles [tiles, 3, TILE, TILE]."""
        binning, visible, winding, paint = self._cover(scene)
        for background in backgrounds:
            yield self._composite((binning, visible, winding, paint.over(background, self._lanes)))

    def _composite(self, hits: Hits) -> Tensor:
        tiles = self.make_tiles()
        self._compositing.run(*hits, tiles)
        return tiles

    def make_tiles(self) -> Tensor:
        """Allocate a picture in tiles [tiles, 3, TILE, TILE]."""
        return torch.empty((self.grid.count, 3, TILE, TILE), dtype=self.dtype, device=self.device)

    def draw_tiles(self, scene: Scene, tiles: Tensor) -> Tensor:
        """Draw ``scene`` into ``tiles``, from :meth:`make_tiles`, and return them; a graph can record it."""
        self._compositing.run(*self._cover(scene), tiles)
        return tiles

    def adjoint(self, scene: Scene, adj_image: Tensor) -> Adjoints:
        """Return the adjoints of a render for ``adj_image`` = dL/d(image) [h, w, 3]."""
        adjoints = self.make_adjoints(scene)
        hits = self._cover(scene)
        reference = to_tiles(adj_image.to(self.dtype), self.grid)
        self._compositing.adjoint(*hits, reference, self._paint_adjoints(adjoints, adjoints.opacity))
        self._collect(scene, adjoints)
        return adjoints

    def adjoints_over(self, scene: Scene, views: Iterable[tuple[Tensor, Tensor]]) -> Iterator[Adjoints]:
        """Yield what `adjoint` returns for several ``views``: dL/d(image) as `prepare_target` cuts it, and background.

        Each path is covered once for all of them. Nothing else may be drawn before the last one is taken.
        """
        hits = self._cover(scene)
        covered = self._coverage_of(hits).clone()
        for reference, background in views:
            adjoints = self.make_adjoints(scene)
            into = self._paint_adjoints(adjoints, adjoints.opacity)
            self._compositing.adjoint(*self._restored(hits, covered, background), reference, into)
            self._collect(scene, adjoints)
            yield adjoints

    def _restored(self, hits: Hits, covered: Tensor, background: Tensor) -> Hits:
        """Return ``hits`` over a ``background`` [3], with the coverage that an adjoint has overwritten put back."""
        self._coverage_of(hits).copy_(covered)
        binning, visible, winding, paint = hits
        return binning, visible, winding, paint.over(background, self._lanes)

    def _coverage_of(self, hits: Hits) -> Tensor:
        """Return the part of the buffer of coverage that ``hits`` use."""
        found: Tensor = wp.to_torch(hits[2])[: (hits[0].slot_count + 1) * COLUMNS * self._lanes.blocks]
        return found

    def prepare_target(self, target: Tensor, shift: Tensor | None = None) -> Tensor:
        """Return a target image [h, w, 3] in the form that :meth:`fit_step` takes.

        With a ``shift`` [h, w] of all channels, adjoints and removal costs are those of the squared error against the
        shifted target. The loss is still that against the target.
        """
        image = target if shift is None else torch.cat([target, shift[..., None]], 2)
        return to_tiles(image.to(self.device, self.dtype), self.grid)

    def measure_target(self, prepared_target: Tensor) -> None:
        """Make steps faster with a target without a shift that stays as it is: where tiles have one colour."""
        self._compositing.measure(prepared_target)

    def change_shift(self, prepared_target: Tensor, shift: Tensor) -> None:
        """Replace, in place, the shift of a target that :meth:`prepare_target` has made with a shift."""
        prepared_target[:, 3:] = to_tiles(shift[..., None].to(self.device, self.dtype), self.grid)

    def make_adjoints(self, scene: Scene) -> Adjoints:
        """Allocate the adjoints of ``scene``."""
        count = len(scene)
        make = partial(torch.empty, dtype=self.dtype, device=self.device)
        adjoints = Adjoints(make(scene.segments.shape), make((count, 3)), make(count), make(CANVAS_TERMS))
        if scene.strokes is not None:
            adjoints = replace(adjoints, width=make(count))
        if scene.softness is not None:
            adjoints = replace(adjoints, softness=make(count))
        if scene.side_opacity is not None:
            adjoints = replace(adjoints, side_opacity=torch.zeros(count, 2, dtype=self.dtype, device=self.device))
        if scene.gradients is None:
            return adjoints
        adjoints = replace(adjoints, end_color=make((count, 3)), geometry=make((count, 4)))
        if scene.gradients.stops is None:
            return adjoints
        places = {"offset": make((count, STOPS_MAX)), "stop_opacity": make((count, STOPS_MAX))}
        return replace(adjoints, inner_color=make((count, STOPS_MAX - 2, 3)), breadth=make(count), **places)

    def fit_step(
        self,
        scene: Scene,
        prepared_target: Tensor,
        want_removal_cost: bool = False,
        out: Adjoints | None = None,
    ) -> Adjoints:
        """Render, and return the adjoints of the mean squared error, in one pass; with removal costs if wanted.

        If ``out`` is given, the adjoints are written there. Removal costs allocate a tensor if it has none.
        """
        hits = self._cover(scene)
        adjoints = self._paint_step(scene, hits, prepared_target, want_removal_cost, out)
        self._collect(scene, adjoints)
        return adjoints

    def _paint_step(
        self,
        scene: Scene,
        hits: Hits,
        prepared_target: Tensor,
        want_removal_cost: bool,
        out: Adjoints | None = None,
    ) -> Adjoints:
        """Return the adjoints of a fused step without those of the outlines."""
        adjoints = self.make_adjoints(scene) if out is None else out
        scale = 1.0 / (3 * self.grid.height * self.grid.width)
        curvature = adjoints.opacity
        if want_removal_cost:
            kept = adjoints.removal_cost
            curvature = torch.empty_like(adjoints.opacity) if kept is None else kept
        into = self._paint_adjoints(adjoints, curvature)
        self._compositing.adjoint(*hits, prepared_target, into, scale, want_removal_cost)
        # The loss without path i, minus the loss: a parabola, as the image is affine in the opacity of one path.
        if want_removal_cost:
            self._cost_removals(hits[-1].opacity, into.opacity, scale, curvature)
        return replace(adjoints, removal_cost=curvature if want_removal_cost else None)

    def _cost_removals(self, opacity: Tensor, adj_opacity: Tensor, scale: float, curvature: Tensor) -> None:
        """Turn the ``curvature`` [N] of the opacities into removal costs, in place."""
        lanes = self._lanes
        arrays = [as_warp(values, lanes.dtype) for values in (opacity, adj_opacity)]
        outputs = [lanes.dtype(scale), as_warp(curvature, lanes.dtype)]
        self._launch(make_cost_kernels(lanes).cost_removals, len(curvature), [*arrays, *outputs])

    def mean_fit_step(
        self, scene: Scene, views: Sequence[tuple[Tensor, Tensor]], want_removal_cost: bool = False
    ) -> Adjoints:
        """Return the mean of `fit_step` over several ``views``: a prepared target, and its background [3].

        Each path is covered once for all of them, and so are the adjoints of the outlines.
        """
        hits = self._cover(scene)
        coverage = self._coverage_of(hits)
        covered, total, parts = coverage.clone(), torch.zeros_like(coverage), []
        values = _values_of(scene)
        self._kept = _Covered(scene.structure, values, [value._version for value in values], hits, covered)
        for prepared_target, background in views:
            over = self._restored(hits, covered, background)
            parts.append(self._paint_step(scene, over, prepared_target, want_removal_cost))
            total += coverage
        torch.div(total, len(views), out=coverage)
        adjoints = mean_adjoints(parts, without=("segments", "width", "softness", "side_opacity"))
        self._collect(scene, adjoints)
        return adjoints

    def _cover_again(self, scene: Scene) -> Hits:
        """Return what `_cover` does, from the last step if that was of the same paths and nothing was drawn since."""
        kept = self._kept
        if kept is None or not kept.is_of(scene):
            return self._cover(scene)
        return self._restored(kept.hits, kept.coverage, scene.background)

    def set_capacity(self, limit: Counts | None) -> None:
        """Give the next renders the capacity ``limit`` and read no counts back; with None, read counts again."""
        self._launch.capacity.limit = limit

    @property
    def has_exceeded(self) -> bool:
        """Whether the last render exceeded its capacity, and drew nothing; the host waits for the device."""
        return bool(self._launch.capacity.flags.numpy().any())

    @property
    def fits(self) -> Tensor:
        """[1] float64 on the device: 1, or -1 if the last render with an adjoint was dropped: its adjoint is zero."""
        fits: Tensor = wp.to_torch(self._launch.capacity.fits)
        return fits

    @property
    def dropped_steps(self) -> int:
        """Number of renders with an adjoint that exceeded their capacity so far; the host waits for the device."""
        return int(self._launch.capacity.dropped_steps.numpy()[0])

    @property
    def growth(self) -> int:
        """Number of buffers allocated so far; while it stays the same, a recorded step can be replayed."""
        return self._launch.growth

    @property
    @abstractmethod
    def counts(self) -> Counts:
        """Counts of the last render, or its capacity if it had a limit."""

    def _paint_adjoints(self, adjoints: Adjoints, curvature: Tensor) -> PaintAdjoints:
        paths = (adjoints.color, adjoints.opacity, curvature)
        stops = (adjoints.inner_color, adjoints.offset, adjoints.stop_opacity, adjoints.breadth)
        return PaintAdjoints(*paths, adjoints.canvas_sums, adjoints.end_color, adjoints.geometry, *stops)

    @abstractmethod
    def _cover(self, scene: Scene) -> Hits:
        """Return what is composited."""

    @abstractmethod
    def _collect(self, scene: Scene, adjoints: Adjoints) -> None:
        """Fill in the other adjoints; those of the paint are ready, and the coverage buffer holds its adjoint."""
