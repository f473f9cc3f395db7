"""The goal of a smallest PSNR of the file, as resvg draws it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from warpvec.config.kinds import Positive
from warpvec.goals.quantity import Quantity, reached

if TYPE_CHECKING:
    from warpvec.drawing.drawing import Drawing


def _measure(drawing: Drawing, gzip: bool) -> float:
    del gzip
    return drawing.psnr


def _describe(facts: Mapping[str, object]) -> str:
    return f"{facts['target_psnr']:g} dB {reached(facts)}"


QUANTITY = Quantity(
    "target_psnr", Positive(100.0, "must be above 0 and at most 100", "give 25 to 35 for a photo"),
    "Use the fewest paths that reach this PSNR (25 to 35).", "DB", "smallest", _measure, _describe,
)  # fmt: skip
