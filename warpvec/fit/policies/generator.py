"""The state of torch's random generator, checked: torch takes positions from it without looking at them."""

from __future__ import annotations

import struct
from typing import Any

import torch
from torch import Tensor

from warpvec.fit.state_form import Form, array, require
from warpvec.generators import generator_of

_WORDS = 624
"""Number of words that a Mersenne Twister computes at once, to hand them out later."""

_HEAD = struct.Struct("=QiiQ")
"""How a state begins: the seed, the words left plus one, whether it is seeded, and the index of the next word."""

_TAIL = _HEAD.size + 8 * _WORDS
"""Where the words end. What follows is the state of normal numbers, which no fit draws."""


def generator_state(seed: int) -> Form:
    """Return the form of the state of a `torch.Generator` with this ``seed`` after some draws of uniform numbers.

    `torch.Generator.set_state` accepts an index beyond the words, and would then read foreign memory.
    """

    def check(name: str, value: Any) -> None:
        fresh = generator_of(seed).get_state()
        array(torch.uint8, tuple(fresh.shape), 0, 255)(name, value)
        problem = "is not the state of the random generator of this fit"
        start, head = _head(fresh), _head(value)
        require((head[0], head[2]) == (start[0], start[2]), name, problem)
        left, following = head[1], head[3]
        is_fresh = (left, following) == (start[1], start[3])
        require(is_fresh or (1 <= left <= _WORDS and left + following == _WORDS + 1), name, problem)
        require(torch.equal(value[_TAIL:], fresh[_TAIL:]), name, problem)

    return check


def _head(state: Tensor) -> tuple[Any, ...]:
    return _HEAD.unpack(bytes(state[: _HEAD.size].tolist()))
