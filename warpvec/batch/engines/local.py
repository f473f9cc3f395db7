"""Worker processes of this machine: started once, warm from job to job, replaced when they die.

They are spawned, not forked: a fork of a process with threads and a GPU is not safe. Each has a pipe of its own, so
that one that is killed while it writes harms no other. A worker whose pipe is closed gives up its job, so that none
outlives the process that started it, even where that was killed.
"""

from __future__ import annotations

import signal
from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing import get_context, resource_tracker
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from typing import Generic

from warpvec.batch.engines.base import Attempt, Failure, J, Outcome, Queue, R, Watch, Work, WorkerShare, attempt
from warpvec.rendering.thread_pool import core_count

# A worker without its pipe stops within an iteration of its fit; compiling kernels takes longer.
_STOP_SECONDS = 3.0

_CONTEXT = get_context("spawn")


class LocalEngine:
    """As many processes as the machine has room for; see `machine_shares`.

    Args:
        devices: the GPUs to be used, "cuda:K", or "cpu" alone.
        threads: CPU threads of each worker; None to share out the cores.
        jobs: workers; None for one for each GPU or, on the CPU, as many as the cores have room for.
        retries: how many times a job whose worker died, or failed, is tried again.
    """

    def __init__(self, devices: Sequence[str], threads: int | None, jobs: int | None, retries: int) -> None:
        self._devices, self._threads, self._jobs, self._retries = devices, threads, jobs, retries

    def run(self, jobs: Sequence[J], work: Work[J, R], watch: Watch) -> Generator[Outcome[J, R], None, None]:
        """The outcome of every job as it ends; see `base.Engine`."""
        queue = Queue(jobs, self._retries, watch)
        shares = machine_shares(self._devices, self._threads, self._jobs, len(jobs))
        workers = [_Worker(work, share, watch) for share in shares]
        try:
            while queue.unfinished:
                for worker in workers:
                    worker.begin(queue)
                for worker in _with_news(workers):
                    if (news := worker.hear()) is None:
                        continue
                    if (outcome := queue.settle(*news)) is not None:
                        yield outcome
        finally:
            for worker in workers:
                worker.give_up()
            for worker in workers:
                worker.close()


class _Worker(Generic[J, R]):
    """A process and the attempt it is at, seen from the one that started it."""

    def __init__(self, work: Work[J, R], share: WorkerShare, watch: Watch) -> None:
        self._arguments, self._watch = (work, share), watch
        self._attempt: Attempt[J] | None = None
        self._process: SpawnProcess | None = None

    @property
    def is_busy(self) -> bool:
        return self._attempt is not None

    def begin(self, queue: Queue[J]) -> None:
        """Take the next job of ``queue`` if idle."""
        if self.is_busy or (following := queue.take()) is None:
            return
        self._attempt = following
        process = self._process or self._start()
        self._watch(following.job, f"attempt {following.number} in process {process.pid}")
        with suppress(OSError):  # it died while idle, which `hear` finds out
            self.connection.send(following.job)

    def hear(self) -> tuple[Attempt[J], R | Failure] | None:
        """The attempt and its answer, if that is what the process has to say. A process that failed is replaced."""
        assert self._attempt is not None
        try:
            message = self.connection.recv()
        except (EOFError, OSError):
            message = self._death()
        if isinstance(message, _Word):
            self._watch(self._attempt.job, message.text)
            return None
        ended, self._attempt = self._attempt, None
        if isinstance(message, Failure) and not message.final:
            # After running out of memory, or an error of a GPU, what the process holds is not to be trusted.
            self.close()
        return ended, message

    def give_up(self) -> None:
        """Tell the process to stop."""
        if self._process is not None:
            self.connection.close()

    def close(self) -> None:
        """See the process end; the next job gets a new one."""
        self.give_up()
        if self._process is None:
            return
        if self.is_busy:  # it may be writing its file
            self._process.join(_STOP_SECONDS)
        # An idle one has nothing to lose, and would take a second to unload what it has imported.
        self._process.kill()
        self._process.join()
        self._process = None

    def _start(self) -> SpawnProcess:
        self.connection, theirs = _CONTEXT.Pipe()
        self._process = _CONTEXT.Process(target=_serve, args=(theirs, *self._arguments), daemon=True)
        with _no_interrupts():
            self._process.start()
        # From here on the pipe ends with the process.
        theirs.close()
        return self._process

    def _death(self) -> Failure:
        assert self._process is not None
        self._process.join()
        code = self._process.exitcode or 0
        end = f"was killed by signal {-code}" if code < 0 else f"exited with code {code}"
        hint = " (out of memory?)" if code == -signal.SIGKILL else ""
        return Failure(f"the worker process {end}{hint}", final=False)


def _with_news(workers: Sequence[_Worker[J, R]]) -> list[_Worker[J, R]]:
    """The busy workers that have something to say, or have died; waits for one."""
    busy = {worker.connection: worker for worker in workers if worker.is_busy}
    return [busy[connection] for connection in wait(list(busy)) if isinstance(connection, Connection)]


@contextmanager
def _no_interrupts() -> Iterator[None]:
    """Processes started in this block never see Ctrl-C, which a terminal sends to all of them.

    Blocked and not ignored: an interrupt of this process is only held up, and nothing is said while a child starts.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    # The first process that is spawned starts this helper, which unblocks signals.
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


# In the worker


@dataclass(frozen=True)
class _Word:
    """What is said of a job that goes on."""

    text: str


class _Deserted(BaseException):
    """Nobody listens any more. No Exception, so that no handler on its way takes it for a failure of the job."""


def _serve(connection: Connection, work: Work[J, R], share: WorkerShare) -> None:
    """Do the jobs that come through ``connection`` until it is closed."""

    def send(message: object) -> None:
        try:
            connection.send(message)
        except OSError:
            raise _Deserted from None

    # A job that comes in pieces was cut off with the process that sent it.
    with suppress(EOFError, OSError, _Deserted):
        while True:
            send(attempt(work, connection.recv(), share, lambda text: send(_Word(text))))


def machine_shares(devices: Sequence[str], threads: int | None, jobs: int | None, most: int) -> list[WorkerShare]:
    """The shares of this machine for at most ``most`` workers; the rest is as `LocalEngine` has it."""
    room = core_count() // (threads or 1) if devices[0] == "cpu" else len(devices)
    count = min(jobs or max(1, room), most)
    return [WorkerShare(devices[k % len(devices)], threads or max(1, core_count() // count)) for k in range(count)]
