"""What an engine is given and gives: jobs and work in, an outcome for each job out, whatever dies on the way."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar

from warpvec.errors import InputError

J = TypeVar("J")
R = TypeVar("R")
J_contra = TypeVar("J_contra", contravariant=True)
R_co = TypeVar("R_co", covariant=True)

Say = Callable[[str], None]
"""Tells, in a few words, how far a job is."""

Watch = Callable[[Any, str], None]
"""Hears a job and what becomes of it: where it runs, how far it is, why it has to be tried again."""


@dataclass(frozen=True)
class WorkerShare:
    """The share of the machine that one worker has. Results do not depend on it.

    Attributes:
        device: "cpu", "cuda:K", or "cuda" for the one that the worker sees.
        threads: CPU threads of the kernels.
    """

    device: str
    threads: int


class Work(Protocol[J_contra, R_co]):
    """What is done for each job; it can be pickled. An InputError is the job's own fault and not tried again."""

    def __call__(self, job: J_contra, share: WorkerShare, say: Say) -> R_co:
        """The result of ``job``, which can be pickled too."""


@dataclass(frozen=True)
class Outcome(Generic[J, R]):
    """How a job ended: with a value, or with an error in one line; and how many times it was begun."""

    job: J
    value: R | None
    error: str | None
    attempts: int


class Engine(Protocol):
    """Runs work on many jobs at once.

    A worker that dies, whatever the reason, costs only the job it is at, which is tried again on a new one.
    """

    def run(self, jobs: Sequence[J], work: Work[J, R], watch: Watch) -> Generator[Outcome[J, R], None, None]:
        """The outcome of every job as it ends, in no order. Closing the generator ends the workers."""


@dataclass(frozen=True)
class Failure:
    """Why a job has no value; ``final`` where another attempt would end in the same way."""

    reason: str
    final: bool


@dataclass(frozen=True)
class Attempt(Generic[J]):
    """A job that is being worked on for the ``number``-th time, counted from 1."""

    job: J
    number: int


def attempt(work: Work[J, R], job: J, share: WorkerShare, say: Say) -> R | Failure:
    """The result of ``work``, and a failure in place of any exception."""
    try:
        return work(job, share, say)
    except InputError as error:
        return Failure(str(error), final=True)
    except Exception as error:
        return Failure(f"{type(error).__name__}: {error}", final=False)


class Queue(Generic[J]):
    """The jobs that wait, and those that are out; each is begun at most ``retries`` + 1 times."""

    def __init__(self, jobs: Sequence[J], retries: int, watch: Watch) -> None:
        self._waiting = deque(Attempt(job, 1) for job in jobs)
        self._retries, self._watch = retries, watch
        self.unfinished = len(jobs)
        """Jobs without an outcome."""

    def take(self) -> Attempt[J] | None:
        """What to begin next; None if nothing waits."""
        return self._waiting.popleft() if self._waiting else None

    def settle(self, attempt: Attempt[J], answer: R | Failure) -> Outcome[J, R] | None:
        """The outcome of an attempt; None if the job waits to be tried again, behind all others."""
        if not isinstance(answer, Failure):
            self.unfinished -= 1
            return Outcome(attempt.job, answer, None, attempt.number)
        if answer.final or attempt.number > self._retries:
            self.unfinished -= 1
            return Outcome(attempt.job, None, answer.reason, attempt.number)
        self._waiting.append(Attempt(attempt.job, attempt.number + 1))
        self._watch(attempt.job, f"tried again: {answer.reason}")
        return None
