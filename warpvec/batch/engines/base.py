"""The interface of an engine: jobs and work in, one outcome per job out, even if workers die."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar

from warpvec.errors import InputError

J = TypeVar("J")
R = TypeVar("R")

Report = Callable[[str], None]
"""Called by the work with a few words on the progress of its job."""

Notify = Callable[[Any, str], None]
"""Function that the engine calls with a job and its news: place, progress, or reason of another attempt."""


@dataclass(frozen=True)
class WorkerShare:
    """The share of the machine that one worker may use. Results do not depend on it.

    Attributes:
        device: "cpu", "cuda:K", or "cuda" for the only GPU that the worker sees.
        threads: CPU threads of the kernels.
    """

    device: str
    threads: int


Work = Callable[[J, WorkerShare, Report], R]
"""The function that is called for each job. It can be pickled, and so can its result.

An InputError is the fault of the job, which is then not tried again.
"""


@dataclass(frozen=True)
class Outcome(Generic[J, R]):
    """The end of a job: a value, or an error in one line, and the number of attempts."""

    job: J
    value: R | None
    error: str | None
    attempts: int


class Engine(Protocol):
    """Runs work for many jobs at once.

    A worker that dies, for whatever reason, costs only its current job, which is tried again on a new worker.
    """

    def run(self, jobs: Sequence[J], work: Work[J, R], notify: Notify) -> Generator[Outcome[J, R], None, None]:
        """Yield the outcome of every job as it ends, in no order. Closing the generator stops the workers."""


@dataclass(frozen=True)
class Failure:
    """The reason why a job has no value. ``final`` is true if another attempt would end in the same way."""

    reason: str
    final: bool


@dataclass(frozen=True)
class JobAttempt(Generic[J]):
    """The ``number``-th attempt at a job, counted from 1."""

    job: J
    number: int


def try_work(work: Work[J, R], job: J, share: WorkerShare, report: Report) -> R | Failure:
    """Return the result of ``work``, or a failure in place of any exception."""
    try:
        return work(job, share, report)
    except InputError as error:
        return Failure(str(error), final=True)
    except Exception as error:
        return Failure(f"{type(error).__name__}: {error}", final=False)


class Queue(Generic[J]):
    """The waiting jobs and the number of unfinished ones. Each job gets at most ``retries`` + 1 attempts."""

    def __init__(self, jobs: Sequence[J], retries: int, notify: Notify) -> None:
        self._waiting = deque(JobAttempt(job, 1) for job in jobs)
        self._retries, self._notify = retries, notify
        self.unfinished = len(jobs)
        """Number of jobs without an outcome."""

    def pop(self) -> JobAttempt[J] | None:
        """Take the next attempt to start; None if no job waits."""
        return self._waiting.popleft() if self._waiting else None

    def finish(self, attempt: JobAttempt[J], answer: R | Failure) -> Outcome[J, R] | None:
        """Return the outcome of an attempt, or put the job behind all others to be tried again and return None."""
        if not isinstance(answer, Failure):
            self.unfinished -= 1
            return Outcome(attempt.job, answer, None, attempt.number)
        if answer.final or attempt.number > self._retries:
            self.unfinished -= 1
            return Outcome(attempt.job, None, answer.reason, attempt.number)
        self._waiting.append(JobAttempt(attempt.job, attempt.number + 1))
        self._notify(attempt.job, f"tried again: {answer.reason}")
        return None
