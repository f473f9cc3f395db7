"""The strokes of the paths of a scene."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import torch
from torch import Tensor

from warpvec.errors import InputError
from warpvec.geometry.gradients import check_shape
from warpvec.geometry.structure import Structure

BUTT, ROUND, SQUARE = 0, 1, 2
"""Caps in `Strokes.cap`. ``ROUND`` is a join too."""

MITER, BEVEL = 0, 2
"""Joins in `Strokes.join`, beside ``ROUND``."""

CAPS = {BUTT: "butt", ROUND: "round", SQUARE: "square"}
"""Cap -> its name in SVG."""

JOINS = {MITER: "miter", ROUND: "round", BEVEL: "bevel"}
"""Join -> its name in SVG."""

MITER_LIMIT = 4.0
"""Limit of miters where a file states none (SVG)."""

MITER_LIMIT_MAX = 1e6
"""Largest limit of miters: the corner of a sharper angle lies a million widths away."""


@dataclass(frozen=True)
class Strokes:
    """How N paths are stroked. A path of width 0 is filled.

    The rows of a stroked path are its centre line. A loop of it may be open (`Structure.is_open`).

    Attributes:
        width: in pixels [N], 0 for a filled path.
        cap: a key of ``CAPS`` [N] (int32): what stands at the ends of open lines.
        join: a key of ``JOINS`` [N] (int32): what stands where the line turns.
        miter_limit: largest length of a miter in widths [N]; a longer one is cut off. At least 1.

    Raises:
        InputError: the shapes do not agree.
    """

    width: Tensor
    cap: Tensor
    join: Tensor
    miter_limit: Tensor

    def __post_init__(self) -> None:
        count = len(self.width)
        for name in ("width", "cap", "join", "miter_limit"):
            check_shape(f"strokes.{name}", getattr(self, name), (count,), count)

    def check_kinds(self) -> None:
        """Refuse an unknown cap or join. It is not looked for on a GPU: that would wait for its work.

        Raises:
            InputError: there is one.
        """
        if self.width.device.type != "cpu":
            return
        for name, known in {"cap": CAPS, "join": JOINS}.items():
            values = getattr(self, name)
            unknown = values[~torch.isin(values, torch.tensor(list(known), dtype=values.dtype))]
            if len(unknown):
                listed = ", ".join(f"{number} ({word})" for number, word in known.items())
                raise InputError(f"strokes.{name}", f"must be {listed}", str(int(unknown[0])), "give one of these")

    @staticmethod
    def none(color: Tensor) -> Strokes:
        """Return the strokes of filled paths of ``color`` [N, 3]."""
        count = len(color)
        kind = torch.zeros(count, dtype=torch.int32, device=color.device)
        limit = color.new_full((count,), MITER_LIMIT)
        return Strokes(color.new_zeros(count), kind, kind.clone(), limit)

    def __len__(self) -> int:
        return len(self.width)

    @property
    def is_stroked(self) -> Tensor:
        """Which paths are stroked [N] (bool)."""
        return self.width != 0.0

    @property
    def reach(self) -> Tensor:
        """How far a stroke reaches from its centre line at most [N], in pixels."""
        corner = torch.where(self.join == MITER, self.miter_limit, 1.0)
        cap = torch.where(self.cap == SQUARE, math.sqrt(2.0), 1.0)
        return self.width / 2.0 * torch.maximum(corner, cap)

    def map(self, change: Callable[[Tensor], Tensor]) -> Strokes:
        """Return the strokes with each tensor replaced by what ``change`` makes of it."""
        return Strokes(*(change(getattr(self, name)) for name in ("width", "cap", "join", "miter_limit")))

    def joined(self, other: Strokes) -> Strokes:
        """Return these strokes and those of ``other``."""
        pairs = ((getattr(self, name), getattr(other, name)) for name in ("width", "cap", "join", "miter_limit"))
        return Strokes(*(torch.cat(pair) for pair in pairs))

    def scaled(self, x_factor: float, y_factor: float) -> Strokes:
        """Return the strokes scaled about the origin; a width, by the geometric mean of the two factors."""
        return replace(self, width=self.width * math.sqrt(abs(x_factor * y_factor)))

    def moved(self, x: float, y: float) -> Strokes:
        """Return the strokes, which a move leaves as they are."""
        del x, y
        return self


FILLED, INNER, FIRST, END = range(4)
"""Roles of a row: of a fill; of a stroke; the first of an open line; the end of an open line, which draws nothing."""


def roles_of(strokes: Strokes, structure: Structure) -> Tensor:
    """Return the role of each row [R] (int32)."""
    owner = structure.segment_path.long()
    role = torch.where(strokes.is_stroked[owner], INNER, FILLED).int()
    if structure.is_open is None:
        return role
    first = structure.loop_first_segment.long()
    for rows, number in ((first[:-1][structure.is_open], FIRST), (first[1:][structure.is_open] - 1, END)):
        role[rows] = torch.where(role[rows] == FILLED, FILLED, number).int()
    return role
