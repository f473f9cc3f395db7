"""One case of `bench/torture.py`: a hostile input or event, and what warpvec may do about it.

A module of a kind, `torture_<kind>.py`, has a function `case(chance: random.Random) -> Case`. All that is random in a
case comes from `chance`, which is seeded by the kind, the seed of the run and the number of the case: every case can
be run again by these three.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

OK, REFUSED = "ok", "refused"
"""The two good outcomes: warpvec did the work, or said in one line why it does not (`InputError`, exit code 2)."""

MAX_MEMORY = 2**31
"""Largest resident memory of a process in bytes; more is a fault. Torch reserves more than it uses, so that the address
space says nothing."""

FAULTS = ("exception", "crash", "hang", "memory", "wrong")
"""The bad outcomes. "wrong" is a rule that was broken without an error: a file left over, a message of two lines."""

_patience = [1.0]


def be_patient(factor: float) -> None:
    """Multiply the limits of time of all cases from now on, for a machine that is busy with other work."""
    _patience[0] = factor


def limit(seconds: float) -> float:
    """Return a limit of time that is ``seconds`` on an idle machine."""
    return _patience[0] * seconds


class Wrong(Exception):
    """A rule of the case was broken: raised by the case, with one line that says which."""


@dataclass(frozen=True)
class Case:
    """What to do, and the input it is done with.

    `run` gets an empty folder, which is deleted afterwards, and returns `OK` or `REFUSED`. An `InputError` counts as
    `REFUSED`, `Wrong` as "wrong", every other exception as "exception".
    """

    name: str
    """What is done, in a few words of one line: "png read_image"."""
    run: Callable[[Path], str]
    data: bytes = b""
    """The input, saved beside the report of a fault."""
    seconds: float = 20.0
    """The case hangs if it takes longer. Cases that start several processes may take longer than one reading."""
