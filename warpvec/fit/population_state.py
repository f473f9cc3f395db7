"""Which saved states of paths a fit may continue from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.adan import check_averages
from warpvec.fit.gradient_paints import GradientParameters
from warpvec.fit.palette import Palette, drawn_colors
from warpvec.fit.parametrization import FIXED_OPACITIES, PLANES, Parametrization
from warpvec.fit.state import State
from warpvec.fit.state_form import (
    array,
    check_fields,
    exactly,
    field_set,
    fields,
    floats,
    integer,
    maybe,
    require,
    row_count,
    wholes,
)
from warpvec.geometry.paints.registry import KINDS
from warpvec.geometry.scene import Scene

POINT_MAX = 1e9
"""Largest coordinate of a saved path, in pixels: a hundred times as far out as anything is drawn, and within what a
file can state."""

SEGMENTS_MAX = 2**24
"""Most segments of a saved fit: four times as many as the settings allow."""

_UNIT = {"low": -1e-3, "high": 1.001}
"""Limits of saved colours and opacities: [0, 1], and room for the colours of transparent pixels, which are rounded."""


@dataclass(frozen=True)
class StateCheck:
    """The common form of the states of the paths of a fit.

    Attributes:
        like: the paths with which the fit starts.
        config: the settings of the fit.
        parameters: the units of the parameters.
        palette: the fit's palette, if it has one.
    """

    like: Scene
    config: FitConfig
    parameters: Parametrization
    palette: Palette | None

    def check(self, state: State, iteration: int, path_count: int, generation_max: int) -> None:
        """Refuse ``state`` unless `Population.state` can have returned it after ``iteration``.

        Args:
            path_count: number of paths.
            generation_max: highest generation of a path.

        Raises:
            InputError: it cannot.
        """
        rows = row_count("population", state, "segment_age", SEGMENTS_MAX)
        self._check_form(state, rows, iteration, path_count)
        check_scene("population.live", state["live"], self.like, path_count, generation_max)
        live = Scene.from_dict(state["live"])
        has_equal_paths = self.config.renderer != "exact"
        require(live.structure.segment_count == rows, "population.live", "has other segments than the parameters")
        require(live.is_uniform or not has_equal_paths, "population.live", "has paths that the renderer cannot draw")
        self._check_gradients(live, state, iteration)
        serial = state["serial"].unique()
        is_possible = len(serial) == path_count and bool((serial < state["created"]).all())
        require(is_possible, "population.serial", "numbers two paths alike, or has a number of no path")
        for name in ("color", "background"):
            if not self.parameters.logit_color:
                floats(*state[name][0].shape, **_UNIT)(f"population.{name}", state[name][0])
        for name in ("segments", "color", "opacity", "background"):
            check_averages(f"population.{name}", *state[name][1:])
        if self.palette is not None and state["palette"] is not None:
            self.palette.check(state["palette"], iteration, path_count, self.like.transparent)
        self._check_live(live, state)

    def _check_form(self, state: State, rows: int, iteration: int, path_count: int) -> None:
        """Refuse ``state`` unless its fields have the shapes of ``path_count`` paths of ``rows`` segments."""
        can_have_gradients = self.palette is None and self.config.renderer == "exact"
        check_fields(
            "population",
            state,
            segments=floats(PLANES, rows, 2 * self.like.degree),
            color=floats(PLANES, path_count, 3),
            opacity=floats(PLANES, path_count, 1 if self.like.side_opacity is None else 3),
            background=floats(PLANES, 1, 3),
            segment_age=wholes(rows, high=iteration),
            age=wholes(path_count + 1, high=iteration),
            serial=wholes(path_count),
            created=integer(path_count, self.config.curves * (iteration + 1)),
            live=field_set,
            palette=maybe(field_set) if self.palette else exactly(None),
            gradients=maybe(field_set) if can_have_gradients else exactly(None),
        )

    def _check_gradients(self, live: Scene, state: State, iteration: int) -> None:
        has_both = (live.gradients is None) == (state["gradients"] is None)
        require(has_both, "population.gradients", "does not go with the paths")
        if live.gradients is not None:
            paints = GradientParameters(live.gradients, self.config, self.parameters.half_side)
            paints.check(state["gradients"], iteration, self._rounding("end_color"))

    def _check_live(self, live: Scene, state: State) -> None:
        """Refuse a ``live`` scene that is not what the parameters and the palette of ``state`` stand for."""
        made = self.parameters.to_scene((state["segments"], state["color"], state["opacity"]), live)
        own = self.parameters.to_color(state["background"][0, 0])
        is_fixed = has_fixed_background(self.config, self.like)
        background = self.like.background.to(own.device) if is_fixed else own
        fixed = FIXED_OPACITIES.get(self.config.opacity)
        color, opacity = made.color, made.opacity if fixed is None else torch.full_like(made.opacity, fixed)
        if state["palette"] is not None:
            drawn = drawn_colors(state["palette"]["free"], state["palette"]["entry"])
            color, background = drawn[:-1], background if live.transparent else drawn[-1]
        shown = {"segments": made.segments, "color": color, "opacity": opacity, "background": background}
        if made.side_opacity is not None and live.side_opacity is not None:
            is_same = torch.allclose(made.side_opacity.value, live.side_opacity.value, rtol=1e-4, atol=1e-4)
            require(is_same, "population.live.side_opacity", "does not go with the parameters of the paths")
        for name, value in shown.items():
            is_same = torch.allclose(value, getattr(live, name), rtol=1e-4, atol=self._rounding(name))
            require(is_same, f"population.live.{name}", "does not go with the parameters of the paths")

    def _rounding(self, name: str) -> float:
        """Return how far a value of the live scene may be from its parameter: it may be rounded to the file's."""
        if not self.config.minify:
            return 1e-4
        return ROUNDED_POINT if name == "segments" else ROUNDED_LEVEL


ROUNDED_POINT, ROUNDED_LEVEL = 0.75, 0.006
"""Half the largest step of a minified file in pixels and half a hundredth, with room for the handles of lines."""


def has_fixed_background(config: FitConfig, scene: Scene) -> bool:
    """Return whether the background is no parameter."""
    return config.backdrop == "white" or scene.transparent


def check_scene(name: str, value: Any, like: Scene, path_count: int, generation_max: int) -> None:
    """Refuse ``value`` unless it is the `to_dict` of a scene of the kind of ``like`` with ``path_count`` paths."""
    rows = row_count(name, value, "segments", SEGMENTS_MAX)
    loops = 0 if value.get("loop_first_segment") is None else row_count(name, value, "loop_first_segment", SEGMENTS_MAX)
    is_uniform = like.is_uniform and loops == 0
    count = like.structure.uniform_count
    gradients = fields(
        kind=wholes(path_count, high=max(number for number, kind in KINDS.items() if not kind.needs_stops)),
        geometry=floats(path_count, 4, low=-POINT_MAX, high=POINT_MAX),
        end_color=floats(path_count, 3, **_UNIT),
    )
    check_fields(
        name,
        value,
        segments=floats(rows, like.degree, 2, low=-POINT_MAX, high=POINT_MAX),
        uniform_count=exactly(count) if is_uniform else exactly(None),
        loop_first_segment=exactly(None) if is_uniform else wholes(loops, high=rows),
        path_first_loop=exactly(None) if is_uniform else wholes(path_count + 1, high=max(loops - 1, 0)),
        is_line=exactly(None) if is_uniform else maybe(array(torch.uint8, (rows,), 0, 1)),
        color=floats(path_count, 3, **_UNIT),
        opacity=floats(path_count, **_UNIT),
        background=floats(3, **_UNIT),
        generation=wholes(path_count, high=generation_max),
        transparent=exactly(like.transparent),
        gradients=maybe(gradients),
        **({} if like.side_opacity is None else {"side_opacity": floats(path_count, 2, **_UNIT)}),
    )
    if is_uniform:
        require(count is not None and rows == count * path_count, f"{name}.segments", "has another number of rows")
    else:
        _check_starts(f"{name}.loop_first_segment", value["loop_first_segment"], rows)
        _check_starts(f"{name}.path_first_loop", value["path_first_loop"], loops - 1)


def _check_starts(name: str, starts: Tensor, count: int) -> None:
    """Refuse ``starts`` unless they divide ``count`` rows into ranges that are not empty."""
    is_right = len(starts) > 0 and starts[0] == 0 and starts[-1] == count and bool((starts.diff() > 0).all())
    require(is_right, name, "does not divide the rows")
