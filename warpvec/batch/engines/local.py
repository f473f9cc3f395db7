"""Worker processes on this machine: started once, kept from job to job, replaced when they die.

Each worker has a pipe of its own, so that a worker killed in the middle of a message harms no other. A worker stops its
job when its pipe closes: no worker outlives the process of the batch, even if that process is killed.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from typing import Generic

from warpvec.batch.engines.base import Failure, J, JobAttempt, Notify, Outcome, Queue, R, Work, WorkerShare, try_work
from warpvec.batch.engines.spawned import end_of, spawn
from warpvec.rendering.thread_pool import core_count

# A worker stops within an iteration of its fit when its pipe closes; compiling kernels takes longer.
_STOP_SECONDS = 3.0

_WORKERS_PER_CORE_MAX = 4
"""More workers than cores only take turns, and each holds half a gigabyte. Thousands would fill the memory."""


class LocalEngine:
    """An engine with as many processes as the machine has room for; see `machine_shares`.

    Args:
        devices: the GPUs to use, "cuda:K", or "cpu" alone.
        threads: CPU threads of each worker; None divides the cores among them.
        jobs: number of workers; None for one per GPU or, on the CPU, as many as the cores have room for. At
            most four per core are started.
        retries: number of further attempts at a job that failed or whose worker died.
        prepare: what each worker calls first, such as imports; it can be pickled.
    """

    def __init__(
        self,
        devices: Sequence[str],
        threads: int | None,
        jobs: int | None,
        retries: int,
        prepare: Callable[[], None] | None = None,
    ) -> None:
        self._devices, self._threads, self._jobs, self._retries = devices, threads, jobs, retries
        self._prepare = prepare

    def run(self, jobs: Sequence[J], work: Work[J, R], notify: Notify) -> Generator[Outcome[J, R], None, None]:
        """Yield the outcome of every job as it ends; see `base.Engine`."""
        queue = Queue(jobs, self._retries, notify)
        shares = machine_shares(self._devices, self._threads, self._jobs, len(jobs))
        workers = [_Worker(work, share, notify, self._prepare) for share in shares]
        try:
            while queue.unfinished:
                for worker in workers:
                    worker.start_next(queue)
                for worker in _wait_for_messages(workers):
                    if (ended := worker.receive()) is None:
                        continue
                    if (outcome := queue.finish(*ended)) is not None:
                        yield outcome
        finally:
            for worker in workers:
                worker.request_stop()
            for worker in workers:
                worker.stop()


def machine_shares(devices: Sequence[str], threads: int | None, jobs: int | None, job_count: int) -> list[WorkerShare]:
    """Return the share of each worker, for at most ``job_count`` workers; the other arguments as in `LocalEngine`."""
    room = core_count() // (threads or 1) if devices[0] == "cpu" else len(devices)
    count = min(jobs or max(1, room), job_count, max(room, _WORKERS_PER_CORE_MAX * core_count()))
    return [WorkerShare(devices[k % len(devices)], threads or max(1, core_count() // count)) for k in range(count)]


class _Worker(Generic[J, R]):
    """A worker process and its current attempt, as the process of the batch sees them."""

    def __init__(
        self, work: Work[J, R], share: WorkerShare, notify: Notify, prepare: Callable[[], None] | None
    ) -> None:
        self._arguments, self._notify = (prepare, work, share), notify
        self._attempt: JobAttempt[J] | None = None
        self._process: SpawnProcess | None = None

    @property
    def is_busy(self) -> bool:
        return self._attempt is not None

    def start_next(self, queue: Queue[J]) -> None:
        """Start the next job of ``queue`` if idle."""
        if self.is_busy or (following := queue.pop()) is None:
            return
        self._attempt = following
        if self._process is None:
            self._process, self.connection = spawn(_serve, *self._arguments)
        self._notify(following.job, f"attempt {following.number} in process {self._process.pid}")
        with suppress(OSError):  # the process died while idle; `receive` reports that
            self.connection.send(following.job)

    def receive(self) -> tuple[JobAttempt[J], R | Failure] | None:
        """Return the attempt and its answer; None if the message is only a report. Stop a process that failed."""
        assert self._attempt is not None
        try:
            message = self.connection.recv()
        except (EOFError, OSError):
            message = self._death()
        if isinstance(message, _ProgressReport):
            self._notify(self._attempt.job, message.text)
            return None
        ended, self._attempt = self._attempt, None
        if isinstance(message, Failure) and not message.final:
            # After an error of memory or of a GPU the state of the process cannot be trusted.
            self.stop()
        return ended, message

    def request_stop(self) -> None:
        """Close the pipe, which makes the process stop."""
        if self._process is not None:
            self.connection.close()

    def stop(self) -> None:
        """Wait for the end of the process. The next job gets a new one."""
        self.request_stop()
        if self._process is None:
            return
        if self.is_busy:  # it may be writing its file
            self._process.join(_STOP_SECONDS)
        # An idle process has nothing to lose, and would take a second to unload its modules.
        self._process.kill()
        self._process.join()
        self._process = None

    def _death(self) -> Failure:
        """Return the failure of a process that died."""
        assert self._process is not None
        self._process.join()
        return Failure(f"the worker process {end_of(self._process)}", final=False)


def _wait_for_messages(workers: Sequence[_Worker[J, R]]) -> list[_Worker[J, R]]:
    """Wait until a busy worker has sent a message or died; return all such workers."""
    busy = {worker.connection: worker for worker in workers if worker.is_busy}
    return [busy[connection] for connection in wait(list(busy)) if isinstance(connection, Connection)]


# In the worker process


@dataclass(frozen=True)
class _ProgressReport:
    """A message about a job that is not done."""

    text: str


class _PipeClosed(BaseException):
    """The starting process has closed the pipe. Not an Exception, so that no handler takes it for a failed job."""


def _serve(connection: Connection, prepare: Callable[[], None] | None, work: Work[J, R], share: WorkerShare) -> None:
    """Prepare, and do the jobs that arrive through ``connection`` until it closes."""
    if prepare is not None:
        prepare()

    def send(message: object) -> None:
        try:
            connection.send(message)
        except OSError:
            raise _PipeClosed from None

    # EOFError also means a job whose sender died before it was sent completely.
    with suppress(EOFError, OSError, _PipeClosed):
        while True:
            send(try_work(work, connection.recv(), share, lambda text: send(_ProgressReport(text))))
