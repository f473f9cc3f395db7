"""Fills from a palette: every path has one of its colours, which are given or fitted along with the paths.

A path keeps a free colour, which the gradient at the colour that is drawn moves (a straight-through estimator, Bengio
et al. 2013), and is drawn in the entry nearest to it; so it can change its entry. A fitted entry moves by the sum of
the gradients of all that is drawn in it.
"""

from __future__ import annotations

import numpy as np
import torch
from PIL import Image
from torch import Tensor

from warpvec.adan import Adan
from warpvec.checkpoint import State
from warpvec.config import FitConfig

START = 0.25
"""From this share of the iterations fills are from the palette: by then the paths of a default fit stand where they
stay, and most of the run is left to fit them under it."""

_KMEANS_ROUNDS = 10


class Palette:
    """The colours of a fit of ``target`` [h, w, 3 or 4] with ``config``.

    Attributes:
        entries: [C, 3], as an 8-bit file says them.
    """

    def __init__(self, target: Tensor, config: FitConfig) -> None:
        self._is_learned = config.palette is None
        first = _dominant(target, config.colors) if config.palette is None else _parsed(config.palette)
        self._free = first.to(target.device)
        self._rate = config.lr_color
        self._optimizer = Adan([self._free], lr=self._rate)

    @property
    def entries(self) -> Tensor:
        """The colours as an 8-bit file says them [C, 3]."""
        return (self._free * 255.0).round() / 255.0

    def nearest(self, color: Tensor) -> Tensor:
        """The entry [N] nearest to each ``color`` [N, 3]."""
        return (color[:, None] - self._free).square().sum(-1).argmin(1)

    def learn(self, entry: Tensor, adj_color: Tensor, factor: float) -> None:
        """Move the entries, if they are fitted, by the adjoints [N, 3] of what is drawn in ``entry`` [N]."""
        if self._is_learned:
            self._free.grad = torch.zeros_like(self._free).index_add_(0, entry, adj_color)
            self._optimizer.param_groups[0]["lr"] = self._rate * factor
            self._optimizer.step()
            self._free.clamp_(0.0, 1.0)

    def state(self) -> State:
        """What :meth:`restore` needs to go on as if nothing had happened."""
        return {"free": self._free, "optimizer": dict(self._optimizer.state[self._free])}

    def restore(self, state: State) -> None:
        """Go on from ``state``."""
        self._free = state["free"].to(self._free.device)
        self._optimizer = Adan([self._free], lr=self._rate)
        self._optimizer.state[self._free].update({n: v.to(self._free.device) for n, v in state["optimizer"].items()})


def _parsed(palette: str) -> Tensor:
    """Colours of "#rrggbb,#rrggbb"."""
    return torch.tensor([list(bytes.fromhex(name[1:])) for name in palette.split(",")], dtype=torch.float32) / 255.0


def _dominant(target: Tensor, count: int) -> Tensor:
    """``count`` colours, or as many as there are, that stand for the pixels of ``target`` that are to be seen."""
    pixels = target[target[..., 3] > 0.5] if target.shape[2] == 4 else target.flatten(0, 1)
    pixels = pixels[:, :3] if len(pixels) else target.new_zeros(1, 3)
    image = Image.fromarray((pixels[None].cpu().numpy() * 255.0).round().astype(np.uint8))
    # Pillow's palettes have at most 256 colours.
    reduced = image.quantize(min(count, 256), Image.Quantize.MAXCOVERAGE, kmeans=_KMEANS_ROUNDS)
    levels = reduced.getpalette() or [0, 0, 0]
    used = sorted(set(np.asarray(reduced).ravel().tolist()))
    return torch.tensor(levels, dtype=torch.float32).reshape(-1, 3)[used] / 255.0
