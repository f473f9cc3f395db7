"""Work for the tests of engines, in a module that is light because each worker process imports it."""

from __future__ import annotations

import os
import signal
import time
from dataclasses import dataclass
from pathlib import Path

from warpvec.batch.engines.base import Report, WorkerShare
from warpvec.errors import InputError


@dataclass(frozen=True)
class Trial:
    """Do what the name of the job says, and note the process number of each attempt in ``folder``."""

    folder: Path

    def __call__(self, job: str, share: WorkerShare, report: Report, /) -> str:
        """Return the number of the process, in digits."""
        with (self.folder / job).open("a") as file:
            file.write(f"{os.getpid()}\n")
        attempts = len(self.begun(job))
        report(f"{job} on {share.threads} threads")
        if job.startswith("dies") or (job.startswith("once") and attempts == 1):
            os.kill(os.getpid(), signal.SIGKILL)
        if job.startswith("fails"):
            raise ValueError("no luck")
        if job.startswith("wrong"):
            raise InputError("IN", "must be right", "wrong", "mend it")
        while job.startswith("endless"):
            report("still there")
            time.sleep(0.01)
        return str(os.getpid())

    def begun(self, job: str) -> list[int]:
        """Return the processes that have begun ``job``."""
        path = self.folder / job
        return [int(line) for line in path.read_text().split()] if path.exists() else []
