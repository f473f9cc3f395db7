"""Fills from a palette: every path has one of its colours, which are given or fitted along with the paths.

A path changes its entry where that lowers the loss. The image is affine in the colour of a path, so the change of the
mean squared error is known from its adjoint and from how much of the path is seen. A fitted entry moves by the sum of
the adjoints of all that is drawn in it; the one that is missed least goes to where another is missed most.
"""

from __future__ import annotations

import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.adan import Adan
from warpvec.fit.state import State

START = 0.25
"""From this share of the iterations fills are from the palette: by then the paths of a default fit have found their
places, and most of the run is left to fit them under it."""

SWITCH_GAP = 10
"""Iterations between changes of entries; one costs a drawing."""

SWITCH_SHARE = 0.1
"""Of the paths, those that gain most by another entry get it: paths that overlap must not all make up for one error."""

ENTRY_RATE = 0.1
"""Learning rate of entries over that of a path's colour: an entry moves many paths at once."""

MOVE_GAIN = 2.0
"""An entry goes elsewhere where that gains so many times what its paths lose; by less it may be worth going back."""

_KMEANS_ROUNDS = 10
# Of the canvas, what each colour counts as at least: one that is hardly seen now may be wanted later.
_SHARE_MIN = 2.0**-16
# Places that are looked at for an entry to go to: the paths that gain most by it for themselves.
_PLACES = 64


class Palette:
    """The colours of a fit, and which path has which; the canvas counts as a path, the last one, if there is one.

    Args:
        config: says which colours, or how many.
        pixel_count: of the canvas.
    """

    def __init__(self, config: FitConfig, pixel_count: int) -> None:
        self._config, self._error_scale = config, 1.0 / (3 * pixel_count)
        self._given = None if config.palette is None else _parsed(config.palette)
        self._steps = 0

    def start(self, color: Tensor, shown: Tensor, transparent: bool) -> None:
        """Choose the entries for paths that have ``color`` [N + 1, 3] and are seen on ``shown`` [N + 1] square pixels.

        The last is the canvas. In a ``transparent`` scene there is none: it is in no file, and has no say.
        """
        self._transparent = transparent
        seen = slice(0, -1 if transparent else None)
        first = _dominant(color[seen], shown[seen], self._config.colors) if self._given is None else self._given
        self._set_entries(first.to(color))
        self._entry = self._nearest(color)

    @property
    def color(self) -> Tensor:
        """What paths and canvas are drawn in [N + 1, 3], as an 8-bit file says it."""
        return ((self._free * 255.0).round() / 255.0)[self._entry]

    def is_switching(self) -> bool:
        """Whether :meth:`step` wants to know how much of each path is seen."""
        return self._steps % SWITCH_GAP == 0

    def step(self, adj_color: Tensor, shown: Tensor | None, factor: float) -> None:
        """Fit the entries, and which path has which, by the adjoints [N + 1, 3]; learning rates times ``factor``.

        ``shown`` [N + 1] is what is seen of each path in square pixels, if :meth:`is_switching`.
        """
        if self._transparent:
            adj_color = torch.cat([adj_color[:-1], torch.zeros_like(adj_color[-1:])])
        if shown is not None:
            if self._given is None and len(self._free) > 1:
                self._move_entry(adj_color, shown)
            self._switch(adj_color, shown)
        elif self._given is None:
            self._free.grad = torch.zeros_like(self._free).index_add_(0, self._entry, adj_color)
            self._optimizer.param_groups[0]["lr"] = ENTRY_RATE * self._config.lr_color * factor
            self._optimizer.step()
            self._free.clamp_(0.0, 1.0)
        self._steps += 1

    def keep(self, rows: Tensor) -> None:
        """Keep the paths ``rows`` (a mask, or indices), and the canvas."""
        self._entry = torch.cat([self._entry[:-1][rows], self._entry[-1:]])

    def append(self, color: Tensor) -> None:
        """Add paths in the entries nearest to ``color`` [K, 3]."""
        self._entry = torch.cat([self._entry[:-1], self._nearest(color), self._entry[-1:]])

    def state(self) -> State:
        """What :meth:`restore` needs to go on as if nothing had happened."""
        state = {"free": self._free, "entry": self._entry, "steps": self._steps, "transparent": self._transparent}
        return {**state, "optimizer": dict(self._optimizer.state[self._free])}

    def restore(self, state: State, device: str) -> None:
        """Go on from ``state``."""
        self._set_entries(state["free"].to(device))
        self._entry, self._steps = state["entry"].to(device), state["steps"]
        self._transparent = state["transparent"]
        self._optimizer.state[self._free].update({name: v.to(device) for name, v in state["optimizer"].items()})

    def _set_entries(self, free: Tensor) -> None:
        self._free = free
        self._optimizer = Adan([free], lr=self._config.lr_color)

    def _nearest(self, color: Tensor) -> Tensor:
        return _square_distances(color, self._free).argmin(1)

    def _switch(self, adj_color: Tensor, shown: Tensor) -> None:
        """Give those paths another entry that gain most by it.

        With d the change of a path's colour and w(p) what is seen of it in pixel p, the loss changes by adj . d +
        scale sum_p w(p)^2 |d|^2, which is at most that with w in place of its square: w is at most 1.
        """
        change = self._free - self._free[self._entry][:, None]
        bound = self._error_scale * shown[:, None] * change.square().sum(-1)
        change_of_loss = (adj_color[:, None] * change).sum(-1) + bound
        least, entry = change_of_loss.min(1)  # at most 0, which is to stay
        chosen = least.topk(max(1, int(SWITCH_SHARE * len(least))), largest=False).indices
        self._entry[chosen] = entry[chosen]

    def _move_entry(self, adj_color: Tensor, shown: Tensor) -> None:
        """Give the entry that is missed least, perhaps since nobody has it, to the paths that gain most by one.

        In a pixel all that is seen sums up to 1 at most, so the bounds of `_switch` hold for changes of many paths at
        once (Jensen): the loss is at most a constant and the sum of scale shown |c - wanted|^2 over the paths, where
        ``wanted`` is the colour c at which a path's bound is least. That is the error of k-means.
        """
        weight = self._error_scale * shown
        if self._transparent:
            weight = torch.cat([weight[:-1], torch.zeros_like(weight[-1:])])
        step = (0.5 * adj_color / weight[:, None]).nan_to_num(0.0, 0.0, 0.0)
        wanted = self._free[self._entry] - step
        own = torch.nn.functional.one_hot(self._entry, len(self._free)).to(wanted)
        distance = _square_distances(wanted, self._free)
        error = (distance * own).sum(1)
        next_error, next_entry = distance.masked_fill(own > 0.0, torch.inf).min(1)
        loss, least = ((weight * (next_error - error)) @ own).min(0)
        place, gain = _best_place(wanted, weight, error)
        if gain <= MOVE_GAIN * loss:
            return
        is_left = self._entry == least
        comes = _square_distances(wanted, place[None])[:, 0] < torch.where(is_left, next_error, error)
        self._entry = torch.where(comes, least, torch.where(is_left, next_entry, self._entry))
        self._free[least] = place
        for values in self._optimizer.state[self._free].values():
            values[least] = 0


def _parsed(palette: str) -> Tensor:
    """Colours of "#rrggbb,#rrggbb"."""
    return torch.tensor([list(bytes.fromhex(name[1:])) for name in palette.split(",")], dtype=torch.float32) / 255.0


def _distinct(levels: Tensor) -> tuple[Tensor, Tensor]:
    """The distinct rows of ``levels``, ascending, and which of them each row is."""
    rows, which = torch.unique(levels, dim=0, return_inverse=True)
    return rows, which


def _square_distances(color: Tensor, others: Tensor) -> Tensor:
    """[N, K], of ``color`` [N, 3] to each of ``others`` [K, 3]."""
    return (color[:, None] - others).square().sum(-1)


def _best_place(wanted: Tensor, weight: Tensor, error: Tensor) -> tuple[Tensor, Tensor]:
    """A colour [3] for one more entry, and how much less the sum of ``weight`` times ``error`` [N] is with it."""
    rows = (weight * error).topk(min(_PLACES, len(error))).indices
    places = wanted[rows].clamp(0.0, 1.0)
    less = weight[:, None] * (error[:, None] - _square_distances(wanted, places)).clamp_min(0.0)
    gain, best = less.sum(0).max(0)
    return places[best], gain


def _dominant(color: Tensor, shown: Tensor, count: int) -> Tensor:
    """``count`` colours that stand for ``color`` [N, 3], each as much as it is seen.

    They are distinct in 8 bits: k-means, in which entries that come together go to where the error is largest. Where
    there are fewer colours the last is repeated: nobody has these entries, and the first move takes them elsewhere.
    """
    levels, which = _distinct((color.double().cpu() * 255.0).round())
    seen = shown.double().cpu()
    weight = seen.new_full((len(levels),), _SHARE_MIN).index_add_(0, which, seen / seen.sum().clamp_min(1e-9))
    entries = _filled(levels[weight.argmax()][None], levels, weight, count)
    for _ in range(_KMEANS_ROUNDS):
        nearest = _square_distances(levels, entries).argmin(1)
        own = torch.nn.functional.one_hot(nearest, len(entries)) * weight[:, None]
        own = own[:, own.any(0)]
        means = _distinct((own.T @ levels / own.sum(0)[:, None]).round())[0]
        entries = _filled(means, levels, weight, count)
    spare = entries[-1:].expand(count - len(entries), 3)
    return (torch.cat([entries, spare]) / 255.0).float()


def _filled(entries: Tensor, levels: Tensor, weight: Tensor, count: int) -> Tensor:
    """``entries`` [K, 3] and more of ``levels`` [N, 3], each where the error is largest, up to ``count`` of them."""
    error = weight * _square_distances(levels, entries).amin(1)
    while len(entries) < count and error.max() > 0.0:
        entries = torch.cat([entries, levels[error.argmax()][None]])
        error = torch.minimum(error, weight * _square_distances(levels, entries[-1:])[:, 0])
    return entries
