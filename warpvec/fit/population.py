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
from warpvec.fit.palette import Palette, drawn_colors
from warpvec.fit.state import State
from warpvec.fit.state_form import Exactly, Fields, Form, Maybe, Part, Whole, check_fields, floats, require, wholes
from warpvec.geometry.bezier import curve_boxes
from warpvec.geometry.scene import Scene
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
        self._palette: Palette | None = None
        self._curves = config.curves
        self._rates = (config.lr_points, config.lr_color, config.lr_opacity)
        self._launch = Launcher(str(scene.points.device), threads=1)
        # Parameters and state: points [5, N, 2 P], colour [5, N, 3], opacity [5, N, 1] and background [5, 1, 3].
        self._rows = self._fresh_rows(scene)
        self._background = _fresh(self._raw_color(scene.background)[None])
        # Steps taken [N + 1]; the last entry is the background's.
        self._age = torch.zeros(len(scene) + 1, dtype=torch.int64, device=scene.points.device)
        self._factor = torch.ones(1, dtype=torch.float64, device=scene.points.device)
        self.serial = torch.arange(len(scene), device=scene.points.device)
        self._created = len(scene)
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
            live = self.live
            points, color = live.points.clone(), live.color.clone()
            opacity, background = live.opacity.clone(), live.background.clone()
            self._copy = replace(live, points=points, color=color, opacity=opacity, background=background)
        return self._copy

    def step(
        self,
        adj_points: Tensor,
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
        else:
            torch.mul(fits, factor, out=self._factor)
            self._age += fits > 0.0
        adjoints = (adj_points.flatten(1), adj_color, adj_opacity[:, None], adj_background[None])
        arrays = [self._strided(values) for values in adjoints]
        rows = len(self) + (0 if self._fixed_background else 1)
        self._launch(self._kernel, rows * self._threads_per_path, [*self._settings, *arrays, *self._arrays])
        self._constrain()
        self._copy = None

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
            "points": self._rows[0],
            "color": self._rows[1],
            "opacity": self._rows[2],
            "background": self._background,
            "age": self._age,
            "serial": self.serial,
            "created": self._created,
            "live": self.live.to_dict(),
            "palette": None if self._palette is None else self._palette.state(),
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
        width = self.live.points.shape[1:].numel()
        check_fields(
            "population",
            state,
            points=floats(_PLANES, path_count, width),
            color=floats(_PLANES, path_count, 3),
            opacity=floats(_PLANES, path_count, 1),
            background=floats(_PLANES, 1, 3),
            age=wholes(path_count + 1, high=iteration),
            serial=wholes(path_count),
            created=Whole(path_count, self._curves * (iteration + 1)),
            live=scene_form(self.live, path_count, generation_max),
            palette=Maybe(Part()) if palette else Exactly(None),
        )
        serial = state["serial"].unique()
        is_possible = len(serial) == path_count and bool((serial < state["created"]).all())
        require(is_possible, "population.serial", "numbers two paths alike, or has a number of no path")
        for name in ("color", "background"):
            if not self._logit_color:
                floats(*state[name][0].shape, **_UNIT).check(f"population.{name}", state[name][0])
        for name in ("points", "color", "opacity", "background"):
            check_averages(f"population.{name}", *state[name][1:])
        if palette is not None and state["palette"] is not None:
            palette.check(state["palette"], iteration, path_count, self.live.transparent)
        self._check_live(state)

    def _check_live(self, state: State) -> None:
        """Refuse a live scene that is not what the parameters and the palette of ``state`` stand for."""
        live = Scene(**state["live"])
        made = self._to_scene((state["points"], state["color"], state["opacity"]), live)
        own = self._to_color(state["background"][0, 0])
        background = self.live.background.to(own.device) if self._fixed_background else own
        color, opacity = made.color, torch.ones_like(made.opacity) if self._opaque else made.opacity
        if state["palette"] is not None:
            drawn = drawn_colors(state["palette"]["free"], state["palette"]["entry"])
            color, background = drawn[:-1], background if live.transparent else drawn[-1]
        made = replace(live, points=made.points, color=color, opacity=opacity, background=background)
        for name, value in made.to_dict().items():
            if isinstance(value, Tensor):
                is_same = torch.allclose(value, getattr(live, name), rtol=1e-4, atol=1e-4)
                require(is_same, f"population.live.{name}", "does not go with the parameters of the paths")

    def restore(self, state: State, palette: Palette | None) -> None:
        """Continue from ``state``, which :meth:`check` has accepted; ``palette`` is the fit's palette, if it has one.

        The state keeps memory of its own.
        """
        device = self.serial.device
        points, color, opacity, self._background, self._age, self.serial = (
            state[name].to(device, copy=True) for name in ("points", "color", "opacity", "background", "age", "serial")
        )
        self._rows, self._created = (points, color, opacity), state["created"]
        if palette is not None and state["palette"] is not None:
            palette.restore(state["palette"], str(device))
            self._palette = palette
        live: dict[str, Any] = {
            name: value.clone() if isinstance(value, Tensor) else value for name, value in state["live"].items()
        }
        self._set_live(Scene(**live).to(str(device)))

    def keep(self, rows: Tensor) -> None:
        """Keep the paths ``rows``: a mask, or indices in the new order."""
        self.before_use()
        self._rows = tuple(values[:, rows].contiguous() for values in self._rows)
        self._age = torch.cat([self._age[:-1][rows], self._age[-1:]])
        self.serial = self.serial[rows]
        if self._palette is not None:
            self._palette.keep(rows)
        self._set_live(self.live.select(rows))

    def sort_by_area(self) -> None:
        """Sort the paths by the area of their bounding boxes, the smallest on top."""
        self.before_use()
        box = curve_boxes(self.live.points, self.live.degree)
        order = (box[:, 2:] - box[:, :2]).prod(-1).argsort(descending=True, stable=True)
        if not torch.equal(order, torch.arange(len(order), device=order.device)):
            self.keep(order)

    def append(self, scene: Scene) -> None:
        """Add the paths of ``scene`` on top, with fresh optimizer state."""
        self.before_use()
        new = self._fresh_rows(scene)
        added = self._to_scene(new, scene)
        self._rows = tuple(torch.cat(pair, 1) for pair in zip(self._rows, new, strict=True))
        self._age = torch.cat([self._age[:-1], self._age.new_zeros(len(scene)), self._age[-1:]])
        self.serial = torch.cat([self.serial, torch.arange(len(scene), device=self.serial.device) + self._created])
        self._created += len(scene)
        if self._palette is not None:
            self._palette.append(scene.color)
        names = ("points", "color", "opacity", "generation")
        joined = (torch.cat([getattr(self.live, name), getattr(added, name)]) for name in names)
        points, color, opacity, generation = joined
        self._set_live(replace(self.live, points=points, color=color, opacity=opacity, generation=generation))

    def _set_live(self, scene: Scene) -> None:
        """Make ``scene``, which shares no memory, the live one, and prepare the step's arguments for its memory."""
        self.live, self._copy, self._prefix_counts = scene, None, None
        cuda, dtype = self._launch.device.is_cuda, wp.dtype_from_torch(scene.points.dtype)
        lanes = make_lanes(1 if cuda else TILE, dtype)
        self._kernel, self._threads_per_path = make_kernels(lanes).step_population, threads_per_path(lanes)
        color_form = SIGMOID if self._logit_color else CLAMPED
        log_betas = lanes.vec3(*(math.log(beta) for beta in BETAS))
        rates = [wp.vec3d(*self._rates), as_warp(self._factor, wp.float64)]
        betas = [lanes.vec3(*BETAS), log_betas, lanes.dtype(EPS), as_warp(self._age, wp.int64)]
        self._settings = [len(scene), lanes.dtype(self._half_side), color_form, *rates, *betas]
        outputs = (scene.points.flatten(1), scene.color, scene.opacity[:, None], scene.background[None])
        self._arrays = [as_warp(values, dtype) for values in (*self._rows, self._background, *outputs)]
        self._constrain()

    def _constrain(self) -> None:
        """Apply opaque paths and the palette to the live scene, in place."""
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
        points = (scene.points / self._half_side).flatten(1)
        return tuple(_fresh(raw) for raw in (points, self._raw_color(scene.color), opacity))

    def _to_scene(self, rows: tuple[Tensor, ...], scene: Scene) -> Scene:
        """Return the scene that the parameters in ``rows`` stand for, in the shapes of ``scene``."""
        points, color, opacity = (values[0] for values in rows)
        points = (points * self._half_side).reshape(scene.points.shape)
        return replace(scene, points=points, color=self._to_color(color), opacity=opacity[:, 0].sigmoid())

    def _raw_color(self, color: Tensor) -> Tensor:
        return color.logit(_LOGIT_MARGIN) if self._logit_color else color

    def _to_color(self, raw: Tensor) -> Tensor:
        return raw.sigmoid() if self._logit_color else raw.clone()


def scene_form(like: Scene, path_count: int, generation_max: int) -> Form:
    """Return the form of the fields of a scene of the kind of ``like`` with ``path_count`` paths."""
    fields: dict[str, Form] = {
        "points": floats(path_count, *like.points.shape[1:], low=-POINT_MAX, high=POINT_MAX),
        "color": floats(path_count, 3, **_UNIT),
        "opacity": floats(path_count, **_UNIT),
        "background": floats(3, **_UNIT),
        "generation": wholes(path_count, high=generation_max),
        "degree": Exactly(like.degree),
        "transparent": Exactly(like.transparent),
    }
    return Fields(fields)


def do_nothing() -> None:
    """Do nothing: what a population does before its paths are used, unless a fit wants something else."""


def _fresh(raw: Tensor) -> Tensor:
    """Return planes [5, rows, width]: the parameters ``raw`` [rows, width] and a state of zeros."""
    rows = raw.new_zeros(_PLANES, *raw.shape)
    rows[0] = raw
    return rows
