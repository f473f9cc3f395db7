"""The paths that a fit optimizes: their parameters, their optimizer state, and adding and removing paths."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable
from dataclasses import replace

import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.arena import SEGMENT_ROOM, Arena, Held, is_plain
from warpvec.fit.gradient_paints import GradientParameters
from warpvec.fit.node_state import carried_averages
from warpvec.fit.palette import Palette
from warpvec.fit.parametrization import FIXED_OPACITIES, PLANES, Parametrization, fresh_planes
from warpvec.fit.population_state import StateCheck, has_fixed_background
from warpvec.fit.population_step import PopulationStep
from warpvec.fit.state import State
from warpvec.fit.written_grid import WrittenGrid
from warpvec.geometry import nodes
from warpvec.geometry.bezier import path_boxes
from warpvec.geometry.gradients import Gradients
from warpvec.geometry.scene import Scene, straightened


class Population:
    """N paths as free parameters, stepped by Adan. ``warpvec/fit/adan.py`` explains the step and the age of a row.

    Points are in units of half the canvas's longer side, as learning rates are; with ``config.axis_rates`` of half of
    each side. Opacities are logits. Colours are
    themselves or logits, depending on ``config.color_parameter``. The background is optimized too, unless
    ``config.backdrop`` fixes it or the scene is transparent; a palette applies to a fixed background as well. The live
    scene is rounded to the ``grid``, if there is one.

    Adding or removing paths makes new memory, or overwrites that of an `Arena` if the population ``has_room``, which a
    recorded graph needs.

    Attributes:
        before_use: hook that runs before paths are read or edited outside of `step`. A fit on a GPU then takes the
            steps again for which there was no room.
        serial: position of each path [N] in the order of creation, which the z-order by area does not keep.
    """

    _live: Scene | None
    _arena: Arena | None
    _copy: Scene | None
    _prefix_counts: list[int] | None

    def __init__(
        self,
        scene: Scene,
        config: FitConfig,
        half_side: float,
        grid: WrittenGrid | None = None,
        half_sides: tuple[float, float] | None = None,
        *,
        has_room: bool = False,
    ) -> None:
        self.before_use: Callable[[], None] = do_nothing
        self._grid = grid
        self._config = config
        self._parameters = Parametrization(
            half_side, config.color_parameter == "logit", half_sides if config.axis_rates else None
        )
        self._fixed_background = has_fixed_background(config, scene)
        self._opacity = FIXED_OPACITIES.get(config.opacity)
        self._palette: Palette | None = None
        # Parameters and state: segments [5, R, 2 M], colour [5, N, 3], opacity [5, N, 1 or 3] and background [5, 1, 3].
        self._rows = self._parameters.fresh_rows(scene)
        self._background = fresh_planes(self._parameters.raw_color(scene.background)[None])
        device = scene.segments.device
        # Steps taken by the segments [R], and by the paths [N + 1]; the last entry is the background's.
        self._segment_age = torch.zeros(scene.structure.segment_count, dtype=torch.int64, device=device)
        self._age = torch.zeros(len(scene) + 1, dtype=torch.int64, device=device)
        self._take_step = PopulationStep(config, self._parameters, device)
        self._has_room, self._arena = has_room, None
        self.serial = torch.arange(len(scene), device=device)
        self._created = len(scene)
        self._gradients = None if scene.gradients is None else GradientParameters(scene.gradients, config, half_side)
        own = self._parameters.to_color(self._background[0, 0])
        background = scene.background if self._fixed_background else own
        self._set_live(replace(self._parameters.to_scene(self._rows, scene), background=background))

    def __len__(self) -> int:
        return len(self.serial)

    @property
    def live(self) -> Scene:
        """The present paths, in memory that each step overwrites."""
        if self._live is None:
            assert self._arena is not None
            held = self._arena.found(self._kind, self._generation)
            self._live, self._rows, self._segment_age, _ = held
            self._segments_most = self._live.structure.segment_count
        return self._live

    @property
    def prefix_counts(self) -> list[int]:
        """Number of paths up to each generation, lowest first; read from the device once per change of population."""
        if self._prefix_counts is None:
            generations = sorted(self.live.generation.tolist())
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

        That of opacities is [N], or [N, 3] if paths have others at their sides.
        If ``fits`` [1], on the device, is -1 and not 1, the step changes nothing.
        """
        if fits is None:
            self._take_step.factor.fill_(factor)
            self._age += 1
            self._segment_ages.add_(1)
        else:
            torch.mul(fits, factor, out=self._take_step.factor)
            self._age += fits > 0.0
            self._segment_ages.add_(fits > 0.0)
        adjoints = (adj_segments.contiguous().flatten(1), adj_color, adj_opacity, adj_background[None])
        self._take_step(adjoints, not self._fixed_background)
        self._constrain()
        self._copy = None

    # A chain of steps without a look of the host

    @property
    def padded(self) -> Scene | None:
        """The present paths in the whole memory of their arena; None if they are in none."""
        return None if self._arena is None else self._arena.padded

    @property
    def shown(self) -> Scene:
        """What draws the present paths: themselves, or the whole memory of their arena."""
        return self.scene if self._arena is None else self._arena.padded

    @property
    def counts(self) -> Tensor | None:
        """Number of the paths [1] (int32) that `padded` has room for."""
        return None if self._arena is None else self._arena.counts

    def begin_chain(self, factors: list[float]) -> None:
        """Let the next calls of `chained_step` multiply the learning rates by ``factors``, at most ``CHAIN_MAX``."""
        table = torch.tensor(factors, dtype=torch.float64)
        self._take_step.factors[: len(factors)].copy_(table, non_blocking=True)  # else the host would wait
        self._take_step.position.zero_()
        self._copy = None

    def chained_step(
        self,
        adj_segments: Tensor,
        adj_color: Tensor,
        adj_opacity: Tensor,
        adj_background: Tensor,
        step_fits: Tensor,
        fits: Tensor,
    ) -> None:
        """Take an optimizer step from the adjoints of ``padded``'s values; a graph can record it.

        If ``step_fits`` or ``fits`` [1], on the device, is -1 and not 1, the step changes nothing, and ``fits`` is -1.
        """
        self._take_step.begin(step_fits, fits)
        adjoints = (adj_segments.flatten(1), adj_color, adj_opacity, adj_background[None])
        self._take_step(adjoints, not self._fixed_background)

    @property
    def _path_age(self) -> Tensor:
        return self._age[: len(self)]

    @property
    def _segment_ages(self) -> Tensor:
        """Ages of all segments that there is memory for."""
        return self._segment_age if self._arena is None else self._arena.segment_age

    def step_gradients(
        self, adj_end_color: Tensor, adj_geometry: Tensor, factor: float, fits: Tensor | None = None
    ) -> None:
        """Take an optimizer step of the gradients, as `step` does of the other parameters."""
        assert self._gradients is not None
        self._gradients.step(adj_end_color, adj_geometry, factor, fits)
        if self._grid is not None:
            self._grid.round_paints(self.live)
        self._copy = None

    def paint(self, rows: Tensor, scene: Scene) -> None:
        """Take colours and gradients of the paths ``rows`` (indices) from ``scene``, which has the same paths."""
        assert scene.gradients is not None
        raw = self._parameters.raw_color(scene.color[rows])
        for plane, values in enumerate([raw, *[torch.zeros_like(raw)] * (PLANES - 1)]):
            self._rows[1][plane, rows] = values
        if self._gradients is None:
            self._gradients = GradientParameters(scene.gradients, self._config, self._parameters.half_side)
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
        free = self._parameters.to_color(torch.cat([self._rows[1][0], self._background[0]]))
        palette.start(free, visible_area, self.live.transparent)
        self._palette = palette
        self._constrain()
        self._copy = None

    def state(self) -> State:
        """Return everything that :meth:`restore` needs to continue to the same bits."""
        live = self.live  # first, as it may bring the others
        return {
            "segments": self._rows[0],
            "color": self._rows[1],
            "opacity": self._rows[2],
            "background": self._background,
            "segment_age": self._segment_age,
            "age": torch.cat([self._path_age, self._age[-1:]]),
            "serial": self.serial,
            "created": self._created,
            "live": live.to_dict(),
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
        form = StateCheck(self.live, self._config, self._parameters, palette)
        form.check(state, iteration, path_count, generation_max)

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
            self._gradients = GradientParameters(live.gradients, self._config, self._parameters.half_side)
            self._gradients.restore(state["gradients"], str(device))
        self._set_live(live, is_constrained=True)

    def keep(self, rows: Tensor) -> None:
        """Keep the paths ``rows``: a mask, or indices in the new order."""
        self.before_use()
        live = self.live
        rows = rows.nonzero().flatten() if rows.dtype == torch.bool else rows  # once for all that follows
        structure, segments = live.structure.select(rows)
        own_rows = (segments, rows, rows)
        self._rows = tuple(values[:, each].contiguous() for values, each in zip(self._rows, own_rows, strict=True))
        self._segment_age = self._segment_age[segments]
        self._age = torch.cat([self._path_age[rows], self._age[-1:]])
        self.serial = self.serial[rows]
        if self._palette is not None:
            self._palette.keep(rows)
        if self._gradients is not None:
            self._gradients.keep(rows)
        self._set_live(live.select(rows, (structure, segments)))

    def remove(self, rows: Tensor) -> None:
        """Remove the paths ``rows`` (indices)."""
        self.keep(torch.ones_like(self.serial, dtype=torch.bool).index_fill(0, rows, False))

    def remove_cheapest(self, removal_cost: Tensor, count: int) -> None:
        """Remove the ``count`` paths of the lowest ``removal_cost`` [N]; in an arena without a look of the host."""
        if self._arena is None:
            self.remove(removal_cost.topk(count, largest=False).indices)
            return
        self.before_use()
        sources = self._arena.drop(count, removal_cost)
        self._follow(sources.path[: len(self) - count], self._generation, self.serial, -count)

    def _follow(self, source: Tensor, generation: Tensor, serial: Tensor, segments_more: int) -> None:
        """Note that paths have moved in the arena.

        Args:
            source: where each path [N] was in ``generation`` and ``serial``.
            segments_more: how many more segments there are at most.
        """
        self._generation, self.serial = generation[source], serial[source]
        self._segments_most += segments_more
        self._live = self._copy = self._prefix_counts = None

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
        rows, count = scene.structure.segment_count, len(scene)
        planes = self._parameters.fresh_rows(scene)
        added = self._parameters.to_scene(planes, scene)
        age = self._age[-1:] if self._config.common_age else self._age.new_zeros(1)
        new = Held(added, planes, age.expand(rows), age.expand(count))
        serial = torch.cat([self.serial, torch.arange(count, device=self.serial.device) + self._created])
        self._created += count
        if self._palette is not None:
            self._palette.append(scene.color)
        if self._gradients is not None:
            self._gradients.append(added.gradients or Gradients.none(added.color))
        if self._arena is not None and self._arena.can_add(added, len(self), self._segments_most):
            self._add_in_arena(self._arena, new, serial)
        else:
            self._join(new, serial)

    def _add_in_arena(self, arena: Arena, new: Held, serial: Tensor) -> None:
        """Add ``new`` paths without a look of the host; ``serial`` is that of all."""
        before, count = len(self), len(serial)
        source = arena.add(new).path[:count]
        source = torch.where(source < before, source, source - arena.path_room + before)
        generation = torch.cat([self._generation, new.scene.generation])
        self._follow(source, generation, serial, new.scene.structure.segment_count)

    def _join(self, new: Held, serial: Tensor) -> None:
        """Add ``new`` paths in memory of their own; ``serial`` is that of all."""
        live, paths = self.live, self._path_age
        self._rows = tuple(torch.cat(pair, 1) for pair in zip(self._rows, new.rows, strict=True))
        self._segment_age = torch.cat([self._segment_age, new.segment_age])
        self._age = torch.cat([paths, new.age, self._age[-1:]])
        self.serial = serial
        self._set_live(live.joined(new.scene))

    def split(self, rows: Tensor, t: Tensor | float = 0.5) -> None:
        """Divide the segments ``rows`` [K] at ``t``, as `warpvec.geometry.nodes.split` does."""
        self._edit_nodes(nodes.split(self.scene, rows, t))

    def merge(self, rows: Tensor, handles: Tensor, share: Tensor) -> None:
        """Drop the anchors at the start of ``rows`` [K], as `warpvec.geometry.nodes.merge` does."""
        self._edit_nodes(nodes.merge(self.scene, rows, handles, share))

    def _edit_nodes(self, edit: nodes.Edit) -> None:
        """Take the segments of ``edit``. The optimizer state of a new segment follows from its sources."""
        state, age = carried_averages(self._rows[0][1:], self._segment_age, edit)
        fresh = self._parameters.raw_segments(edit.scene)
        raw = torch.where(edit.is_fresh[:, None], fresh, self._rows[0][0, edit.source[:, 0]])
        self._rows = (torch.cat([raw[None], state]), *self._rows[1:])
        self._segment_age = age
        self._set_live(replace(self.live, segments=edit.scene.segments, structure=edit.scene.structure))

    def _set_live(self, scene: Scene, *, is_constrained: bool = False) -> None:
        """Make ``scene`` the live scene, and prepare the arguments of the step. ``scene`` must share no memory.

        A restored scene is already constrained. Never constrain twice: constraints change rounded scenes.
        """
        scene = replace(scene, gradients=None if self._gradients is None else self._gradients.live)
        held = Held(scene, self._rows, self._segment_age, self._age)
        arena = self._arena = self._arena_for(scene)
        if arena is not None:
            held = arena.take(held)
            scene, self._rows, self._segment_age, self._age = held
        self._live, self._copy, self._prefix_counts = scene, None, None
        self._kind, self._generation, self._segments_most = scene, scene.generation, scene.structure.segment_count
        rows = self._rows if arena is None else arena.rows
        ages = (self._segment_age if arena is None else arena.segment_age, self._age)
        counts = scene.color.new_full((1,), len(scene), dtype=torch.int32) if arena is None else arena.counts
        self._take_step.prepare(scene if arena is None else arena.padded, (*rows, self._background), ages, counts)
        if not is_constrained:
            self._constrain()

    def _arena_for(self, scene: Scene) -> Arena | None:
        """Return the arena that ``scene`` fits into, a larger one if need be; None if it needs none."""
        if not self._has_room or not is_plain(scene):
            return None
        if self._arena is not None and self._arena.has_room(scene):
            return self._arena
        paths = max(self._config.curves, len(scene))
        rows = max(self._config.segments * paths, scene.structure.segment_count)
        held = Held(scene, self._rows, self._segment_age, self._age)
        if self._config.renderer != "exact":  # which draws nothing but equal paths
            return Arena.of_equal_paths(held, paths)
        return Arena(held, paths, int(SEGMENT_ROOM * rows) + 1)

    def _constrain(self) -> None:
        """Straighten lines, and apply opaque paths and the palette, in the live scene in place."""
        if self.live.structure.is_line is not None:
            self.live.segments.copy_(straightened(self.live.segments, self.live.structure))
            # Anchors stay as they are: those of the live scene may be rounded.
            self._rows[0][0][:, 2:].copy_(self._parameters.raw_segments(self.live)[:, 2:])
        if self._opacity is not None:
            self.live.opacity.fill_(self._opacity)
        if self._palette is not None:
            color = self._palette.color
            self.live.color.copy_(color[:-1])
            if not self.live.transparent:
                self.live.background.copy_(color[-1])
        if self._grid is not None:
            self._grid.round_in_place(self.live)


def do_nothing() -> None:
    """Do nothing: the default hook before paths are used."""
