"""The work of the worker process, apart from its messages: what needs torch and the kernels."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from warpvec.app.fitting import result_facts, run_job
from warpvec.app.mailbox import Mailbox
from warpvec.app.messages import FitJob, Report
from warpvec.app.settings import FitSettings
from warpvec.app.stage_times import StageTimes
from warpvec.modes.choice import draw_picture
from warpvec.modes.flat import KnownOutlines
from warpvec.modes.request import Request
from warpvec.result import Result
from warpvec.watch.watch import Watch


class Worker:
    """Does jobs and sends reports of them.

    Args:
        mailbox: says whether the present job is to stop.
        send: takes the reports.
        threads: CPU threads of fits; None for all cores.
    """

    def __init__(self, mailbox: Mailbox, send: Callable[[Report], None], threads: int | None) -> None:
        self._mailbox, self._send, self._threads = mailbox, send, threads
        self._outlines, self._times = KnownOutlines(), StageTimes()

    def warm_up(self) -> None:
        """Load the kernels of fits, or compile them, with a tiny one, and the modules that a result needs."""
        picture = np.linspace(0.0, 1.0, 16 * 16 * 3, dtype=np.float32).reshape(16, 16, 3)
        config = replace(FitSettings({"curves": 4}).config("photo"), initial_curves=2, iterations=8, inflation_gap=1)
        config = replace(config, recycle_gap=1, recycle_share=0.5, threads=self._threads)
        watch = Watch(listener=self._mailbox)
        result_facts(Result(draw_picture(Request.of(picture, config, watch=watch)), watch.facts()))

    def do(self, job: FitJob) -> dict[str, Any]:
        """Return the facts of the drawing that ``job`` asks for.

        Raises:
            InputError: as `run_job`.
            Dropped: nobody wants the result any more.
        """

        def report(kind: str, facts: dict[str, Any]) -> None:
            self._send(Report(kind, job.number, facts))

        self._mailbox.check()
        watch = Watch(lambda progress: self._mailbox.check(), listener=self._mailbox)
        watch.on_stage = lambda words: report("stage", self._times.begin(words))
        try:
            facts = run_job(job, report, watch, self._threads, self._outlines)
        finally:
            self._times.end()
        self._mailbox.check()
        return facts
