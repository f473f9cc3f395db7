"""Host side of stage 4, compositing: the image, and the adjoints of colour, opacity, background and winding."""

from __future__ import annotations

import sys
from copy import copy
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
import torch
import warp as wp
from numpy.typing import NDArray
from torch import Tensor

from warpvec.errors import InputError
from warpvec.geometry.gradients import Gradients
from warpvec.kernels import compositing as kernels
from warpvec.kernels import compositing_adjoint as adjoint_kernels
from warpvec.kernels.compositing_adjoint import CANVAS_TERMS, TERMS
from warpvec.kernels.constants import TILE, TRANSMITTANCE_MIN
from warpvec.kernels.gradients import GRADIENT_TERMS
from warpvec.kernels.lanes import Lanes
from warpvec.kernels.stops import STOP_TERMS, make_functions
from warpvec.rendering.launch import Buffers, Launcher, as_warp
from warpvec.rendering.stages.binning import Binning, TileGrid
from warpvec.rendering.stop_paints import StopAdjoints, StopPaints


def to_tiles(image: Tensor, grid: TileGrid) -> Tensor:
    """Cut [h, w, c] into [tiles, c, TILE, TILE], column by column within a tile, zero outside the canvas."""
    height, width = grid.rows * TILE, grid.columns * TILE
    padded = torch.nn.functional.pad(image, (0, 0, 0, width - grid.width, 0, height - grid.height))
    tiles = padded.reshape(grid.rows, TILE, grid.columns, TILE, -1).permute(0, 2, 4, 3, 1)
    return tiles.reshape(grid.count, -1, TILE, TILE).contiguous()


def from_tiles(tiles: Tensor, grid: TileGrid) -> Tensor:
    """Invert :func:`to_tiles`."""
    image = tiles.reshape(grid.rows, grid.columns, -1, TILE, TILE).permute(0, 4, 1, 3, 2)
    whole = image.reshape(grid.rows * TILE, grid.columns * TILE, tiles.shape[1])
    return whole[: grid.height, : grid.width].contiguous()


class Paint:
    """Colours, opacities, background and gradients of a scene, as Warp arrays over torch memory.

    Attributes:
        arrays: colour [N], opacity [N] and background [1].
        gradients: kind [N], geometry [N] and end colour [N]; None three times in a scene without gradients of two
            opaque stops alone.
        stops: the gradients of a scene with others, and what the kernels take: count, kind of place, form and ramps of
            each path [N]; None five times in a scene without.
        hiding: opacity of each path [N] where it is most translucent.
        share: for which share of each pixel of the partial pairs the colour of their path answers, in the layout of
            their coverage; None where that is what it covers. It changes nothing but the adjoint of colours.
    """

    def __init__(
        self,
        color: Tensor,
        opacity: Tensor,
        background: Tensor,
        lanes: Lanes,
        buffers: Buffers,
        gradients: Gradients | None = None,
    ) -> None:
        self.path_count = len(color)
        self.opacity = opacity.detach()
        self.arrays = [
            buffers.view("color", color, lanes.vec3),
            buffers.view("opacity", opacity, lanes.dtype),
            buffers.view("background", background, lanes.vec3, 1, 3),
        ]
        self.gradients: list[Any] = [None, None, None]
        self.stop_arrays: list[Any] = [None, None, None, None]
        self.hiding = self.arrays[1]
        self.stops: StopPaints | None = None
        self.share: wp.array | None = None
        if gradients is not None:
            gradients.check_kinds()
        if gradients is not None and gradients.stops is not None:
            self._set_stops(StopPaints(color.detach(), self.opacity, gradients.map(Tensor.detach)), lanes)
        elif gradients is not None:
            kind = buffers.view("kind", gradients.kind, wp.int32)
            geometry = buffers.view("geometry", gradients.geometry, lanes.vec4)
            self.gradients = [kind, geometry, buffers.view("end_color", gradients.end_color, lanes.vec3)]

    def _set_stops(self, stops: StopPaints, lanes: Lanes) -> None:
        types = make_functions(lanes)
        counts = [as_warp(each, wp.int32) for each in (stops.count, stops.place_kind)]
        self.stop_arrays = [*counts, as_warp(stops.form, types.vec5), as_warp(stops.ramps, types.vec8)]
        self.hiding, self.stops = as_warp(stops.hiding, lanes.dtype), stops

    def over(self, background: Tensor, lanes: Lanes) -> Paint:
        """Return the same paint over another ``background`` [3]."""
        found = copy(self)
        found.arrays = [*self.arrays[:2], as_warp(background.reshape(1, 3), lanes.vec3)]
        return found

    @property
    def variant(self) -> tuple[bool, bool]:
        """Whether the scene has gradients of two opaque stops alone, and whether it has others."""
        return self.gradients[0] is not None, self.stops is not None


class PaintAdjoints(NamedTuple):
    """Output tensors for the adjoints of the paint, each contiguous and in the renderer's precision.

    Attributes:
        color, opacity: adjoints of the paths [N, 3] and [N].
        opacity_curvature: [N], filled if it is asked for; see ``kernels/compositing_adjoint.py``.
        canvas_sums: [CANVAS_TERMS] adjoint of the background and, last, the squared error times its scale.
        end_color, geometry: adjoints of the gradients [N, 3] and [N, 4]; None if all paths are flat.
        inner_color, offset, stop_opacity, breadth: adjoints of their stops; None if the scene has no `Stops`.
    """

    color: Tensor
    opacity: Tensor
    opacity_curvature: Tensor
    canvas_sums: Tensor
    end_color: Tensor | None = None
    geometry: Tensor | None = None
    inner_color: Tensor | None = None
    offset: Tensor | None = None
    stop_opacity: Tensor | None = None
    breadth: Tensor | None = None

    def take(self, found: StopAdjoints) -> None:
        """Fill in the adjoints of paints with stops."""
        own = (
            self.color,
            self.end_color,
            self.geometry,
            self.inner_color,
            self.offset,
            self.stop_opacity,
            self.breadth,
        )
        for memory, values in zip(own, found, strict=True):
            assert memory is not None
            memory.copy_(values)

    def of_paths(self, lanes: Lanes, buffers: Buffers) -> list[Any]:
        """Return the adjoints of the paths as Warp arrays."""
        dtypes = {"color": lanes.vec3, "opacity": lanes.dtype, "opacity_curvature": lanes.dtype}
        dtypes |= {"end_color": lanes.vec3, "geometry": lanes.vec4}
        values = ((name, getattr(self, name), dtype) for name, dtype in dtypes.items())
        return [None if value is None else buffers.view(f"adj_{name}", value, dtype) for name, value, dtype in values]


class Compositing:
    """Forward and adjoint compositing of a canvas."""

    def __init__(
        self, launch: Launcher, lanes: Lanes, grid: TileGrid, transmittance_min: float = TRANSMITTANCE_MIN
    ) -> None:
        self._launch, self._lanes, self._grid = launch, lanes, grid
        self._transmittance_min = lanes.dtype(transmittance_min)
        # Lowered when memory was too small for more entries.
        self._stack_entries_max = sys.maxsize
        self._buffers = launch.make_buffers()
        self._measured: dict[int, tuple[Tensor, wp.array]] = {}

    def measure(self, tile_target: Tensor) -> None:
        """Measure a target [tiles, 3, TILE, TILE] that stays as it is: tiles of one colour are then not looked at."""
        if self._lanes.width == 1:
            return
        grid, values = self._grid, tile_target.flatten(2).double()  # which are 0 outside of the canvas
        rows = (grid.height - TILE * torch.arange(grid.rows)).clamp_max(TILE)
        columns = (grid.width - TILE * torch.arange(grid.columns)).clamp_max(TILE)
        count = (rows[:, None] * columns).reshape(-1, 1).to(values)
        mean = values.sum(2) / count
        off = values.square_().sum((1, 2))[:, None] - count * mean.square().sum(1, keepdim=True)
        moments = torch.cat([count, mean, off.clamp_min(0.0)], 1).to(tile_target)
        self._measured[tile_target.data_ptr()] = tile_target, as_warp(moments, self._lanes.dtype, whole=True)

    def paint(self, color: Tensor, opacity: Tensor, background: Tensor, gradients: Gradients | None = None) -> Paint:
        """Return the paint of a scene: colours [N, 3], opacities [N], background [3], and gradients."""
        return Paint(color, opacity, background, self._lanes, self._buffers, gradients)

    def find_visible(self, binning: Binning, paint: Paint) -> wp.array:
        """Return the lowest hit of each tile [tiles] that is not hidden behind the tile's full pairs."""
        visible = self._buffers.get("tile_first_visible", self._grid.count, wp.int32)
        hits = [binning.tile_first_hit, binning.hit_pair, binning.pair_path, binning.pair_class]
        arguments = [*hits, paint.hiding, self._transmittance_min, visible]
        self._launch(kernels.make_kernels(self._lanes).find_visible, self._grid.count, arguments)
        return visible

    def run(
        self, binning: Binning, tile_first_visible: wp.array, slot_winding: wp.array, paint: Paint, tile_image: Tensor
    ) -> None:
        """Composite into ``tile_image`` [tiles, 3, TILE, TILE]."""
        lanes = self._lanes
        arguments = [*hits_of(binning, tile_first_visible), slot_winding, *paint.arrays]
        arguments += [*paint.gradients, *paint.stop_arrays]
        kernel = kernels.make_kernels(lanes, *paint.variant).composite
        outputs = [self._grid.columns, _lane_array(tile_image, lanes)]
        self._launch.shared(kernel, self._grid.count * lanes.tile_threads, [*arguments, *outputs])

    def adjoint(
        self,
        binning: Binning,
        tile_first_visible: wp.array,
        slot_winding: wp.array,
        paint: Paint,
        tile_reference: Tensor,
        adjoints: PaintAdjoints,
        error_scale: float | None = None,
        want_curvature: bool = False,
    ) -> None:
        """Fill ``adjoints``, and overwrite ``slot_winding`` with its adjoint.

        ``tile_reference`` [tiles, 3, TILE, TILE] is dL/d(image), or the target if ``error_scale`` = dL/d(squared error)
        is given; a fourth plane shifts the target, see ``kernels/compositing_adjoint.py``.
        ``want_curvature`` asks for the opacity curvature of the paths.
        """
        lanes, grid, get = self._lanes, self._grid, self._buffers.get
        variant = (error_scale is not None, want_curvature, *paint.variant, paint.share is not None)
        stage = adjoint_kernels.make_kernels(lanes, *variant)
        chunk, depth, stack, parts = self._stack(binning)
        has_gradients, has_stops = paint.variant
        terms = TERMS + GRADIENT_TERMS * has_gradients + STOP_TERMS * has_stops
        pair_sums = get("pair_sums", (binning.pair_count * lanes.reducers, terms), lanes.dtype)
        tile_sums = get("tile_sums", (grid.count * lanes.reducers, TERMS), lanes.dtype)
        known = self._measured.get(tile_reference.data_ptr())
        moments = [None, 0] if known is None else [known[1], 1]
        reference = [_lane_array(tile_reference, lanes), tile_reference.shape[1], *moments]
        size = [grid.columns, grid.height, grid.width]
        scale = lanes.dtype(error_scale or 0.0)
        paints = [*paint.arrays, *paint.gradients, *paint.stop_arrays]
        inputs = [*hits_of(binning, tile_first_visible), *paints, *size, *reference, scale, chunk, depth]
        outputs = [stack, paint.share, slot_winding, pair_sums, tile_sums]
        # Chunks are whole tiles, because the scalar lanes of a tile add to the same sums.
        threads, tiles = lanes.tile_threads, self._launch.chunk_items(grid.count)
        for part in parts:
            arguments, count = [*inputs, part.first_entry, *outputs], part.end - part.start
            self._launch.shared(
                stage.composite_adjoint, count * threads, arguments, tiles * threads, part.start * threads
            )
        pairs, sums = [binning.path_first_pair, binning.pair_class], pair_sums
        if lanes.width == 1:  # a thread of a GPU would take long for all pairs of a large path
            sums = get("path_sums", (paint.path_count * lanes.reducers, terms), lanes.dtype)
            self._launch(stage.gather_pairs, paint.path_count * threads, [*pairs, pair_sums, sums])
        arguments = [*pairs, sums, *paint.gradients[:2], *adjoints.of_paths(lanes, self._buffers)]
        self._launch(stage.gather_paths_adjoint, paint.path_count, arguments)
        if paint.stops is not None:
            stop_sums = torch.empty(
                (paint.path_count, STOP_TERMS), dtype=adjoints.color.dtype, device=adjoints.color.device
            )
            items = [*pairs, pair_sums, paint.stop_arrays[0], as_warp(stop_sums, lanes.dtype)]
            self._launch(stage.gather_stops, stop_sums.numel(), items)
            adjoints.take(paint.stops.adjoints(adjoints.color, stop_sums))
        canvas_sums = self._buffers.view("canvas_sums", adjoints.canvas_sums, lanes.dtype)
        self._gather_canvas(stage, tile_sums, scale, canvas_sums)

    def _gather_canvas(self, stage: SimpleNamespace, tile_sums: wp.array, scale: Any, canvas_sums: wp.array) -> None:
        lanes, capacity = self._lanes, self._launch.capacity
        group_sums = self._buffers.get("group_sums", (lanes.canvas_reducers, CANVAS_TERMS), wp.float64)
        row_count = self._grid.count * lanes.reducers
        self._launch(stage.gather_tiles, lanes.canvas_threads, [tile_sums, row_count, group_sums])
        arguments = [group_sums, scale, capacity.flags, capacity.dropped_steps, capacity.fits, canvas_sums]
        self._launch(stage.gather_canvas, CANVAS_TERMS, arguments)

    def _stack(self, binning: Binning) -> tuple[int, int, wp.array, list[TileRange]]:
        """Return what holds the colours behind each hit.

        These are: tiles per chunk (0 on scalar lanes), entries per chunk, the stack, and the tiles of each launch.
        """
        lanes, count = self._lanes, self._grid.count
        if lanes.tile_threads > 1:
            return 0, 0, *self._stack_of_all(binning)
        chunk = self._launch.chunk_items(count)
        depth = 1 + int(np.diff(binning.tile_first_hit.numpy()[: count + 1]).max())
        size = -(-count // chunk) * depth * 3 * lanes.tile_vectors
        return chunk, depth, self._buffers.get("stack", size, lanes.vector), [TileRange(0, count, 0)]

    def _stack_of_all(self, binning: Binning) -> tuple[wp.array, list[TileRange]]:
        """Return a stack for all tiles; if there is too little memory, one for fewer tiles at a time, and which."""
        count = self._grid.count
        entry_count = binning.pair_count + count
        can_cut = self._launch.capacity.limit is None  # else the host does not know the hits of each tile
        if entry_count <= self._stack_entries_max or not can_cut:
            try:
                return self._make_stack(entry_count), [TileRange(0, count, 0)]
            except (InputError, RuntimeError):
                if not can_cut:
                    raise
                self._stack_entries_max = entry_count // 2
        tile_entries = binning.tile_first_hit.numpy()[: count + 1] + np.arange(count + 1)
        deepest = int(np.diff(tile_entries).max())
        while True:
            entry_count = max(self._stack_entries_max, deepest)
            try:
                return self._make_stack(entry_count), tile_ranges(tile_entries, entry_count)
            except (InputError, RuntimeError):
                if entry_count == deepest:
                    raise
                self._stack_entries_max = entry_count // 2

    def _make_stack(self, entry_count: int) -> wp.array:
        return self._buffers.get("stack", entry_count * 3 * TILE * TILE, self._lanes.vector)


class TileRange(NamedTuple):
    """Tiles of one launch, ``end`` excluded, and the entries of the stack for all tiles that lie before theirs."""

    start: int
    end: int
    first_entry: int


def tile_ranges(tile_entries: NDArray[np.int64], entry_count: int) -> list[TileRange]:
    """Cut the tiles into ranges of at most ``entry_count`` entries; tile t has the entries [t] to [t + 1]."""
    ranges, start, count = [], 0, len(tile_entries) - 1
    while start < count:
        end = int(np.searchsorted(tile_entries, tile_entries[start] + entry_count, "right")) - 1
        ranges.append(TileRange(start, end, int(tile_entries[start])))
        start = end
    return ranges


def hits_of(binning: Binning, tile_first_visible: wp.array) -> list[Any]:
    """Return what kernels take to walk over the visible hits of a tile."""
    pairs = [binning.hit_pair, binning.pair_path, binning.pair_class, binning.pair_slot]
    return [binning.tile_first_hit, tile_first_visible, *pairs]


def _lane_array(tiles: Tensor, lanes: Lanes) -> Any:
    return as_warp(tiles.reshape(-1) if lanes.width == 1 else tiles.reshape(-1, lanes.width), lanes.vector)
