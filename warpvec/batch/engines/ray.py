"""Workers on a Ray cluster: an actor for each worker, kept from job to job, replaced when its process or machine dies.

Actors, unlike tasks, keep torch and the kernels loaded from job to job. An actor gets a job only when it runs, so that
no job waits for a lost machine while others are idle.
"""

from __future__ import annotations

import io
import os
import re
import signal
import socket
import sys
import threading
from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass
from typing import Any, Generic

from warpvec.batch.engines.base import Failure, J, JobAttempt, Notify, Outcome, Queue, R, Work, WorkerShare, try_work
from warpvec.errors import InputError

# Number of actors in a row that may die before they run. After that the batch gives up.
_FAILED_STARTS_MAX = 5


class RayEngine:
    """Actors on the cluster at ``address``: by default one per GPU of the cluster or, on CPUs, as many as fit.

    Args:
        device: "cpu", or "cuda" for a GPU per worker; "auto" uses GPUs if there are any.
        threads: CPUs of each worker.
        jobs: number of workers; None for the default.
        retries: number of further attempts at a job that failed or whose worker died.
        address: as `ray.init` takes it; None for the cluster that Ray finds.

    Raises:
        InputError: Ray is not installed, or the device is a GPU by number.
    """

    def __init__(self, device: str, threads: int, jobs: int | None, retries: int, address: str | None) -> None:
        if device not in ("auto", "cpu", "cuda"):
            raise InputError("device", "must be auto, cpu or cuda with Ray", repr(device), "Ray chooses the GPU")
        self._device, self._threads, self._jobs = device, threads, jobs
        self._retries, self._address = retries, address
        _import_ray()

    def run(self, jobs: Sequence[J], work: Work[J, R], notify: Notify) -> Generator[Outcome[J, R], None, None]:
        """Yield the outcome of every job as it ends; see `base.Engine`.

        Raises:
            InputError: there is no such cluster, or its machines lack packages of the workers.
            RuntimeError: workers die before they start.
        """
        queue = Queue(jobs, self._retries, notify)
        # Ray prints messages of its daemons to stdout, which is kept for the result. A closed stderr is None.
        with redirect_stdout(sys.stderr or io.StringIO()), self._connected() as ray:
            share, count = self._plan(ray)
            workers = _Workers(ray, work, share, notify)
            try:
                workers.start(min(count, len(jobs)))
                while queue.unfinished:
                    workers.start_jobs(queue)
                    if (ended := workers.receive()) is not None and (outcome := queue.finish(*ended)) is not None:
                        yield outcome
            finally:
                workers.stop()

    @contextmanager
    def _connected(self) -> Iterator[Any]:
        """Connect to Ray. A connection that the caller has made is used, and stays."""
        ray = _import_ray()
        if ray.is_initialized():
            yield ray
            return
        try:
            with _kept_handlers():
                ray.init(address=self._address or "auto", log_to_driver=False, logging_level="error")
        except (ConnectionError, ValueError, RuntimeError) as error:
            given = "none" if self._address is None else repr(self._address)
            remedy = "start one with ray start --head, or set RAY_AUTH_TOKEN if the cluster asks for a token"
            raise InputError("address", "must lead to a running Ray cluster", f"{given} ({error})", remedy) from error
        try:
            yield ray
        finally:
            ray.shutdown()

    def _plan(self, ray: Any) -> tuple[WorkerShare, int]:
        """Return the share of each worker, and their number: ``jobs``, or as many as the cluster has room for."""
        resources = ray.cluster_resources()
        on_gpu = self._device == "cuda" or (self._device == "auto" and resources.get("GPU", 0) >= 1)
        wanted = {"CPU": self._threads, **({"GPU": 1} if on_gpu else {})}
        room = min(int(resources.get(name, 0) // amount) for name, amount in wanted.items())
        if room < 1:
            has = ", ".join(f"{resources.get(name, 0):g} {name}" for name in wanted)
            needs = ", ".join(f"{amount} {name}" for name, amount in wanted.items())
            remedy = "use fewer threads or another device, or add machines"
            raise InputError("the Ray cluster", f"must have {needs} for a worker", has, remedy)
        return WorkerShare("cuda" if on_gpu else "cpu", self._threads), min(self._jobs or room, room)


@contextmanager
def _kept_handlers() -> Iterator[None]:
    """Keep the handler of SIGTERM in this block.

    That of Ray would end the batch in disorder, with an exit code of its own.
    """
    handler = signal.getsignal(signal.SIGTERM)
    try:
        yield
    finally:
        if threading.current_thread() is threading.main_thread():
            signal.signal(signal.SIGTERM, handler)


def _import_ray() -> Any:
    try:
        import ray
    except ImportError:
        remedy = "pip install 'warpvec[cluster]', which contains it"
        raise InputError("engine", "must be local unless Ray is installed", "'ray'", remedy) from None
    return ray


@dataclass(eq=False)
class _Worker(Generic[J]):
    """An actor, its place, and its current attempt (None while it starts or is idle)."""

    actor: Any
    place: str = ""
    attempt: JobAttempt[J] | None = None


class _Workers(Generic[J, R]):
    """All actors, seen from the driver."""

    def __init__(self, ray: Any, work: Work[J, R], share: WorkerShare, notify: Notify) -> None:
        self._ray, self._share, self._notify = ray, share, notify
        gpu_count = 1 if share.device == "cuda" else 0
        self._actor = ray.remote(num_cpus=share.threads, num_gpus=gpu_count, max_restarts=0)(_Actor)
        self._work = ray.put(work)
        # Reference to the awaited answer, of a start or of a job -> the worker that will give it.
        self._pending: dict[Any, _Worker[J]] = {}
        self._idle: list[_Worker[J]] = []
        self._failed_starts = 0

    def start(self, count: int) -> None:
        """Start ``count`` actors."""
        for _ in range(count):
            worker: _Worker[J] = _Worker(self._actor.remote(self._work, self._share))
            self._pending[worker.actor.place.remote()] = worker

    def start_jobs(self, queue: Queue[J]) -> None:
        """Give the next jobs of ``queue`` to the idle workers."""
        while self._idle and (following := queue.pop()) is not None:
            worker = self._idle.pop()
            worker.attempt = following
            self._notify(following.job, f"attempt {following.number} in {worker.place}")
            self._pending[worker.actor.do.remote(following.job)] = worker

    def receive(self) -> tuple[JobAttempt[J], R | Failure] | None:
        """Wait for an attempt to end; return it and its answer. Return None if a worker has started or failed to."""
        (reference,), _ = self._ray.wait(list(self._pending), num_returns=1)
        worker = self._pending.pop(reference)
        ended, worker.attempt = worker.attempt, None
        try:
            answer = self._ray.get(reference)
        except self._ray.exceptions.RayError as error:
            answer = Failure(f"the Ray worker died ({_reason(error, started=ended is not None)})", final=False)
        if isinstance(answer, Failure) and not answer.final:
            self._replace(worker, answer, started=ended is not None)
        else:
            self._idle.append(worker)
            self._failed_starts = 0
        if ended is None:
            worker.place = str(answer)
            return None
        return ended, answer

    def stop(self) -> None:
        """Kill all actors."""
        for worker in (*self._pending.values(), *self._idle):
            self._ray.kill(worker.actor)

    def _replace(self, worker: _Worker[J], failure: Failure, *, started: bool) -> None:
        # The actor may live, but after an error of memory or of a GPU its state cannot be trusted.
        self._ray.kill(worker.actor)
        self._failed_starts = 0 if started else self._failed_starts + 1
        if self._failed_starts > _FAILED_STARTS_MAX:
            raise RuntimeError(f"Ray's workers die before they start: {failure.reason}")
        self.start(1)


class _Actor(Generic[J, R]):
    """A worker in a process of the cluster."""

    def __init__(self, work: Work[J, R], share: WorkerShare) -> None:
        self._work, self._share = work, share

    def place(self) -> str:
        """Return the process and the machine of this worker."""
        return f"process {os.getpid()} of {socket.gethostname()}"

    def do(self, job: J) -> R | Failure:
        """Return the result of the work."""
        return try_work(self._work, job, self._share, lambda text: None)


def _reason(error: Exception, *, started: bool) -> str:
    """Return the most useful line of Ray's message: the first if a worker died, the last if it failed to start."""
    lines = re.sub(r"\x1b\[\d*m", "", str(error)).strip().splitlines()
    return lines[0 if started else -1]
