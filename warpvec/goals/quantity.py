"""A quantity of a file that a goal bounds."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from warpvec.config.control import Control
from warpvec.config.kinds import Kind

if TYPE_CHECKING:  # the help shows the goals without loading Torch
    from warpvec.drawing.drawing import Drawing


@dataclass(frozen=True)
class Quantity:
    """A figure of a file, and the option that bounds it.

    Attributes:
        name: name of the option in Python: "max_..." for a largest value, "target_..." for a smallest value.
        kind: values that the bound may have.
        help: one sentence for the help.
        metavar: placeholder of the bound in the help.
        bound: "largest" or "smallest" value that the file may have.
        measure: returns the figure of a drawing's file; the flag asks for gzipped bytes where this matters.
        describe: returns the part of the summary about the goal, from the facts of `warpvec.goals.search.make_facts`.
        decibels: converts a figure to a scale that rises by some decibels with a doubling of the paths, as a PSNR does.
            Only quantities with a smallest value need it.
        is_of_text: whether the length of the text counts. Such a goal shortens the file, unless the options say
            otherwise.
        page: its control on the page of `warpvec app`; None for none.
    """

    name: str
    kind: Kind
    help: str
    metavar: str
    bound: Literal["largest", "smallest"]
    measure: Callable[[Drawing, bool], float]
    describe: Callable[[Mapping[str, object]], str]
    decibels: Callable[[float], float] = float
    is_of_text: bool = False
    page: Control | None = None

    @property
    def figure(self) -> str:
        """Name of the figure in the facts of a search: the option without "max_" or "target_"."""
        return self.name.partition("_")[2]


def reached(facts: Mapping[str, object]) -> str:
    """Return whether the file reaches its smallest value, for `Quantity.describe`."""
    return "reached" if facts["met"] else "not reached"
