"""The paths that a fit optimizes: their parameters, their optimizer state, and adding and removing paths."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import torch
import warp as wp
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.adan import check_averages
from warpvec.fit.gradients import GradientParameters
from warpvec.fit.node_state import carried_averages
from warpvec.fit.palette import Palette, drawn_colors
from warpvec.fit.state import State
from warpvec.fit.state_form import (
    Array,
    Exactly,
    Fields,
    Form,
    Maybe,
    Part,
    Whole,
    check_fields,
    floats,
    require,
    row_count,
    wholes,
)
from warpvec.geometry import nodes
from warpvec.geometry.bezier import path_boxes
from warpvec.geometry.gradients import RADIAL, Gradients
from warpvec.geometry.scene import Scene, straightened
from warpvec.kernels.adan import BETAS, CLAMPED, EPS, SIGMOID
from warpvec.kernels.constants import TILE
from warpvec.kernels.lanes import make_lanes
from warpvec.kernels.population import make_kernels, threads_per_path
from warpvec.rendering.launch import Launcher, as_warp, start_warp

# Opacities and logit colours stay this far from 0 and 1, where the logit is infinite.
_LOGIT_MARGIN = 1e-4

# The planes of a parameter: its values, three averages of its gradient, and the previous gradient.
_PLANES = 5

POINT_MAX = 1e9
"""Largest coordinate of a saved path, in pixels: a hundred times as far out as anything is drawn, and within what a
file can state."""

SEGMENTS_MAX = 2**24
"""Most segments of a saved fit: four times as many as the settings allow."""

_UNIT = {"low": -1e-3, "high": 1.001}
"""Limits of saved colours and opacities: [0, 1], and room for the colours of transparent pixels, which are rounded."""


class Population:
    """N paths as free parameters, stepped by Adan. ``warpvec/fit/adan.py`` explains the step and the age of a row.

    Points are in units of half the canvas's longer side, as learning rates are. Opacities are logits. Colours are
    themselves or logits, depending on ``config.color_parameter``. The background is optimized too, unless
    ``config.backdrop`` fixes it or the scene is transparent; a palette applies to a fixed background as well.

    Attributes:
        live: the present paths, in memory that each step overwrites. Adding or removing paths makes new memory.
        before_use: called before the paths are read or changed otherwise than by a step. A fit on a GPU then takes the
            steps again for which there was no room.
        serial: position of each path [N] in the order of creation, which the z-order by area does not keep.
    """

    live: Scene
    _copy: Scene | None
    _prefix_counts: list[int] | None

    def __init__(self, scene: Scene, config: FitConfig, half_side: float) -> None:
        start_warp()
        self.before_use: Callable[[], None] = do_nothing
        self._half_side = half_side
        self._logit_color = config.color_parameter == "logit"
        self._fixed_background = config.backdrop == "white" or scene.transparent
        self._opaque = config.opacity == "opaque"
        self._is_splat = config.renderer == "splat"
        self._palette: Palette | None = None
        self._curves = config.curves
        self._rates = (config.lr_points, config.lr_color, config.lr_opacity)
        self._launch = Launcher(str(scene.segments.device), threads=1)
        # Parameters and state: segments [5, R, 2 M], colour [5, N, 3], opacity [5, N, 1] and background [5, 1, 3].
        self._rows = self._fresh_rows(scene)
        self._background = _fresh(self._raw_color(scene.background)[None])
        device = scene.segments.device
        # Steps taken by the segments [R], and by the paths [N + 1]; the last entry is the background's.
        self._segment_age = torch.zeros(scene.structure.segment_count, dtype=torch.int64, device=device)
        self._age = torch.zeros(len(scene) + 1, dtype=torch.int64, device=device)
        self._factor = torch.ones(1, dtype=torch.float64, device=device)
        self.serial = torch.arange(len(scene), device=device)
        self._created = len(scene)
        self._gradients = None if scene.gradients is None else GradientParameters(scene.gradients, config, half_side)
        self._config = config
        background = scene.background if self._fixed_background else self._to_color(self._background[0, 0])
        self._set_live(replace(self._to_scene(self._rows, scene), background=background))

    def __len__(self) -> int:
        return len(self.live)

    @property
    def generation(self) -> Tensor:
        """Generation (level of detail) of each path [N]."""
        return self.live.generation

    @property
    def prefix_counts(self) -> list[int]:
        """Number of paths up to each generation, lowest first; read from the device once per change of population."""
        if self._prefix_counts is None:
            generations = sorted(self.generation.tolist())
            self._prefix_counts = [bisect_right(generations, level) for level in sorted(set(generations))]
        return self._prefix_counts

    @property
    def scene(self) -> Scene:
        """The present paths. The object never changes; after a step or another change there is a new one."""
        if self._copy is None:
            self.before_use()
            self._copy = self.live.copied()
        return self._copy

    def step(
        self,
        adj_segments: Tensor,
        adj_color: Tensor,
        adj_opacity: Tensor,
        adj_background: Tensor,
        factor: float,
        fits: Tensor | None = None,
    ) -> None:
        """Take an optimizer step from the adjoints of ``scene``'s values, with learning rates multiplied by ``factor``.

        If ``fits`` [1], on the device, is -1 and not 1, the step changes nothing.
        """
        if fits is None:
            self._factor.fill_(factor)
            self._age += 1
            self._segment_age += 1
        else:
            torch.mul(fits, factor, out=self._factor)
            self._age += fits > 0.0
            self._segment_age += fits > 0.0
        adjoints = (adj_segments.contiguous().flatten(1), adj_color, adj_opacity[:, None], adj_background[None])
        arrays = [self._strided(values) for values in adjoints]
        rows = len(self) + (0 if self._fixed_background else 1)
        self._launch(self._kernel, rows * self._threads_per_path, [*self._settings, *arrays, *self._arrays])
        self._constrain()
        self._copy = None

    def step_gradients(
        self, adj_end_color: Tensor, adj_geometry: Tensor, factor: float, fits: Tensor | None = None
    ) -> None:
        """Take an optimizer step of the gradients, as `step` does of the other parameters."""
        assert self._gradients is not None
        self._gradients.step(adj_end_color, adj_geometry, factor, fits)
        self._copy = None

    def paint(self, rows: Tensor, scene: Scene) -> None:
        """Take colours and gradients of the paths ``rows`` (indices) from ``scene``, which has the same paths."""
        assert scene.gradients is not None
        raw = self._raw_color(scene.color[rows])
        for plane, values in enumerate([raw, *[torch.zeros_like(raw)] * (_PLANES - 1)]):
            self._rows[1][plane, rows] = values
        if self._gradients is None:
            self._gradients = GradientParameters(scene.gradients, self._config, self._half_side)
        else:
            self._gradients.replace_rows(rows, scene.gradients)
        color = self.live.color.clone()
        color[rows] = scene.color[rows]
        self._set_live(replace(self.live, color=color))

    @property
    def step_count(self) -> int:
        """Number of steps that have changed the paths; the host waits for the device."""
        return int(self._age[-1])

    @property
    def has_palette(self) -> bool:
        """True if fills come from a palette."""
        return self._palette is not None

    def use_palette(self, palette: Palette, visible_area: Tensor) -> None:
        """Take all fills from ``palette`` from now on; ``visible_area`` [N + 1] is that of the paths and the canvas."""
        palette.start(self._free_colors(), visible_area, self.live.transparent)
        self._palette = palette
        self._constrain()
        self._copy = None

    def state(self) -> State:
        """Return everything that :meth:`restore` needs to continue to the same bits."""
        return {
            "segments": self._rows[0],
            "color": self._rows[1],
            "opacity": self._rows[2],
            "background": self._background,
            "segment_age": self._segment_age,
            "age": self._age,
            "serial": self.serial,
            "created": self._created,
            "live": self.live.to_dict(),
            "palette": None if self._palette is None else self._palette.state(),
            "gradients": None if self._gradients is None else self._gradients.state(),
        }

    def check(
        self, state: State, palette: Palette | None, iteration: int, path_count: int, generation_max: int
    ) -> None:
        """Refuse ``state`` unless :meth:`state` can have returned it after ``iteration``.

        Args:
            palette: the fit's palette, if it has one.
            path_count: number of paths.
            generation_max: highest generation of a path.

        Raises:
            InputError: it cannot.
        """
        rows = row_count("population", state, "segment_age", SEGMENTS_MAX)
        check_fields(
            "population",
            state,
            segments=floats(_PLANES, rows, 2 * self.live.degree),
            color=floats(_PLANES, path_count, 3),
            opacity=floats(_PLANES, path_count, 1),
            background=floats(_PLANES, 1, 3),
            segment_age=wholes(rows, high=iteration),
            age=wholes(path_count + 1, high=iteration),
            serial=wholes(path_count),
            created=Whole(path_count, self._curves * (iteration + 1)),
            live=Part(),
            palette=Maybe(Part()) if palette else Exactly(None),
            gradients=Exactly(None) if palette or self._is_splat else Maybe(Part()),
        )
        check_scene("population.live", state["live"], self.live, path_count, generation_max)
        live = Scene.from_dict(state["live"])
        require(live.structure.segment_count == rows, "population.live", "has other segments than the parameters")
        require(live.is_uniform or not self._is_splat, "population.live", "has paths that are not drawn as splats")
        has_both = (live.gradients is None) == (state["gradients"] is None)
        require(has_both, "population.gradients", "does not go with the paths")
        if live.gradients is not None:
            GradientParameters(live.gradients, self._config, self._half_side).check(state["gradients"], iteration)
        serial = state["serial"].unique()
        is_possible = len(serial) == path_count and bool((serial < state["created"]).all())
        require(is_possible, "population.serial", "numbers two paths alike, or has a number of no path")
        for name in ("color", "background"):
            if not self._logit_color:
                floats(*state[name][0].shape, **_UNIT).check(f"population.{name}", state[name][0])
        for name in ("segments", "color", "opacity", "background"):
            check_averages(f"population.{name}", *state[name][1:])
        if palette is not None and state["palette"] is not None:
            palette.check(state["palette"], iteration, path_count, self.live.transparent)
        self._check_live(live, state)

    def _check_live(self, live: Scene, state: State) -> None:
        """Refuse a ``live`` scene that is not what the parameters and the palette of ``state`` stand for."""
        made = self._to_scene((state["segments"], state["color"], state["opacity"]), live)
        own = self._to_color(state["background"][0, 0])
        background = self.live.background.to(own.device) if self._fixed_background else own
        color, opacity = made.color, torch.ones_like(made.opacity) if self._opaque else made.opacity
        if state["palette"] is not None:
            drawn = drawn_colors(state["palette"]["free"], state["palette"]["entry"])
            color, background = drawn[:-1], background if live.transparent else drawn[-1]
        shown = {"segments": made.segments, "color": color, "opacity": opacity, "background": background}
        for name, value in shown.items():
            is_same = torch.allclose(value, getattr(live, name), rtol=1e-4, atol=1e-4)
            require(is_same, f"population.live.{name}", "does not go with the parameters of the paths")

    def restore(self, state: State, palette: Palette | None) -> None:
        """Continue from ``state``, which :meth:`check` has accepted; ``palette`` is the fit's palette, if it has one.

        The state keeps memory of its own.
        """
        device = self.serial.device
        segments, color, opacity, self._background, self._segment_age, self._age, self.serial = (
            state[name].to(device, copy=True)
            for name in ("segments", "color", "opacity", "background", "segment_age", "age", "serial")
        )
        self._rows, self._created = (segments, color, opacity), state["created"]
        if palette is not None and state["palette"] is not None:
            palette.restore(state["palette"], str(device))
            self._palette = palette
        live = Scene.from_dict(state["live"]).to(str(device)).copied()
        if live.gradients is not None:
            self._gradients = GradientParameters(live.gradients, self._config, self._half_side)
            self._gradients.restore(state["gradients"], str(device))
        self._set_live(live)

    def keep(self, rows: Tensor) -> None:
        """Keep the paths ``rows``: a mask, or indices in the new order."""
        self.before_use()
        _, segments = self.live.structure.select(rows)
        chosen = (segments, rows, rows)
        self._rows = tuple(values[:, each].contiguous() for values, each in zip(self._rows, chosen, strict=True))
        self._segment_age = self._segment_age[segments]
        self._age = torch.cat([self._age[:-1][rows], self._age[-1:]])
        self.serial = self.serial[rows]
        if self._palette is not None:
            self._palette.keep(rows)
        if self._gradients is not None:
            self._gradients.keep(rows)
        self._set_live(self.live.select(rows))

    def sort_by_area(self) -> None:
        """Sort the paths by the area of their bounding boxes, the smallest on top."""
        self.before_use()
        box = path_boxes(self.live)
        order = (box[:, 2:] - box[:, :2]).prod(-1).argsort(descending=True, stable=True)
        if not torch.equal(order, torch.arange(len(order), device=order.device)):
            self.keep(order)

    def append(self, scene: Scene) -> None:
        """Add the paths of ``scene`` on top, with fresh optimizer state."""
        self.before_use()
        new = self._fresh_rows(scene)
        added = self._to_scene(new, scene)
        ages = self._segment_age.new_zeros(scene.structure.segment_count)
        self._rows = tuple(torch.cat(pair, 1) for pair in zip(self._rows, new, strict=True))
        self._segment_age = torch.cat([self._segment_age, ages])
        self._age = torch.cat([self._age[:-1], self._age.new_zeros(len(scene)), self._age[-1:]])
        self.serial = torch.cat([self.serial, torch.arange(len(scene), device=self.serial.device) + self._created])
        self._created += len(scene)
        if self._palette is not None:
            self._palette.append(scene.color)
        if self._gradients is not None:
            self._gradients.append(added.gradients or Gradients.flat(added.color))
        self._set_live(self.live.joined(added))

    def split(self, rows: Tensor, t: Tensor | float = 0.5) -> None:
        """Divide the segments ``rows`` [K] at ``t``, as `warpvec.geometry.nodes.split` does."""
        self._edit_nodes(nodes.split(self.scene, rows, t))

    def merge(self, rows: Tensor) -> tuple[Tensor, Tensor]:
        """Drop the anchors at the start of ``rows`` [K], as `warpvec.geometry.nodes.merge` does.

        Return how far apart the outlines are [K], and the area between them [K].
        """
        return self._edit_nodes(nodes.merge(self.scene, rows))

    def to_line(self, rows: Tensor) -> tuple[Tensor, Tensor]:
        """Make the segments ``rows`` [K] straight lines; return distances and areas as `merge` does."""
        return self._edit_nodes(nodes.to_line(self.scene, rows))

    def to_curve(self, rows: Tensor) -> None:
        """Give the segments ``rows`` [K] handles that are free to move."""
        self._edit_nodes(nodes.to_curve(self.scene, rows))

    def _edit_nodes(self, edit: nodes.Edit) -> tuple[Tensor, Tensor]:
        """Take the segments of ``edit``. Their state follows from that of the segments that they come from."""
        state, age = carried_averages(self._rows[0][1:], self._segment_age, edit)
        fresh = (edit.scene.segments / self._half_side).flatten(1)
        raw = torch.where(edit.is_fresh[:, None], fresh, self._rows[0][0, edit.source[:, 0]])
        self._rows = (torch.cat([raw[None], state]), *self._rows[1:])
        self._segment_age = age
        self._set_live(replace(self.live, segments=edit.scene.segments, structure=edit.scene.structure))
        return edit.distance, edit.area

    def _set_live(self, scene: Scene) -> None:
        """Make ``scene``, which shares no memory, the live one, and prepare the step's arguments for its memory."""
        scene = replace(scene, gradients=None if self._gradients is None else self._gradients.live)
        self.live, self._copy, self._prefix_counts = scene, None, None
        cuda, dtype = self._launch.device.is_cuda, wp.dtype_from_torch(scene.segments.dtype)
        lanes = make_lanes(1 if cuda else TILE, dtype)
        self._kernel, self._threads_per_path = make_kernels(lanes).step_population, threads_per_path(lanes)
        color_form = SIGMOID if self._logit_color else CLAMPED
        log_betas = lanes.vec3(*(math.log(beta) for beta in BETAS))
        rates = [wp.vec3d(*self._rates), as_warp(self._factor, wp.float64)]
        betas = [lanes.vec3(*BETAS), log_betas, lanes.dtype(EPS)]
        ages = [as_warp(self._segment_age, wp.int64), as_warp(self._age, wp.int64)]
        first_segment = as_warp(scene.structure.path_first_segment, wp.int32)
        self._settings = [len(scene), lanes.dtype(self._half_side), color_form, *rates, *betas, first_segment, *ages]
        outputs = (scene.segments.flatten(1), scene.color, scene.opacity[:, None], scene.background[None])
        self._arrays = [as_warp(values, dtype) for values in (*self._rows, self._background, *outputs)]
        self._constrain()

    def _constrain(self) -> None:
        """Straighten lines, and apply opaque paths and the palette, in the live scene in place."""
        if self.live.structure.is_line is not None:
            self.live.segments.copy_(straightened(self.live.segments, self.live.structure))
            self._rows[0][0].copy_((self.live.segments / self._half_side).flatten(1))
        if self._opaque:
            self.live.opacity.fill_(1.0)
        if self._palette is not None:
            color = self._palette.color
            self.live.color.copy_(color[:-1])
            if not self.live.transparent:
                self.live.background.copy_(color[-1])

    def _free_colors(self) -> Tensor:
        """Return the colours [N + 1, 3] that the paths and, last, the background would have without a palette."""
        return self._to_color(torch.cat([self._rows[1][0], self._background[0]]))

    @staticmethod
    def _strided(values: Tensor) -> Any:
        """Return ``values`` as a Warp array. Rows may be any stride apart, since adjoints are columns of wider sums."""
        dense = values.shape[1] == 1 or values.stride(1) == 1
        return wp.from_torch(values if dense else values.contiguous(), return_ctype=True)

    def _fresh_rows(self, scene: Scene) -> tuple[Tensor, ...]:
        opacity = scene.opacity.logit(_LOGIT_MARGIN)[:, None]
        segments = (scene.segments / self._half_side).flatten(1)
        return tuple(_fresh(raw) for raw in (segments, self._raw_color(scene.color), opacity))

    def _to_scene(self, rows: tuple[Tensor, ...], scene: Scene) -> Scene:
        """Return the scene that the parameters in ``rows`` stand for, in the shapes of ``scene``."""
        segments, color, opacity = (values[0] for values in rows)
        segments = (segments * self._half_side).reshape(scene.segments.shape)
        return replace(scene, segments=segments, color=self._to_color(color), opacity=opacity[:, 0].sigmoid())

    def _raw_color(self, color: Tensor) -> Tensor:
        return color.logit(_LOGIT_MARGIN) if self._logit_color else color

    def _to_color(self, raw: Tensor) -> Tensor:
        return raw.sigmoid() if self._logit_color else raw.clone()


def check_scene(name: str, value: Any, like: Scene, path_count: int, generation_max: int) -> None:
    """Refuse ``value`` unless it is the `to_dict` of a scene of the kind of ``like`` with ``path_count`` paths."""
    rows = row_count(name, value, "segments", SEGMENTS_MAX)
    loops = 0 if value.get("loop_first_segment") is None else row_count(name, value, "loop_first_segment", SEGMENTS_MAX)
    is_uniform = like.is_uniform and loops == 0
    count = like.structure.uniform_count
    check_fields(
        name,
        value,
        segments=floats(rows, like.degree, 2, low=-POINT_MAX, high=POINT_MAX),
        uniform_count=Exactly(count) if is_uniform else Exactly(None),
        loop_first_segment=Exactly(None) if is_uniform else wholes(loops, high=rows),
        path_first_loop=Exactly(None) if is_uniform else wholes(path_count + 1, high=max(loops - 1, 0)),
        is_line=Exactly(None) if is_uniform else Maybe(Array(torch.uint8, (rows,), 0, 1)),
        color=floats(path_count, 3, **_UNIT),
        opacity=floats(path_count, **_UNIT),
        background=floats(3, **_UNIT),
        generation=wholes(path_count, high=generation_max),
        transparent=Exactly(like.transparent),
        gradients=Maybe(Fields(gradient_forms(path_count))),
    )
    if is_uniform:
        require(count is not None and rows == count * path_count, f"{name}.segments", "has another number of rows")
    else:
        _check_starts(f"{name}.loop_first_segment", value["loop_first_segment"], rows)
        _check_starts(f"{name}.path_first_loop", value["path_first_loop"], loops - 1)


def gradient_forms(path_count: int) -> dict[str, Form]:
    """Return the forms of the gradients of ``path_count`` paths."""
    return {
        "kind": wholes(path_count, high=RADIAL),
        "geometry": floats(path_count, 4, low=-POINT_MAX, high=POINT_MAX),
        "end_color": floats(path_count, 3, **_UNIT),
    }


def _check_starts(name: str, starts: Tensor, count: int) -> None:
    """Refuse ``starts`` unless they divide ``count`` rows into ranges that are not empty."""
    is_right = len(starts) > 0 and starts[0] == 0 and starts[-1] == count and bool((starts.diff() > 0).all())
    require(is_right, name, "does not divide the rows")


def do_nothing() -> None:
    """Do nothing: what a population does before its paths are used, unless a fit wants something else."""


def _fresh(raw: Tensor) -> Tensor:
    """Return planes [5, rows, width]: the parameters ``raw`` [rows, width] and a state of zeros."""
    rows = raw.new_zeros(_PLANES, *raw.shape)
    rows[0] = raw
    return rows
