"""What the renderers share: paths cover the pixels of their (path, tile) pairs, and the pairs are composited."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from functools import partial

import torch
import warp as wp
from torch import Tensor

from warpvec.kernels.compositing_adjoint import CANVAS_TERMS
from warpvec.kernels.constants import TILE
from warpvec.kernels.lanes import make_lanes
from warpvec.rendering.capacity import Counts
from warpvec.rendering.launch import Launcher, start_warp
from warpvec.rendering.stages.binning import Binning, TileGrid
from warpvec.rendering.stages.compositing import Compositing, Paint, PaintAdjoints, from_tiles, to_tiles

Hits = tuple[Binning, wp.array, wp.array, Paint]
"""Pairs, the lowest hit of each tile that is seen, coverage of the pairs' pixels, and what they are painted with."""


@dataclass(frozen=True)
class Adjoints:
    """dL/d(each input) of a render, in the inputs' shapes.

    Attributes:
        canvas: [4] dL/d(background), and the mean squared error of a fused step.
        removal: what that loss gains when a path is removed [N], where it was asked for.
    """

    points: Tensor
    color: Tensor
    opacity: Tensor
    canvas: Tensor
    removal_cost: Tensor | None = None

    @property
    def background(self) -> Tensor:
        return self.canvas[:3]

    @property
    def loss(self) -> Tensor:
        """The mean squared error of a fused step."""
        return self.canvas[3]


class TileRenderer(ABC):
    """Renders scenes of one canvas size; keeps its buffers between calls.

    Inputs of every method are points [N, P, 2] px, color [N, 3], opacity [N] and background [3], on the renderer's
    device in its dtype (torch.float32, or torch.float64 for checks).
    """

    def __init__(
        self,
        height: int,
        width: int,
        device: str,
        threads: int | None,
        dtype: torch.dtype,
        lane_width: int | None,
        transmittance_min: float,
    ) -> None:
        start_warp()
        self.grid = TileGrid(height, width)
        self._launch = Launcher(device, threads)
        self._lanes = make_lanes(lane_width or (1 if self._launch.device.is_cuda else TILE), wp.dtype_from_torch(dtype))
        self.dtype = dtype
        self.device = torch.device(wp.device_to_torch(self._launch.device))
        self._compositing = Compositing(self._launch, self._lanes, self.grid, transmittance_min)

    def render(self, points: Tensor, color: Tensor, opacity: Tensor, background: Tensor) -> Tensor:
        """The image [h, w, 3]."""
        hits = self._cover(points, color, opacity, background)
        tiles = torch.empty((self.grid.count, 3, TILE, TILE), dtype=self.dtype, device=self.device)
        self._compositing.run(*hits, tiles)
        return from_tiles(tiles, self.grid)

    def adjoint(
        self, points: Tensor, color: Tensor, opacity: Tensor, background: Tensor, adj_image: Tensor
    ) -> Adjoints:
        """Adjoints of a render for ``adj_image`` = dL/d(image) [h, w, 3]."""
        adjoints = self.make_adjoints(points)
        hits = self._cover(points, color, opacity, background)
        reference = to_tiles(adj_image.to(self.dtype), self.grid)
        self._compositing.adjoint(*hits, reference, self._paint_adjoints(adjoints, adjoints.opacity))
        self._collect(points, opacity, adjoints)
        return adjoints

    def prepare_target(self, target: Tensor) -> Tensor:
        """A target image [h, w, 3] in the form that :meth:`fit_step` takes."""
        return to_tiles(target.to(self.device, self.dtype), self.grid)

    def make_adjoints(self, points: Tensor) -> Adjoints:
        """Memory for the adjoints of a scene with ``points``."""
        count = len(points)
        make = partial(torch.empty, dtype=self.dtype, device=self.device)
        return Adjoints(make(points.shape), make((count, 3)), make(count), make(CANVAS_TERMS))

    def fit_step(
        self,
        points: Tensor,
        color: Tensor,
        opacity: Tensor,
        background: Tensor,
        prepared_target: Tensor,
        removal_cost: bool = False,
        out: Adjoints | None = None,
    ) -> Adjoints:
        """Render, mean squared error and adjoint in one pass; ``removal_cost`` asks for each path's importance.

        The adjoints are put in ``out`` where that is given: then no tensor is made, unless removal is asked for.
        """
        adjoints = self.make_adjoints(points) if out is None else out
        hits = self._cover(points, color, opacity, background)
        scale = 1.0 / (3 * self.grid.height * self.grid.width)
        importance = torch.empty_like(adjoints.opacity) if removal_cost else adjoints.opacity
        into = self._paint_adjoints(adjoints, importance)
        self._compositing.adjoint(*hits, prepared_target, into, scale, removal_cost)
        # L without path i, minus L: the image is affine in one path's painted opacity, the loss a parabola.
        o = hits[-1].opacity
        gain = o * o * importance * scale - o * into.opacity if removal_cost else None
        self._collect(points, opacity, adjoints)
        return replace(adjoints, removal_cost=gain)

    def limit(self, room: Counts | None) -> None:
        """Give the next renders ``room``, and read no counts back; with None, as much as they need."""
        self._launch.capacity.room = room

    @property
    def fits(self) -> Tensor:
        """[1] float64 on the device: 1, or -1 if the last render with an adjoint had no room, which then is zero."""
        fits: Tensor = wp.to_torch(self._launch.capacity.fits)
        return fits

    @property
    def dropped_steps(self) -> int:
        """Renders with an adjoint so far that had no room; the host waits for the device to tell."""
        return int(self._launch.capacity.dropped_steps.numpy()[0])

    @property
    def growth(self) -> int:
        """How often a buffer has moved; while it stays the same a recorded step can be replayed."""
        return self._launch.growth

    @property
    @abstractmethod
    def counts(self) -> Counts:
        """What the last render made, or had room for."""

    def _paint_adjoints(self, adjoints: Adjoints, importance: Tensor) -> PaintAdjoints:
        return PaintAdjoints(adjoints.color, adjoints.opacity, importance, adjoints.canvas)

    @abstractmethod
    def _cover(self, points: Tensor, color: Tensor, opacity: Tensor, background: Tensor) -> Hits:
        """What is composited."""

    @abstractmethod
    def _collect(self, points: Tensor, opacity: Tensor, adjoints: Adjoints) -> None:
        """Fill in the other adjoints, once those of the paint are there and the coverage holds its own."""
