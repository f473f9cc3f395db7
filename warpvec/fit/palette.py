"""Take all fills from a palette, whose colours are given or fitted along with the paths.

A path switches to another entry of the palette if that lowers the loss. The image is affine in the colour of a path, so
the change of the mean squared error is known from the colour's adjoint and the path's visible area. The gradient of a
fitted entry is the sum of the adjoints of everything drawn in it. The least needed entry is replaced by the colour that
lowers the loss most.
"""

from __future__ import annotations

from dataclasses import replace

import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.adan import Adan, check_adan_state
from warpvec.fit.state import State
from warpvec.fit.state_form import check_fields, exactly, field_set, floats, integer, require, wholes
from warpvec.geometry.scene import Scene
from warpvec.image.alpha import is_transparent

START = 0.25
"""Fills come from the palette from this share of the iterations on. By then the paths of a default fit have found their
places, and most of the run is left to fit them with it."""

SWITCH_GAP = 10
"""Iterations between switches of entries; each costs a rendering."""

SWITCH_SHARE = 0.1
"""Share of the paths that switch at a time: the paths that gain most. If all paths switched, overlapping paths would
each correct the same error."""

ENTRY_RATE = 0.1
"""Learning rate of an entry over that of a path's colour: an entry recolours many paths at once."""

REPLACE_GAIN = 2.0
"""An entry is replaced if the gain is more than this many times the loss of its paths. With less, the next replacement
might soon undo it."""

PURE_SHARE = 0.01
"""A target is drawn in black or white if at least this share of its visible pixels has exactly that colour in 8 bits.
Of 16 emoji and logos those that use black or white have 1.7 % of it or more (1.0 % at a third of the size); of 12 Kodak
photos, one has more: 1.1 % of clipped highlights, which `PURE_MAJORITY` tells apart."""

PURE_MAJORITY = 2 / 3
"""At least this share of the pixels within reach of black or white must have exactly that colour. Otherwise an
entry there may stand for a colour of its own, such as #050505, or for a range of dark or bright tones. Art has 0.72 or
more, except for one emoji at a third of its size (0.62); the photo with the clipped highlights has 0.58."""

PURE_REACHES = (32, 16, 8)
"""A fitted entry within this many 8-bit levels of black or white, in each channel, becomes that colour if the target is
drawn in it; the largest reach that satisfies `PURE_MAJORITY` counts. After 300 iterations such entries of the 16 pieces
are 0 to 6 levels off, because antialiased edges pull at them; after 100 iterations, those of a black and white drawing
are 15 to 30 off."""

_KMEANS_ROUNDS = 10
# Smallest share of the canvas that a colour counts as: one that is hardly visible now may be needed later.
_SHARE_MIN = 2.0**-16
# Candidate colours for a new entry: those that the paths with the largest errors want.
_CANDIDATES = 64


class Palette:
    """The colours of a fit, and the entry that each path has. The canvas, if there is one, counts as the last path.

    Args:
        config: gives the colours, or their number.
        pixel_count: number of pixels of the canvas.
    """

    def __init__(self, config: FitConfig, pixel_count: int) -> None:
        self._config, self._error_scale = config, 1.0 / (3 * pixel_count)
        self._given = None if config.palette is None else _parse_palette(config.palette)
        self._steps = 0

    def start(self, color: Tensor, visible_area: Tensor, transparent: bool) -> None:
        """Choose the entries for paths of ``color`` [N + 1, 3] and ``visible_area`` [N + 1] in square pixels.

        The last row is the canvas. It does not count in a ``transparent`` scene, whose file has no canvas.
        """
        self._transparent = transparent
        counted = slice(0, -1 if transparent else None)
        entries = self._given
        if entries is None:
            entries = _dominant_colors(color[counted], visible_area[counted], self._config.colors)
        self._free = entries.to(color)
        self._optimizer = Adan(self._free)
        self._entry = self._nearest(color)

    @property
    def color(self) -> Tensor:
        """Colour of each path and the canvas [N + 1, 3], as it is drawn and as an 8-bit file says it."""
        return drawn_colors(self._free, self._entry)

    def is_switching(self) -> bool:
        """Return whether :meth:`step` needs the visible areas."""
        return self._steps % SWITCH_GAP == 0

    def step(self, adj_color: Tensor, visible_area: Tensor | None, factor: float) -> None:
        """Fit the entries, or switch paths to other ones, by the colours' adjoints [N + 1, 3].

        Learning rates are multiplied by ``factor``. ``visible_area`` [N + 1] is given if :meth:`is_switching`.
        """
        if self._transparent:
            adj_color = torch.cat([adj_color[:-1], torch.zeros_like(adj_color[-1:])])
        if visible_area is not None:
            if self._given is None and len(self._free) > 1:
                self._replace_entry(adj_color, visible_area)
            self._switch(adj_color, visible_area)
        elif self._given is None:
            # On CUDA this adds in a fixed order, as index_add_ does not; on the CPU both give the same bits.
            grad = torch.zeros_like(self._free).index_put_((self._entry,), adj_color, accumulate=True)
            self._optimizer.step(grad, ENTRY_RATE * self._config.lr_color * factor)
            self._free.clamp_(0.0, 1.0)
        self._steps += 1

    def keep(self, rows: Tensor) -> None:
        """Keep the paths ``rows`` (a mask, or indices), and the canvas."""
        self._entry = torch.cat([self._entry[:-1][rows], self._entry[-1:]])

    def append(self, color: Tensor) -> None:
        """Add paths in the entries nearest to ``color`` [K, 3]."""
        self._entry = torch.cat([self._entry[:-1], self._nearest(color), self._entry[-1:]])

    def state(self) -> State:
        """Return everything that :meth:`restore` needs to continue to the same bits."""
        state = {"free": self._free, "entry": self._entry, "steps": self._steps, "transparent": self._transparent}
        return {**state, "optimizer": dict(self._optimizer.state)}

    def check(self, state: State, iteration: int, path_count: int, transparent: bool) -> None:
        """Refuse ``state`` unless :meth:`state` can have returned it after ``iteration``.

        Args:
            path_count: number of paths.
            transparent: whether the scene is transparent.

        Raises:
            InputError: it cannot.
        """
        name = "population.palette"
        count = self._config.colors if self._given is None else len(self._given)
        check_fields(
            name,
            state,
            free=floats(count, 3, low=0.0, high=1.0),
            entry=wholes(path_count + 1, high=count - 1),
            steps=integer(0, iteration),
            transparent=exactly(transparent),
            optimizer=field_set,
        )
        if self._given is not None:
            require(torch.equal(state["free"].cpu(), self._given), f"{name}.free", "is not the palette of the settings")
            check_fields(f"{name}.optimizer", state["optimizer"])
        elif state["optimizer"]:  # there is none before the first step
            check_adan_state(f"{name}.optimizer", state["optimizer"], (count, 3), iteration)

    def restore(self, state: State, device: str) -> None:
        """Continue from ``state``, which :meth:`check` has accepted."""
        self._free, self._entry = (state[name].to(device, copy=True) for name in ("free", "entry"))
        self._steps, self._transparent = state["steps"], state["transparent"]
        averages = {name: value.to(device, copy=True) for name, value in state["optimizer"].items()}
        self._optimizer = Adan(self._free, averages)

    def _nearest(self, color: Tensor) -> Tensor:
        return _square_distances(color, self._free).argmin(1)

    def _switch(self, adj_color: Tensor, visible_area: Tensor) -> None:
        """Switch the paths that gain most to a better entry.

        Let d be the change of a path's colour and w(p) its visible share of pixel p. The loss changes by adj . d +
        scale sum_p w(p)^2 |d|^2. Since w is at most 1, that is at most the same with w in place of w^2.
        """
        change = self._free - self._free[self._entry][:, None]
        bound = self._error_scale * visible_area[:, None] * change.square().sum(-1)
        loss_change = (adj_color[:, None] * change).sum(-1) + bound
        min_change, entry = loss_change.min(1)  # at most 0: a path may keep its entry
        chosen = min_change.topk(max(1, int(SWITCH_SHARE * len(min_change))), largest=False).indices
        self._entry[chosen] = entry[chosen]

    def _replace_entry(self, adj_color: Tensor, visible_area: Tensor) -> None:
        """Replace the least needed entry, which may be unused, by the colour that lowers the loss most.

        The visible shares of a pixel sum up to 1 at most. By Jensen's inequality the bounds of `_switch` therefore also
        hold for changes of many paths at once. The bound of a path is lowest at its ``wanted`` colour. Up to a
        constant, the loss is at most the sum of scale area |c - wanted|^2 over the paths, where c is a path's colour.
        The choice of entries is thus a weighted k-means.
        """
        weight = self._error_scale * visible_area
        if self._transparent:
            weight = torch.cat([weight[:-1], torch.zeros_like(weight[-1:])])
        step = (0.5 * adj_color / weight[:, None]).nan_to_num(0.0, 0.0, 0.0)
        wanted = self._free[self._entry] - step
        own = torch.nn.functional.one_hot(self._entry, len(self._free)).to(wanted)
        distance = _square_distances(wanted, self._free)
        error = (distance * own).sum(1)
        next_error, next_entry = distance.masked_fill(own > 0.0, torch.inf).min(1)
        loss, spare = ((weight * (next_error - error)) @ own).min(0)
        color, gain = _best_new_color(wanted, weight, error)
        if gain <= REPLACE_GAIN * loss:
            return
        leaves = self._entry == spare
        joins = _square_distances(wanted, color[None])[:, 0] < torch.where(leaves, next_error, error)
        self._entry = torch.where(joins, spare, torch.where(leaves, next_entry, self._entry))
        self._free[spare] = color
        for values in self._optimizer.state.values():
            values[spare] = 0


def drawn_colors(free: Tensor, entry: Tensor) -> Tensor:
    """Return the colours [N, 3] of the entries ``free`` [K, 3] at ``entry`` [N], as an 8-bit file says them."""
    return ((free * 255.0).round() / 255.0)[entry]


def with_pure_colors(scene: Scene, target: Tensor) -> Scene:
    """Return ``scene`` with colours near black and white made exactly #000 and #fff, if ``target`` is drawn in these.

    Use it on the result of a fit of a palette. ``target`` is [h, w, 3 or 4] with straight alpha.
    """
    color, background = scene.color, scene.background
    for value in (0.0, 1.0):
        reach = _pure_reach(target, value)
        color, background = _snapped(color, value, reach), _snapped(background, value, reach)
    return replace(scene, color=color, background=scene.background if scene.transparent else background)


def _pure_reach(target: Tensor, value: float) -> int:
    """Return how many levels around black (0) or white (1) count as that colour in ``target``; -1 if none do.

    Pixels of at least half opacity count.
    """
    levels = (target[..., :3] * 255.0).round().flatten(0, 1)
    if is_transparent(target):
        levels = levels[target[..., 3].flatten() >= 0.5]
    distance = (levels - 255.0 * value).abs().amax(1)
    exact = int((distance == 0.0).sum())
    if not exact or exact < PURE_SHARE * len(levels):
        return -1
    return next((reach for reach in PURE_REACHES if exact >= PURE_MAJORITY * int((distance <= reach).sum())), -1)


def _snapped(color: Tensor, value: float, reach: int) -> Tensor:
    """Return ``color`` [..., 3] with the rows within ``reach`` levels of the grey ``value`` set to it."""
    levels = (color * 255.0).round()
    is_near = ((levels - 255.0 * value).abs() <= reach).all(-1, keepdim=True)
    return torch.where(is_near, value, color)


def _parse_palette(palette: str) -> Tensor:
    """Return the colours [K, 3] of "#rrggbb,#rrggbb"."""
    return torch.tensor([list(bytes.fromhex(name[1:])) for name in palette.split(",")], dtype=torch.float32) / 255.0


def _square_distances(color: Tensor, others: Tensor) -> Tensor:
    """Return the squared distances [N, K] of ``color`` [N, 3] to ``others`` [K, 3]."""
    return (color[:, None] - others).square().sum(-1)


def _best_new_color(wanted: Tensor, weight: Tensor, error: Tensor) -> tuple[Tensor, Tensor]:
    """Return a colour [3] for one more entry, and how much it reduces the sum of ``weight`` times ``error`` [N]."""
    rows = (weight * error).topk(min(_CANDIDATES, len(error))).indices
    candidates = wanted[rows].clamp(0.0, 1.0)
    less = weight[:, None] * (error[:, None] - _square_distances(wanted, candidates)).clamp_min(0.0)
    gain, best = less.sum(0).max(0)
    return candidates[best], gain


def _dominant_colors(color: Tensor, visible_area: Tensor, count: int) -> Tensor:
    """Return ``count`` colours that represent ``color`` [N, 3], weighted by ``visible_area`` [N].

    They are distinct in 8 bits. In this k-means, entries that meet become one, and the level with the largest error
    becomes a new entry. If there are fewer colours, the last one is repeated. No path has the repeated entries, so
    replacing them costs nothing.
    """
    levels, which = torch.unique((color.double().cpu() * 255.0).round(), dim=0, return_inverse=True)
    area = visible_area.double().cpu()
    weight = area.new_full((len(levels),), _SHARE_MIN).index_add_(0, which, area / area.sum().clamp_min(1e-9))
    entries = _with_largest_errors(levels[weight.argmax()][None], levels, weight, count)
    for _ in range(_KMEANS_ROUNDS):
        nearest = _square_distances(levels, entries).argmin(1)
        own = torch.nn.functional.one_hot(nearest, len(entries)) * weight[:, None]
        own = own[:, own.any(0)]
        means = torch.unique((own.T @ levels / own.sum(0)[:, None]).round(), dim=0)
        entries = _with_largest_errors(means, levels, weight, count)
    spare = entries[-1:].expand(count - len(entries), 3)
    return (torch.cat([entries, spare]) / 255.0).float()


def _with_largest_errors(entries: Tensor, levels: Tensor, weight: Tensor, count: int) -> Tensor:
    """Extend ``entries`` [K, 3] to ``count``, each time by the row of ``levels`` [N, 3] with the largest error."""
    error = weight * _square_distances(levels, entries).amin(1)
    while len(entries) < count and error.max() > 0.0:
        entries = torch.cat([entries, levels[error.argmax()][None]])
        error = torch.minimum(error, weight * _square_distances(levels, entries[-1:])[:, 0])
    return entries
