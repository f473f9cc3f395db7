"""Make the tables and figures of the paper (Vector Scaffolding), with its values beside ours.

Each table or figure is a command. It fits the photos of a folder with the paper's configuration, with the paper's
ideas switched off in turn, or with the methods that the paper compares. It writes a CSV with a row for every fit, a
Markdown table, and the pictures of the paper. A command that was interrupted continues where it ended. Equal settings
give equal numbers, except for fits with a time budget.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping, Sequence
from itertools import chain, product
from typing import Any

import click
from harness import comma_separated, markdown_table
from paper_figures import Tile, by_generation, plot_histories, save_animation, sheet
from paper_fits import Case, Photo, Pixels, soft_image
from paper_study import Study, experiment
from paper_tables import PSNR, Line, fits_table, quality_table, sweep_table
from paper_values import (
    BASELINE_NOTE_1,
    BASELINE_NOTE_2,
    COLUMNS_NOTE,
    HIERARCHY,
    INTERIOR,
    LR_REFERENCE,
    TABLE_1,
    TABLE_2,
    TABLE_3,
    TRAJECTORY,
    Quantitative,
)

from warpvec.image.metrics import psnr

RIVALS = ("paper", "bezier-splatting")
"""The presets that the paper compares."""

# More iterations than any time budget allows.
_ENDLESS = 1_000_000


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
def main() -> None:
    """Make a table or figure of the paper."""


# Tables 1 and 2


_presets_option = click.option(
    "--presets", callback=comma_separated, default=",".join([RIVALS[0], "paper-released", RIVALS[1], "default"]),
    show_default=True,
)  # fmt: skip


@experiment(main, curves="256,512,1024")
@_presets_option
def table1(study: Study, presets: list[str]) -> str:
    """Table 1: PSNR, SSIM and LPIPS of the Kodak photos in FOLDER."""
    return _quality(study, presets, TABLE_1, "means over the 24 photos of the Kodak set", BASELINE_NOTE_1)


@experiment(main, curves="256,512,1024")
@_presets_option
def table2(study: Study, presets: list[str]) -> str:
    """Table 2: the same for any photos in FOLDER, beside the paper's values for DIV2K."""
    return _quality(study, presets, TABLE_2, "means over DIV2K", BASELINE_NOTE_2)


def _quality(study: Study, presets: Sequence[str], paper: Quantitative, source: str, baseline: str) -> str:
    cases = {
        (preset, count): [study.case(photo, count, preset) for photo in study.photos]
        for count, preset in product(study.curves, presets)
    }
    study.fits.fill(chain.from_iterable(cases.values()))
    groups = {key: study.rows(group) for key, group in cases.items()}
    return f"{quality_table(groups, paper)}\n\n{_note(source)} {baseline} {COLUMNS_NOTE}"


def _note(source: str) -> str:
    """Describe the paper's values under a table."""
    return f"The paper's values: {source} at full size, its soft image, 5000 iterations (Bezier Splatting: 10,000)."


# Ablations


@experiment(main, curves="512", images="kodim07")
def interior(study: Study) -> str:
    """The figure "Effect of Interior Gradients"."""
    variants = {(name,): {"interior_gradient": name == "on"} for name in INTERIOR}
    papers = {(name,): value for name, value in INTERIOR.items()}
    return _ablation(study, ("interior gradient",), variants, papers, "kodim07")


@experiment(main, curves="512", images="kodim07")
def hierarchy(study: Study) -> str:
    """The figure "Hierarchical Scaffolding vs. Flat Optimization".

    In flat fits, paths are ordered by area, smaller bounding boxes on top, unless --set z_order=creation is given.
    """
    flat = {"flat": True, "z_order": study.settings.get("z_order", "area")}
    strategies: dict[str, dict[str, Any]] = {"flat": flat, "hierarchical": {"flat": False}}
    variants = {
        (name, factor): {**settings, "lr_scale": factor / LR_REFERENCE}
        for (name, settings), factor in product(strategies.items(), (1, LR_REFERENCE))
    }
    return _ablation(study, ("strategy", "lr x"), variants, HIERARCHY, "DIV2K 0383")


def _ablation(
    study: Study,
    names: Sequence[str],
    variants: Mapping[tuple[Any, ...], Mapping[str, Any]],
    paper: Mapping[tuple[Any, ...], float],
    source: str,
) -> str:
    """Fit each variant of the paper's preset; return the table and write a picture of each."""
    lines = []
    for photo, count in product(study.photos, study.curves):
        tiles = [Tile(photo.pixels, photo.name)]
        cases = {labels: study.case(photo, count, studied=settings) for labels, settings in variants.items()}
        study.fits.fill(cases.values())
        for labels, case in cases.items():
            line = Line((photo.name, count, *labels), study.fits.row(case), paper.get(labels))
            tiles.append(_tile(study, case, f"{', '.join(names)}: {', '.join(map(str, labels))}"))
            lines.append(line)
        sheet([tiles]).save(study.path(f"-{photo.name}-{count}.png"))
    return f"{fits_table(('image', 'curves', *names), lines)}\n\n{_note(source)}"


def _tile(study: Study, case: Case, title: str) -> Tile:
    return Tile(study.fits.soft(case), f"{title}\n{float(study.fits.row(case)['soft_psnr']):.2f} dB")


@experiment(main, curves="512", images="kodim01,kodim07,kodim13,kodim19", iterations="1000,5000")
@click.option("--panels", callback=comma_separated, default=",".join(TABLE_3), show_default=True)
def table3(study: Study, panels: list[str]) -> str:
    """Table 3: sweeps of the learning rate, the radius decay and the inflation gap."""
    if unknown := set(panels) - set(TABLE_3):
        raise click.UsageError(f"--panels must be among {', '.join(TABLE_3)}, got {', '.join(sorted(unknown))}")
    if len(study.curves) > 1:
        raise click.UsageError("--curves must be one number for this table, got several; run the command once for each")
    return "\n\n".join([*(_panel(study, panel) for panel in panels), _note("means over four Kodak photos")])


# As Table 3 shows, the paper's short runs with long gaps end before their last inflation.
_LITERAL = {"shorten_gap": False}


def _panel(study: Study, panel: str) -> str:
    sweep = TABLE_3[panel]
    divisor = LR_REFERENCE if panel == "lr" else 1
    values = [value / divisor if panel == "lr" else value for value in sweep.values]
    cases = {
        count: [_sweep_cases(study, {**_LITERAL, sweep.setting: value, "iterations": count}) for value in values]
        for count in study.iterations
    }
    study.fits.fill(case for groups in cases.values() for group in groups for case in group)
    return sweep_table(sweep, {count: [study.rows(group) for group in groups] for count, groups in cases.items()})


def _sweep_cases(study: Study, studied: Mapping[str, Any]) -> list[Case]:
    return [study.case(photo, study.curves[0], studied=studied) for photo in study.photos]


# Trajectories, levels of detail, layers


@experiment(main, curves="512", images="kodim01")
@click.option("--every", type=click.IntRange(min=1), help="Iterations between frames [a 50th of the shorter run].")
def trajectory(study: Study, every: int | None) -> str:
    """PSNR during the fits of the paper's preset and of Bezier Splatting's, with frames and an animation."""
    lines = []
    for photo, count in product(study.photos, study.curves):
        shortest = min(study.case(photo, count, preset).config.iterations for preset in RIVALS)
        gap = every or max(1, shortest // 50)
        cases = {preset: study.case(photo, count, preset, every=gap) for preset in RIVALS}
        lines += [Line((photo.name, count, preset), study.fits.row(case)) for preset, case in cases.items()]
        _draw_trajectories(study, photo, count, cases)
    return fits_table(("image", "curves", "preset"), lines)


def _draw_trajectories(study: Study, photo: Photo, count: int, cases: Mapping[str, Case]) -> None:
    name = f"-{photo.name}-{count}"
    frames = {preset: study.fits.frames(case) for preset, case in cases.items()}
    iterations = sorted(set().union(*frames.values()))
    # A run that is shorter than the paper's shows frames at the same fractions.
    share = min(1.0, iterations[-1] / TRAJECTORY[-1])
    checkpoints = [[_frame(photo, preset, found, share * at) for at in TRAJECTORY] for preset, found in frames.items()]
    sheet(checkpoints).save(study.path(f"{name}.png"))
    steps = [[[_frame(photo, preset, found, at) for preset, found in frames.items()]] for at in iterations]
    save_animation(study.path(f"{name}.webp"), [sheet(tiles, photo.pixels.shape[1]) for tiles in steps])
    histories = {preset: study.fits.history(case) for preset, case in cases.items()}
    _write_histories(study, name, histories)
    try:
        plot_histories(study.path(f"{name}-plot.png"), histories, f"{photo.name}, {count} curves")
    except click.ClickException as error:
        click.echo(error.format_message(), err=True)


def _frame(photo: Photo, preset: str, frames: Mapping[int, Any], iteration: float) -> Tile:
    """Return the last frame up to ``iteration``, or the first frame if there is none."""
    at = max((k for k in frames if k <= iteration), default=min(frames))
    return Tile(frames[at], f"{preset}\niteration {at}, {psnr(frames[at], photo.pixels):.2f} dB")


def _write_histories(study: Study, name: str, histories: Mapping[str, Iterable[Mapping[str, float]]]) -> None:
    with study.path(f"{name}-history.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, ("preset", "iteration", "curves", "psnr", "seconds"), lineterminator="\n")
        writer.writeheader()
        for preset, history in histories.items():
            writer.writerows({"preset": preset, **entry} for entry in history)


@experiment(main, curves="32,64,128,256,512,1024", images="kodim07")
def lod(study: Study) -> str:
    """Levels of detail: a fit for each number of curves, and the first generations of the largest fit."""
    lines, levels = [], []
    for photo in study.photos:
        cases = {count: study.case(photo, count) for count in sorted(study.curves)}
        study.fits.fill(cases.values())
        lines += [Line((photo.name, count), study.fits.row(case)) for count, case in cases.items()]
        tiles = [_tile(study, case, f"{count} curves") for count, case in cases.items()]
        prefixes = _prefixes(study, cases[max(study.curves)])
        levels += [[photo.name, *cells] for cells, _ in prefixes]
        captions = ("LoD {}, {} curves\n{} dB".format(*cells) for cells, _ in prefixes)
        sheet([tiles, [Tile(pixels, text) for (_, pixels), text in zip(prefixes, captions, strict=True)]]).save(
            study.path(f"-{photo.name}.png")
        )
    prefix_table = markdown_table(("image", "LoD", "curves", "soft PSNR"), levels)
    return f"{fits_table(('image', 'curves'), lines)}\n\nThe first generations of the last fit:\n\n{prefix_table}"


def _prefixes(study: Study, case: Case) -> list[tuple[list[object], Pixels]]:
    """Draw a fit up to each of its generations; return generation, number of curves and PSNR, and the image."""
    scene, prefixes = study.fits.scene(case), []
    for level in range(int(scene.generation.max()) + 1):
        part = scene.select(scene.generation <= level)
        pixels = soft_image(part, case)
        prefixes.append(([level, len(part), format(psnr(pixels, case.photo.pixels), PSNR)], pixels))
    return prefixes


@experiment(main, curves="512", images="kodim07")
def layers(study: Study) -> str:
    """The figure "Layered Primitive Visualization": original, vectorized, and coloured by generation."""
    lines = []
    for photo, count in product(study.photos, study.curves):
        case = study.case(photo, count)
        lines.append(Line((photo.name, count), study.fits.row(case)))
        colored = soft_image(by_generation(study.fits.scene(case)), case)
        tiles = [Tile(photo.pixels, "Original"), _tile(study, case, "Vectorized"), Tile(colored, "Layer ordering")]
        sheet([tiles]).save(study.path(f"-{photo.name}-{count}.png"))
    return fits_table(("image", "curves"), lines)


# Beyond the paper


@experiment(main, curves="256", images="kodim01,kodim07,kodim19")
def compare(study: Study) -> str:
    """The paper's soft renderer against the exact one, with equal photo, curves and time.

    Each of the presets paper and default runs for all its iterations, and then for the time that the other took.
    """
    lines = []
    for photo, count in product(study.photos, study.curves):
        for preset, other in (("paper", "default"), ("default", "paper")):
            whole = study.row(photo, count, preset)
            limits = {"time_budget": float(whole["seconds"]), "iterations": _ENDLESS}
            lines.append(Line((photo.name, count, preset, "its own"), whole))
            lines.append(Line((photo.name, count, other, f"that of {preset}"), study.row(photo, count, other, limits)))
    return fits_table(("image", "curves", "preset", "time"), lines)


if __name__ == "__main__":
    main()
