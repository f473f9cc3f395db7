"""The work of the worker process, apart from its messages: what needs torch and the kernels."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from warpvec.app.fitting import result_facts, run_job
from warpvec.app.frames import FrameWriter
from warpvec.app.mailbox import Mailbox
from warpvec.app.messages import Job, Report
from warpvec.app.settings import FitSettings
from warpvec.config.fit_config import FitConfig
from warpvec.fit import interrupt
from warpvec.fit.progress import Progress
from warpvec.vectorization.api import fit_photo
from warpvec.vectorization.flat_art import Outlines


class Worker:
    """Does jobs and sends reports of them.

    Args:
        mailbox: says whether the present job is to stop.
        send: takes the reports.
        threads: CPU threads of fits; None for all cores.
    """

    def __init__(self, mailbox: Mailbox, send: Callable[[Report], None], threads: int | None) -> None:
        self._mailbox, self._send, self._threads = mailbox, send, threads
        self._outlines = Outlines()
        interrupt.listen_to(mailbox)

    def warm_up(self) -> None:
        """Load the kernels of fits, or compile them, with a tiny one, and the modules that a result needs."""
        picture = np.linspace(0.0, 1.0, 16 * 16 * 3, dtype=np.float32).reshape(16, 16, 3)
        config = replace(FitSettings(curves=4).config("photo"), initial_curves=2, iterations=8, inflation_gap=1)
        config = replace(config, recycle_gap=1, recycle_share=0.5, threads=self._threads)
        result_facts(fit_photo(picture, config))

    def do(self, job: Job) -> dict[str, Any]:
        """Return the facts of the drawing that ``job`` asks for.

        Raises:
            InputError: as `run_job`.
            Dropped: nobody wants the result any more.
        """
        writer: FrameWriter | None = None

        def report(kind: str, facts: dict[str, Any]) -> None:
            nonlocal writer
            writer = FrameWriter(facts["width"], facts["height"], self._frame_sender(job.number), FitConfig.fit_size)
            self._send(Report(kind, job.number, facts))

        def on_progress(progress: Progress) -> None:
            self._mailbox.check()
            assert writer is not None
            writer(progress)

        self._mailbox.check()
        result = run_job(job, report, on_progress, self._threads, self._outlines)
        self._mailbox.check()
        return result_facts(result)

    def _frame_sender(self, number: int) -> Callable[[dict[str, Any]], None]:
        return lambda facts: self._send(Report("frame", number, facts))
