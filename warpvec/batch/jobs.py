"""A folder of photos becomes a folder of SVGs: what is to be done, how one photo is, and the records of it all."""

from __future__ import annotations

import hashlib
import json
import math
import time
from collections import defaultdict
from collections.abc import Generator, Iterable, Mapping, Sequence
from contextlib import closing
from dataclasses import asdict, dataclass, field, replace
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Any

from warpvec.batch.engines.base import Engine, Outcome, Say, Watch, WorkerShare
from warpvec.batch.folders import Folder
from warpvec.batch.journal import Journal, Record
from warpvec.config.fit_config import MACHINE_SETTINGS, FitConfig
from warpvec.errors import InputError
from warpvec.vectorization.goal import Goal

if TYPE_CHECKING:
    from warpvec.fit.progress import Progress

SUFFIXES = (".png", ".jpg", ".jpeg", ".webp", ".tif", ".tiff", ".bmp", ".gif")
"""Names that are taken for photos."""

# Between two words of a worker: often enough to be seen alive.
_SAY_SECONDS = 0.5


@dataclass(frozen=True)
class Job:
    """A photo and its SVG, by their names in the two folders."""

    input: str
    output: str


# What is to be done


def find_jobs(names: Iterable[str], suffix: str = ".svg", *, keep_suffix: bool = False) -> list[Job]:
    """The photos among ``names``, each with the name of its SVG: with ``suffix`` in place of its own, or behind it.

    Raises:
        InputError: there are no photos, or two would have the same SVG.
    """
    photos = [name for name in names if PurePosixPath(name).suffix.lower() in SUFFIXES]
    jobs = [Job(name, (name if keep_suffix else name[: name.rindex(".")]) + suffix) for name in photos]
    if not jobs:
        rule = f"IN_DIR must hold photos ({', '.join(SUFFIXES)}), got a folder without"
        raise InputError(f"{rule}; give --recursive if they are in folders of it")
    by_output = defaultdict(list)
    for job in jobs:
        by_output[job.output].append(job.input)
    for output, sources in by_output.items():
        if len(sources) > 1:
            rule = f"IN_DIR must have one photo for each SVG, got {' and '.join(sources)}, which would be one {output}"
            raise InputError(f"{rule}; rename them, or give --keep-suffix for names such as {sources[0]}{suffix}")
    return jobs


def remaining(jobs: Sequence[Job], work: Vectorize, journal: Journal, *, skip_existing: bool) -> list[Job]:
    """The jobs that are not done.

    Done is what has its file, made of the same photo with the same settings; any that has a file, if ``skip_existing``.
    """
    return [
        job
        for job in jobs
        if not (work.target.exists(job.output) and (skip_existing or _is_recorded(job, work, journal)))
    ]


def _is_recorded(job: Job, work: Vectorize, journal: Journal) -> bool:
    record = journal.get(job.output)
    if record is None or record.error is not None or _text(record.settings) != _text(work.settings):
        return False
    try:
        return record.key == work.key(work.source.read(job.input))
    except (InputError, OSError):  # which is for the worker to report
        return False


# One photo


@dataclass(frozen=True)
class Vectorize:
    """The work on each photo of the folder ``source``: its SVG is fitted, measured and written to ``target``."""

    source: Folder
    target: Folder
    config: FitConfig
    background: str | None
    goal: Goal | None = None
    option_names: Mapping[str, str] = field(default_factory=dict)
    """Name of a setting -> what messages call it."""

    @property
    def settings(self) -> dict[str, Any]:
        """What the files depend on, beside the photos."""
        settings = {name: value for name, value in self.config.to_dict().items() if name not in MACHINE_SETTINGS}
        return {"background": self.background, **settings, **(asdict(self.goal) if self.goal else {})}

    def key(self, photo: bytes) -> str:
        """Equal for equal photos with equal settings."""
        return hashlib.sha256(_text(self.settings).encode() + photo).hexdigest()[:32]

    def __call__(self, job: Job, share: WorkerShare, say: Say) -> Record:
        """Vectorize one photo, write its file, and return its record.

        Raises:
            InputError: the photo cannot be read, or the goal cannot be met.
        """
        try:
            return self._vectorize(job, share, say)
        except InputError as error:
            raise error.renamed(self.option_names) from error

    def _vectorize(self, job: Job, share: WorkerShare, say: Say) -> Record:
        from warpvec.files import encode_svg
        from warpvec.image.read import read_image
        from warpvec.vectorization.api import fit_photo

        start = time.perf_counter()
        data = self.source.read(job.input)
        photo = read_image(data, self.background, name=job.input)
        config = replace(self.config, device=share.device, threads=share.threads)
        title = PurePosixPath(job.input).stem
        result = fit_photo(photo, config, title=title, goal=self.goal, on_progress=_Teller(say))
        metrics = result.metrics
        self.target.write(job.output, encode_svg(result.svg(), job.output))
        return Record(
            input=job.input,
            output=job.output,
            curves=metrics["curves"],
            bytes=metrics["bytes"],
            psnr=metrics["psnr"] if math.isfinite(metrics["psnr"]) else None,
            ssim=metrics["ssim"],
            seconds=round(time.perf_counter() - start, 3),
            key=self.key(data),
            settings=self.settings,
        )


def _text(settings: Mapping[str, Any]) -> str:
    return json.dumps(settings, sort_keys=True)


class _Teller:
    """Tells of a fit now and then."""

    def __init__(self, say: Say) -> None:
        from warpvec.fit.progress import Pace

        self._say, self._pace, self._told = say, Pace(), -math.inf

    def __call__(self, progress: Progress) -> None:
        self._pace.see(progress)
        if time.monotonic() - self._told > _SAY_SECONDS:
            self._say(self._pace.describe(progress))
            self._told = time.monotonic()


# All of them


def run_batch(
    jobs: Sequence[Job], work: Vectorize, engine: Engine, journal: Journal, watch: Watch
) -> Generator[Record, None, None]:
    """The record of every job as it ends, kept in ``journal``. Closing the generator ends the workers."""
    with closing(engine.run(jobs, work, watch)) as outcomes:
        for outcome in outcomes:
            record = _record(outcome, work, journal)
            journal.add(record)
            yield record


def _record(outcome: Outcome[Job, Record], work: Vectorize, journal: Journal) -> Record:
    """The record of a job that has ended; of one that failed with the figures of a file that it has from before."""
    if outcome.value is not None:
        return replace(outcome.value, attempts=outcome.attempts)
    job, error = outcome.job, " ".join((outcome.error or "").split())
    before = journal.get(job.output)
    if before is None or before.key is None or not work.target.exists(job.output):
        before = Record(input=job.input, output=job.output, settings=work.settings)
    return replace(before, input=job.input, error=error, attempts=outcome.attempts)
