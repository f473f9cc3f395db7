"""The worker process: it fits one picture after another, and tells the server how they come on.

It is a process of its own, so that the server answers while a fit computes, and that a fit can be ended in any state.
It never outlives the server: once the pipe between them closes, it ends at once.
"""

from __future__ import annotations

from contextlib import suppress
from multiprocessing.connection import Connection
from typing import TYPE_CHECKING

from warpvec.app.mailbox import Dropped, Mailbox
from warpvec.app.messages import FitJob, Report
from warpvec.errors import InputError

if TYPE_CHECKING:
    from warpvec.app.work import Worker


def serve(connection: Connection, threads: int | None) -> None:
    """Do the jobs that come through ``connection``, with so many CPU ``threads``, until it closes."""
    mailbox = Mailbox(connection)
    from warpvec.app.work import Worker  # takes seconds, in which messages already arrive

    with suppress(OSError):  # the server has ended
        worker = Worker(mailbox, connection.send, threads)
        worker.warm_up()
        connection.send(Report("ready", 0))
        while True:
            job = mailbox.next_job()
            connection.send(_answer(worker, job))


def _answer(worker: Worker, job: FitJob) -> Report:
    try:
        return Report("done", job.number, worker.do(job))
    except Dropped:
        return Report("dropped", job.number)
    except InputError as error:
        return Report("failed", job.number, {"message": str(error)})
    except MemoryError:
        return Report("failed", job.number, {"message": "memory has run out; take a smaller picture or fewer paths"})
    except OSError:
        raise
    except Exception as error:
        message = f"the fit failed ({type(error).__name__}: {error})"
        return Report("failed", job.number, {"message": message})
