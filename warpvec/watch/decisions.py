"""Record what a run decided about its drawing, and why: each change that was weighed.

    warpvec run in.png out.svg --why why.jsonl

In Python, the records go to the logger `LOGGER` of `logging`, as ``record.decision``, if that has the level DEBUG.
"""

from __future__ import annotations

import json
import logging
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from typing import Any

from warpvec.arrays import Floats

LOGGER = logging.getLogger("warpvec.decisions")

Box = tuple[float, float, float, float]


@dataclass(frozen=True)
class Decision:
    """A change of a drawing that was weighed.

    Attributes:
        stage: what proposed it, such as "parts".
        place: left, top, right and bottom of what it changes, in pixels; None for the whole picture.
        before: what the drawing says there.
        after: what it would say instead.
        words: nats that the words of the change save.
        picture: nats by which it shows the picture worse. Where a stage allows a rise of the squared error, the largest
            one that it allows counts as the words that it saves.
        is_taken: whether the drawing is changed.
        reason: what decided where nats did not; empty if they did.
    """

    stage: str
    place: Box | None
    before: str
    after: str
    words: float | None
    picture: float | None
    is_taken: bool
    reason: str = ""

    def line(self) -> str:
        """Return the decision as a line of JSON, with numbers of two decimals."""
        fields: dict[str, Any] = asdict(self)
        fields |= {"taken": fields.pop("is_taken"), "reason": fields.pop("reason")}
        if self.place is not None:
            fields["place"] = [round(side, 2) for side in self.place]
        for name in ("words", "picture"):
            fields[name] = None if fields[name] is None else round(fields[name], 2)
        return json.dumps(fields)


def box_of(points: Floats) -> Box:
    """Return the box of ``points`` [..., 2]."""
    flat = points.reshape(-1, 2)
    left, top, right, bottom = (float(side) for side in (*flat.min(0), *flat.max(0)))
    return left, top, right, bottom


def are_wanted() -> bool:
    """Return whether anybody listens, so that records need to be made."""
    return LOGGER.isEnabledFor(logging.DEBUG)


def note(decision: Decision) -> None:
    """Tell those who listen of a ``decision``."""
    LOGGER.debug("%s", decision.line(), extra={"decision": decision})


@contextmanager
def noted() -> Iterator[list[Decision]]:
    """Yield a list that grows by each decision of the block."""
    found, handler, level = list[Decision](), _Listener(), LOGGER.level
    handler.found = found
    LOGGER.addHandler(handler)
    LOGGER.setLevel(logging.DEBUG)
    try:
        yield found
    finally:
        LOGGER.removeHandler(handler)
        LOGGER.setLevel(level)


class _Listener(logging.Handler):
    """Keeps the decisions that are noted."""

    found: list[Decision]

    def emit(self, record: logging.LogRecord) -> None:
        """Keep the decision of a ``record``."""
        self.found.append(record.decision)  # type: ignore[attr-defined]
