"""Workers on a Ray cluster: an actor each, warm from job to job, replaced when its process or its machine dies.

Actors and not tasks: a worker that has imported torch and loaded the kernels is kept. A job is given to an actor only
once that runs, so that none waits for a machine that is gone while others are idle.
"""

from __future__ import annotations

import os
import re
import socket
import sys
from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass
from typing import Any, Generic

from warpvec.batch.engines.base import Attempt, Failure, J, Outcome, Queue, R, Watch, Work, WorkerShare, attempt
from warpvec.errors import InputError

# Actors that die before they run, one after another, until it is taken that none will.
_FAILED_STARTS_MAX = 5


class RayEngine:
    """Actors on the cluster at ``address``: by default one for each of its GPUs or, on CPUs, as many as fit.

    Args:
        device: "cpu", or "cuda" or "auto" for a GPU for each worker; "auto" if there is one.
        threads: CPUs of each worker.
        jobs: workers; None for the default.
        retries: how many times a job whose worker died, or failed, is tried again.
        address: as `ray.init` takes it; None for the cluster that Ray finds.

    Raises:
        InputError: Ray is not installed.
    """

    def __init__(self, device: str, threads: int, jobs: int | None, retries: int, address: str | None) -> None:
        if device not in ("auto", "cpu", "cuda"):
            raise InputError(f"device must be auto, cpu or cuda with Ray, which chooses the GPU, got {device!r}")
        self._device, self._threads, self._jobs = device, threads, jobs
        self._retries, self._address = retries, address
        _import_ray()

    def run(self, jobs: Sequence[J], work: Work[J, R], watch: Watch) -> Generator[Outcome[J, R], None, None]:
        """The outcome of every job as it ends; see `base.Engine`.

        Raises:
            InputError: there is no such cluster, or it has not what a worker needs.
            RuntimeError: workers die before they begin.
        """
        queue = Queue(jobs, self._retries, watch)
        # Ray prints what its daemons say to stdout, which belongs to the result.
        with redirect_stdout(sys.stderr), self._connected() as ray:
            share, count = self._plan(ray)
            workers = _Workers(ray, work, share, watch)
            try:
                workers.hire(min(count, len(jobs)))
                while queue.unfinished:
                    workers.begin(queue)
                    if (news := workers.hear()) is not None and (outcome := queue.settle(*news)) is not None:
                        yield outcome
            finally:
                workers.dismiss()

    @contextmanager
    def _connected(self) -> Iterator[Any]:
        """Ray, connected; a connection that the caller has made is used and stays."""
        ray = _import_ray()
        if ray.is_initialized():
            yield ray
            return
        try:
            ray.init(address=self._address or "auto", log_to_driver=False, logging_level="error")
        except (ConnectionError, ValueError, RuntimeError) as error:
            given = "no --ray-address" if self._address is None else repr(self._address)
            rule = f"--ray-address must lead to a running Ray cluster, got {given} ({error})"
            raise InputError(
                f"{rule}; start one with ray start --head, or set RAY_AUTH_TOKEN if it wants that"
            ) from error
        try:
            yield ray
        finally:
            ray.shutdown()

    def _plan(self, ray: Any) -> tuple[WorkerShare, int]:
        """What each worker has, and how many of them the cluster has room for, or ``jobs``."""
        resources = ray.cluster_resources()
        on_gpu = self._device == "cuda" or (self._device == "auto" and resources.get("GPU", 0) >= 1)
        wanted = {"CPU": self._threads, **({"GPU": 1} if on_gpu else {})}
        room = min(int(resources.get(name, 0) // amount) for name, amount in wanted.items())
        if room < 1:
            has = ", ".join(f"{resources.get(name, 0):g} {name}" for name in wanted)
            needs = ", ".join(f"{amount} {name}" for name, amount in wanted.items())
            raise InputError(
                f"the Ray cluster must have {needs} for a worker, it has {has}; give less, or add machines"
            )
        return WorkerShare("cuda" if on_gpu else "cpu", self._threads), min(self._jobs or room, room)


def _import_ray() -> Any:
    try:
        import ray
    except ImportError:
        raise InputError("--engine ray needs Ray, which is not installed; pip install 'warpvec[cluster]'") from None
    return ray


@dataclass(eq=False)
class _Member(Generic[J]):
    """An actor, where it runs, and the attempt it is at; None while it starts or is idle."""

    actor: Any
    place: str = ""
    attempt: Attempt[J] | None = None


class _Workers(Generic[J, R]):
    """The actors, as seen from the driver."""

    def __init__(self, ray: Any, work: Work[J, R], share: WorkerShare, watch: Watch) -> None:
        self._ray, self._share, self._watch = ray, share, watch
        gpu_count = 1 if share.device == "cuda" else 0
        self._actor = ray.remote(num_cpus=share.threads, num_gpus=gpu_count, max_restarts=0)(_Actor)
        self._work = ray.put(work)
        # What each that is not idle is waited for with: the answer to its start, or to its job.
        self._pending: dict[Any, _Member[J]] = {}
        self._idle: list[_Member[J]] = []
        self._failed_starts = 0

    def hire(self, count: int) -> None:
        """Start so many actors."""
        for _ in range(count):
            member: _Member[J] = _Member(self._actor.remote(self._work, self._share))
            self._pending[member.actor.place.remote()] = member

    def begin(self, queue: Queue[J]) -> None:
        """Give the next jobs of ``queue`` to those that are idle."""
        while self._idle and (following := queue.take()) is not None:
            member = self._idle.pop()
            member.attempt = following
            self._watch(following.job, f"attempt {following.number} in {member.place}")
            self._pending[member.actor.do.remote(following.job)] = member

    def hear(self) -> tuple[Attempt[J], R | Failure] | None:
        """Wait until something happens: an attempt and its answer; None if a worker has only started, or failed to."""
        (reference,), _ = self._ray.wait(list(self._pending), num_returns=1)
        member = self._pending.pop(reference)
        ended, member.attempt = member.attempt, None
        try:
            answer = self._ray.get(reference)
        except self._ray.exceptions.RayError as error:
            answer = Failure(f"the Ray worker died ({_reason(error, started=ended is not None)})", final=False)
        if isinstance(answer, Failure) and not answer.final:
            self._replace(member, answer, started=ended is not None)
        else:
            self._idle.append(member)
            self._failed_starts = 0
        if ended is None:
            member.place = str(answer)
            return None
        return ended, answer

    def dismiss(self) -> None:
        """End all actors, at once."""
        for member in (*self._pending.values(), *self._idle):
            self._ray.kill(member.actor)

    def _replace(self, member: _Member[J], failure: Failure, *, started: bool) -> None:
        # One whose work failed lives, but what it holds is not to be trusted after an error of memory or of a GPU.
        self._ray.kill(member.actor)
        self._failed_starts = 0 if started else self._failed_starts + 1
        if self._failed_starts > _FAILED_STARTS_MAX:
            raise RuntimeError(f"Ray's workers die before they begin: {failure.reason}")
        self.hire(1)


class _Actor(Generic[J, R]):
    """A worker, in a process of the cluster."""

    def __init__(self, work: Work[J, R], share: WorkerShare) -> None:
        self._work, self._share = work, share

    def place(self) -> str:
        """Where this is."""
        return f"process {os.getpid()} of {socket.gethostname()}"

    def do(self, job: J) -> R | Failure:
        """The result of the work."""
        return attempt(self._work, job, self._share, lambda text: None)


def _reason(error: Exception, *, started: bool) -> str:
    """The line of Ray's message that tells most: the first of a death, the last, an exception, of one at the start."""
    lines = re.sub(r"\x1b\[\d*m", "", str(error)).strip().splitlines()
    return lines[0 if started else -1]
