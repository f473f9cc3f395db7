"""Shared parts of the commands of `paper.py`: their options and the output of their results."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import Any

import click
from fits import Row, engine_for, jobs_option
from harness import (
    comma_separated_counts,
    default_cache,
    machine_facts,
    machine_line,
    parse_settings,
    settings_option,
)
from paper_fits import Case, Fits, Photo, choose_photos

from warpvec.errors import InputError
from warpvec.rendering.launch import resolve_device


@dataclass(frozen=True)
class Study:
    """Input of every command: photos, numbers of curves and iterations, settings of all fits, and their file.

    ``iterations`` is empty if the presets' own apply.
    """

    photos: list[Photo]
    curves: list[int]
    iterations: list[int]
    settings: Mapping[str, Any]
    out: Path
    fits: Fits

    def case(
        self, photo: Photo, curves: int, preset: str = "paper", studied: Mapping[str, Any] | None = None, every: int = 0
    ) -> Case:
        """Return a fit; the ``studied`` settings take precedence over those of the command line."""
        iterations = {"iterations": self.iterations[0]} if self.iterations else {}
        return Case(photo, preset, {**self.settings, **iterations, **(studied or {}), "curves": curves}, every)

    def row(self, *args: Any, **kwargs: Any) -> Row:
        """Return the results of :meth:`case`."""
        return self.fits.row(self.case(*args, **kwargs))

    def rows(self, cases: Sequence[Case]) -> list[Row]:
        """Return the results of many cases, measuring the missing ones together."""
        self.fits.fill(cases)
        return [self.fits.row(case) for case in cases]

    def path(self, suffix: str) -> Path:
        """Return the path of a file beside the CSV."""
        return self.out.with_name(self.out.stem + suffix)


def experiment(
    group: click.Group, *, curves: str, images: str | None = None, iterations: str | None = None
) -> Callable[[Callable[..., str]], click.Command]:
    """Return a decorator that turns a function from a `Study` to Markdown into a command.

    Args:
        group: group of the command.
        curves, images, iterations: defaults of these options; a command takes two numbers of iterations only if its
            default has two.
    """
    fallbacks = {"images": images or "all", "iterations": iterations or "the preset's"}
    options = (
        click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path)),
        click.option("--scale", type=click.FloatRange(0, 1, min_open=True), default=1.0, help="Photo size [1]."),
        click.option("--images", default=images, help=f"Names of photos without suffix [{fallbacks['images']}]."),
        click.option("--curves", callback=comma_separated_counts, default=curves, show_default=True),
        click.option(
            "--iterations", callback=_counts(iterations is not None), default=iterations,
            help=f"Of every fit [{fallbacks['iterations']}]; dT stays the same, --set inflation_gap=N changes it.",
        ),
        click.option("--out", type=click.Path(dir_okay=False, path_type=Path), help="CSV file [in a temp folder]."),
        jobs_option,
        settings_option,
    )  # fmt: skip

    def decorate(body: Callable[..., str]) -> click.Command:
        @wraps(body)
        def command(**given: Any) -> None:
            try:
                _run(body, **given)
            except InputError as error:
                raise click.UsageError(str(error)) from error

        for option in reversed(options):
            command = option(command)
        return group.command(command)

    return decorate


def _counts(several: bool) -> Callable[[click.Context, click.Parameter, str | None], list[int]]:
    def parse(ctx: click.Context, param: click.Parameter, value: str | None) -> list[int]:
        counts = [] if value is None else comma_separated_counts(ctx, param, value)
        if len(counts) > (2 if several else 1):
            raise click.BadParameter(f"must be {'one or two numbers' if several else 'one number'}, got {value!r}")
        return counts

    return parse


def _run(
    body: Callable[..., str],
    *,
    folder: Path,
    scale: float,
    images: str | None,
    curves: list[int],
    iterations: list[int],
    out: Path | None,
    jobs: int,
    assignments: tuple[str, ...],
    **own: Any,
) -> None:
    """Run an experiment; print its table with the settings and the machine, and write it beside the CSV."""
    engine, settings = engine_for(jobs, parse_settings(assignments))
    facts = machine_facts(resolve_device(settings.get("device", "auto")))
    out = out or default_cache() / "paper" / f"{body.__name__}.csv"
    photos = choose_photos(folder, None if images is None else images.split(","), scale)
    fits = Fits(out, engine)
    study = Study(photos, curves, iterations, settings, out, fits)
    table = body(study, **own)
    footer = f"scale {scale:g}, iterations {iterations or 'of the presets'}, settings {json.dumps(settings)}"
    text = f"{table}\n\n{footer}; every fit: {out.name}\n\n{machine_line(facts)}\n"
    study.path(".md").write_text(text)
    click.echo(text + f"\nin {out.parent}")
