"""Random generators of torch."""

from __future__ import annotations

import torch


def generator_of(seed: int) -> torch.Generator:
    """Return a generator on the CPU that draws what ``torch.Generator().manual_seed(seed)`` does.

    Torch 2.13 makes one from nothing only after it has loaded its compiler's functions, which no command needs.
    """
    return torch.default_generator.clone_state().manual_seed(seed)
