"""The jobs of a batch: find the photos in a folder, vectorize each into a file, and record the results."""

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
from typing import Any

from warpvec.batch.engines.base import Engine, Notify, Outcome, Report, WorkerShare
from warpvec.batch.folders import Folder
from warpvec.batch.journal import Journal, Record
from warpvec.config.fit_config import MACHINE_SETTINGS, FitConfig
from warpvec.drawing.file_options import DEFAULT_FILE_OPTIONS, FileOptions
from warpvec.errors import InputError
from warpvec.goals.goal import NO_GOAL, Goal
from warpvec.image.formats import SUFFIXES
from warpvec.purposes.table import PURPOSES

# Time between two reports of a worker.
_REPORT_SECONDS = 0.5


@dataclass(frozen=True)
class PhotoJob:
    """A photo and its file, by their names in the two folders."""

    input: str
    output: str
    error: str | None = None
    """The reason in one line why the job cannot be done; None if it can."""
    effort: float = 1.0
    """Expected time of the work, in any unit."""


# Finding the jobs


def find_jobs(names: Iterable[str], suffix: str = ".svg", *, keep_suffix: bool = False) -> list[PhotoJob]:
    """Return a job for each photo among ``names``.

    The file has the name of the photo with ``suffix`` in place of its own suffix, or after it if ``keep_suffix``.
    Photos that would have the same file get an error instead.

    Raises:
        InputError: there are no photos.
    """
    photos = [name for name in names if PurePosixPath(name).suffix.lower() in SUFFIXES]
    if not photos:
        rule, remedy = f"must contain photos ({', '.join(SUFFIXES)})", "give --recursive if they are in its folders"
        raise InputError("IN_DIR", rule, "a folder without any", remedy)
    jobs = [PhotoJob(name, (name if keep_suffix else name[: name.rindex(".")]) + suffix) for name in photos]
    by_output = defaultdict(list)
    for job in jobs:
        by_output[job.output].append(job.input)
    return [replace(job, error=_clash(job, by_output[job.output])) for job in jobs]


def _clash(job: PhotoJob, sources: Sequence[str]) -> str | None:
    """Return the error of a job whose file would be that of several photos, ``sources``."""
    if len(sources) == 1:
        return None
    value = f"{job.output} for {' and '.join(sources)}"
    return str(InputError(job.input, "must have a file of its own", value, "rename one, or give --keep-suffix"))


def remaining(jobs: Sequence[PhotoJob], work: Vectorize, journal: Journal, *, skip_existing: bool) -> list[PhotoJob]:
    """Return the jobs that are not done.

    A job is done if its file exists and was made of the same photo with the same settings, or, with
    ``skip_existing``, if its file exists.
    """
    return [
        job
        for job in jobs
        if not (work.target.exists(job.output) and (skip_existing or _is_recorded(job, work, journal)))
    ]


def _is_recorded(job: PhotoJob, work: Vectorize, journal: Journal) -> bool:
    from warpvec.image.read import MAX_IMAGE_BYTES

    record = journal.get(job.input, job.output)
    if job.error is not None or record is None or record.error is not None:
        return False
    if _text(record.settings) != _text(work.settings):
        return False
    try:
        return record.key == work.key(work.source.read(job.input, MAX_IMAGE_BYTES))
    except (InputError, OSError):  # the worker will report it
        return False


def longest_first(jobs: Sequence[PhotoJob], source: Folder) -> list[PhotoJob]:
    """Return ``jobs`` with their expected efforts, the largest first, so that no worker begins a long one at the end.

    The effort is the root of the photo's bytes: from an icon of 6 KB to a photo of 650 KB it grows tenfold, and so does
    the time. Jobs of equal effort keep their order.
    """
    known = [replace(job, effort=math.sqrt(max(source.size(job.input), 1))) for job in jobs]
    return sorted(known, key=lambda job: -job.effort)


# The work on one photo


@dataclass(frozen=True)
class Vectorize:
    """The work on a photo of the folder ``source``: fit and measure its drawing, and write its file to ``target``."""

    source: Folder
    target: Folder
    config: FitConfig
    background: str | None
    goal: Goal = NO_GOAL
    file_options: FileOptions = DEFAULT_FILE_OPTIONS
    option_names: Mapping[str, str] = field(default_factory=dict)
    """Name of a setting -> its name in error messages."""

    @property
    def settings(self) -> dict[str, Any]:
        """Everything but the photo that a file depends on. File options are left out where they are the defaults."""
        settings = {name: value for name, value in self.config.to_dict().items() if name not in MACHINE_SETTINGS}
        usual = asdict(DEFAULT_FILE_OPTIONS)
        changed = {name: value for name, value in asdict(self.file_options).items() if value != usual[name]}
        return {"background": self.background, **settings, **(self.goal.to_dict() if self.goal else {}), **changed}

    def key(self, photo: bytes) -> str:
        """Return a digest of the photo and the settings."""
        return hashlib.sha256(_text(self.settings).encode() + photo).hexdigest()[:32]

    def __call__(self, job: PhotoJob, share: WorkerShare, report: Report, /) -> Record:
        """Vectorize one photo, write its file, and return its record.

        Raises:
            InputError: the photo cannot be read, or the goal cannot be met.
        """
        try:
            return self._vectorize(job, share, report)
        except InputError as error:
            raise error.renamed(self.option_names) from error

    def _vectorize(self, job: PhotoJob, share: WorkerShare, report: Report) -> Record:
        from warpvec.image.read import MAX_IMAGE_BYTES, read_picture
        from warpvec.modes.choice import draw_picture
        from warpvec.modes.request import Request
        from warpvec.result import Result
        from warpvec.watch.progress import Regularly
        from warpvec.watch.watch import Watch

        start = time.perf_counter()
        data = self.source.read(job.input, MAX_IMAGE_BYTES)
        photo = read_picture(data, self.background, name=job.input)
        config = replace(self.config, device=share.device, threads=share.threads)
        title = PurePosixPath(job.input).stem
        watch = Watch(Regularly(lambda _, text: report(text), _REPORT_SECONDS), config.time_budget)
        given: dict[str, Any] = {"title": title, "unread": photo.unread, "options": self.file_options, "watch": watch}
        request = Request.of(photo.pixels, config, self.goal, **given)
        result = Result(draw_picture(request), watch.facts())
        metrics = result.metrics
        made = result.file(job.output)
        self.target.write(job.output, made.data)
        if PURPOSES[self.file_options.purpose].has_picture:
            picture = f"{job.output}.png"
            self.target.write(picture, result.encoded(picture))
        not_kept = metrics["not_kept"].values()
        return Record(
            input=job.input,
            output=job.output,
            **{figure: metrics[figure] for figure in ("mode", "curves", "ssim")},
            bytes=len(made.data),
            psnr=metrics["psnr"] if math.isfinite(metrics["psnr"]) else None,
            seconds=round(time.perf_counter() - start, 3),
            losses="; ".join([*(f"not kept: {words}" for words in not_kept), *made.losses]),
            key=self.key(data),
            settings=self.settings,
        )


def _text(settings: Mapping[str, object]) -> str:
    return json.dumps(settings, sort_keys=True)


# The whole batch


def run_batch(
    jobs: Sequence[PhotoJob], work: Vectorize, engine: Engine, journal: Journal, notify: Notify
) -> Generator[Record, None, None]:
    """Yield the record of every job as it ends, after adding it to ``journal``. Closing it stops the workers."""
    for job in jobs:
        if job.error is not None:
            yield _record(Outcome(job, None, job.error, 0), work, journal)
    sound = [job for job in jobs if job.error is None]
    if not sound:
        return
    with closing(engine.run(sound, work, notify)) as outcomes:
        for outcome in outcomes:
            yield _record(outcome, work, journal)


def _record(outcome: Outcome[PhotoJob, Record], work: Vectorize, journal: Journal) -> Record:
    """Add the record of an outcome to ``journal`` and return it.

    The record of a failed job keeps the figures of a file that an earlier batch made.
    """
    job = outcome.job
    if outcome.value is not None:
        record = replace(outcome.value, attempts=outcome.attempts)
    else:
        before = journal.get(job.input, job.output)
        if before is None or before.key is None or not work.target.exists(job.output):
            before = Record(input=job.input, output=job.output, settings=work.settings)
        error = " ".join((outcome.error or "").split())
        record = replace(before, error=error, attempts=outcome.attempts)
    journal.add(record)
    return record
