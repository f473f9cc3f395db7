"""Time one step of the fit, a plain render, and a change of the paths as a GPU has it, by stage.

The step is the fit's own (``warpvec.fit.loop``) with a stopwatch around the method of each stage. A row is named
after the kernel file that does its work; "host" is the time of the step outside of its stages. The learning rate is
0, so every step sees the same scene while the optimizer still does all of its work.

The scene is a short fit of a real photo. The time depends on how paths overlap, how many pixels their edges cross and
how many paths lie under opaque ones; random scenes resemble photos in none of these.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from functools import wraps
from pathlib import Path
from typing import Any, NamedTuple
from unittest.mock import patch

import click
import torch
from bench_scenes import SCENES, load_scene, named_subject, photo_subject, sample_photo, scene_file
from cost_model import report_ideal, work_of_step
from harness import (
    Laps,
    Statistics,
    comma_separated_counts,
    default_cache,
    machine_facts,
    machine_line,
    markdown_table,
    parse_settings,
    settings_option,
)
from rivals import Rival, report_rivals, time_diffvg, time_resvg
from roofline import measure_roof, report_roofline

from warpvec.config.fit_config import FitConfig
from warpvec.config.presets import make_config
from warpvec.errors import InputError
from warpvec.fit.budget import ANY_FILE
from warpvec.fit.loop import _Fit
from warpvec.fit.opacity_columns import OpacityColumns
from warpvec.fit.placement import colors_at, new_paths
from warpvec.fit.places import Places
from warpvec.fit.population import Population
from warpvec.fit.recycling import Recycling
from warpvec.fit.regularization import Regularization
from warpvec.geometry.scene import Scene
from warpvec.paper.side_terms import SideTerms
from warpvec.paper.stages.row_opacity import RowOpacity
from warpvec.paper.stages.splat_binning import SplatBinning
from warpvec.paper.stages.splat_coverage import SplatCoverage
from warpvec.paper.stages.splatting import Splatting
from warpvec.rendering.launch import resolve_device
from warpvec.rendering.stages.binning import Binning
from warpvec.rendering.stages.compositing import Compositing
from warpvec.rendering.stages.coverage import Coverage
from warpvec.rendering.stages.flattening import Flattening
from warpvec.rendering.tile_renderer import TileRenderer
from warpvec.watch.watch import Watch

# Steps before the first lap, in which kernels are compiled and loaded, buffers grow and caches fill.
_WARMUP_STEPS = 5


class Stage(NamedTuple):
    """A row of the table: the time spent in a method. A ``part`` is included in another row already."""

    name: str
    owner: type
    method: str
    part: bool = False


_AFTER = (
    Stage("compositing", Compositing, "run"),
    Stage("compositing_adjoint", Compositing, "adjoint"),
    Stage("removal_costs", TileRenderer, "_cost_removals"),
)
_LAST = (
    Stage("regularization", Regularization, "add_adjoint"),
    Stage("population", Population, "step"),
    Stage("- opacity_columns", OpacityColumns, "joined", part=True),
)
_WITHIN_BINNING = (
    Stage("- bounds", Binning, "_bound", part=True),
    Stage("- sort", Binning, "_sort", part=True),
)
STAGES = {
    "exact": (
        Stage("flattening", Flattening, "run"),
        Stage("binning", Binning, "run"),
        *_WITHIN_BINNING,
        Stage("coverage", Coverage, "run"),
        *_AFTER,
        Stage("coverage_adjoint", Coverage, "adjoint"),
        Stage("flattening, adjoint", Flattening, "adjoint"),
        *_LAST,
    ),
    "splat": (
        Stage("row_opacity", RowOpacity, "run"),
        Stage("splatting", Splatting, "run"),
        Stage("splat_binning", SplatBinning, "bin_splats"),
        *_WITHIN_BINNING,
        Stage("splat_coverage", SplatCoverage, "run"),
        *_AFTER,
        Stage("splat_coverage_adjoint", SplatCoverage, "adjoint"),
        Stage("splatting_adjoint", Splatting, "adjoint"),
        Stage("row_opacity_adjoint", RowOpacity, "adjoint"),
        Stage("side_terms", SideTerms, "add_adjoint"),
        *_LAST,
    ),
    "recycling": (
        Stage("recycling", Recycling, "change"),
        Stage("places", Places, "draw"),
    ),
}
"""Stages by renderer, in the order of the step; ``compositing_adjoint`` gives image, loss and adjoint in one pass. The
last ones are those of a change of the paths in an arena, which a fit on a GPU has every 25 steps."""


WHOLES = ("step", "render", "change")
"""What a lap times: the tables of the report."""


class Bench:
    """The step and the render of one scene on one device and thread count, and the times of their laps."""

    def __init__(self, target: torch.Tensor, scene: Scene, config: FitConfig, device: str) -> None:
        self._fit = _Fit(target, config, device, Watch().part(), start=None, saving=None, written=ANY_FILE)
        # The scene to measure replaces the fit's own start.
        half_side = max(target.shape[:2]) / 2
        self._fit._population = Population(scene.to(device), config, half_side)
        # Another one, in an arena: what a step does with it depends on how its memory came to be.
        self._recycled = Population(scene.to(device), config, half_side, has_room=True)
        self._places, self._generator = Places(device), torch.Generator().manual_seed(0)
        self.step, self.render, self.change = Laps(device), Laps(device), Laps(device)
        self.counts: dict[str, int] = {"paths": len(scene)}

    def warm_up(self) -> None:
        """Take a few steps, so that everything kept between steps is compiled, loaded and filled."""
        for _ in range(_WARMUP_STEPS):
            self._take_step()
            self._draw()
            self._recycle()

    def lap(self) -> None:
        """Time one step, one render and one change of the paths as a whole, then one of each by stage."""
        actions = (self._take_step, self._draw, self._recycle)
        for name, laps, action in zip(WHOLES, (self.step, self.render, self.change), actions, strict=True):
            action()  # as in a fit, the step before used the same buffers, not those of another thread count
            laps.start()
            laps.time(name, action)
            with self._watched(laps):
                laps.time("by stage", action)

    def results(self) -> dict[str, dict[str, Statistics]]:
        """Return the statistics of ``WHOLES`` by row, in the order of ``STAGES``."""
        own = STAGES[self._fit._config.renderer]
        parts = zip(WHOLES, (self.step, self.render, self.change), (own, own, STAGES["recycling"]), strict=True)
        return {name: _rows(name, laps, stages) for name, laps, stages in parts}

    def _take_step(self) -> None:
        self._fit._step(self._fit._iteration, False)

    def _draw(self) -> None:
        scene = self._fit._population.scene
        self._fit._target._renderer.render(scene)

    def _recycle(self) -> None:
        """Replace as many paths as a fit does at a time, here the lowest and others at random places."""
        population, config, image = self._recycled, self._fit._config, self._fit._image
        count = int(len(population) * config.recycle_share)
        population.remove_cheapest(torch.arange(len(population), dtype=torch.float32, device=image.device), count)
        center = self._places.draw(image[..., 0], count, self._generator)
        color, opacity = colors_at(image[..., :3], center), torch.full_like(center[:, 0], 0.5)
        background = population.shown.background
        population.append(new_paths(center, (6.0, 6.0), color, opacity, background, 0, config))

    @contextmanager
    def _watched(self, laps: Laps) -> Iterator[None]:
        with ExitStack() as patches:
            self._fit._target.pause_recording(True)
            patches.callback(self._fit._target.pause_recording, False)
            for stage in (*STAGES[self._fit._config.renderer], *STAGES["recycling"]):
                patches.enter_context(patch.object(stage.owner, stage.method, self._timed(stage, laps)))
            yield

    def _timed(self, stage: Stage, laps: Laps) -> Callable[..., Any]:
        method = getattr(stage.owner, stage.method)

        @wraps(method)
        def call(owner: Any, *args: Any, **kwargs: Any) -> Any:
            result = laps.time(stage.name, lambda: method(owner, *args, **kwargs))
            self._count(owner)
            return result

        return call

    def _count(self, owner: object) -> None:
        if isinstance(owner, Flattening):
            self.counts["vertices"] = owner.vertex_count
        elif isinstance(owner, Binning) and hasattr(owner, "slot_count"):
            self.counts |= {"pairs": owner.pair_count, "partial pairs": owner.slot_count}


def _rows(whole: str, laps: Laps, stages: tuple[Stage, ...]) -> dict[str, Statistics]:
    laps.remainder("host", "by stage", [stage.name for stage in stages if not stage.part])
    found = laps.statistics()
    order = [*(stage.name for stage in stages), "host", "by stage", whole]
    return {name: found[name] for name in order if name in found}


# The run


def run_laps(benches: dict[str, Bench], repeat: int) -> None:
    """Run the laps of all thread counts in turn, so that a busy moment of the machine affects all of them."""
    for bench in benches.values():
        bench.warm_up()
    for _ in range(repeat):
        for bench in benches.values():
            bench.lap()


def report(whole: str, results: dict[str, dict[str, Statistics]]) -> str:
    """Return a table with a row per stage: median, min, spread and CPU time in ms, and ratios to the first column."""
    first, *others = results
    header = [f"{whole}, ms"]
    for label in results:
        header += [label, "min", "spread", "CPU"]
    header += [f"{label} / {first}" for label in others]
    rows = []
    for name, base in results[first].items():
        cells = [f"{1e3 * value:.2f}" for result in results.values() for value in _values(result[name])]
        ratios = [f"{results[label][name].median / base.median:.2f}" for label in others]
        rows.append([name, *cells, *ratios])
    return markdown_table(header, rows)


def _values(row: Statistics) -> tuple[float, float, float, float]:
    return row.median, row.minimum, row.spread, row.cpu_median


@click.command()
@click.option("--image", type=click.Path(exists=True, dir_okay=False, path_type=Path), help="Photo [coffee.png].")
@click.option("--curves", default=1024, show_default=True)
@click.option("--threads", callback=comma_separated_counts, default="1,2", show_default=True, help="CPU thread counts.")
@click.option("--device", default="cpu", show_default=True, help="cpu, cuda or cuda:K.")
@click.option("--fit-iterations", default=300, show_default=True, help="Iterations of the fit that makes the scene.")
@click.option("--scene", help=f"Scene to measure: a scene file fitted to --image, or {', '.join(SCENES)}.")
@click.option(
    "--photos", default=Path("kodak"), show_default=True, type=click.Path(path_type=Path), help="Kodak set folder."
)
@click.option("--repeat", type=click.IntRange(min=1), default=30, show_default=True, help="Number of laps.")
@click.option("--diffvg", default="pydiffvg", show_default=True, help="Module with the interface of DiffVG.")
@click.option("--cache", type=click.Path(path_type=Path), default=default_cache, help="Folder of the fitted scenes.")
@settings_option
def main(
    image: Path | None,
    curves: int,
    threads: list[int],
    device: str,
    fit_iterations: int,
    scene: str | None,
    photos: Path,
    repeat: int,
    diffvg: str,
    cache: Path,
    assignments: tuple[str, ...],
) -> None:
    """Time one step of the fit, and a plain render, by stage."""
    torch.set_num_threads(1)  # as the fit does
    settings = parse_settings(assignments)
    try:
        where = resolve_device(device)
        facts = machine_facts(where)  # before the run adds to the load
        if scene in SCENES:
            subject = named_subject(scene, photos, cache, settings)
        else:
            config = make_config(**{"curves": curves, "iterations": fit_iterations, **settings})
            subject = photo_subject(image or sample_photo(cache), config, cache, scene_file(scene))
    except InputError as error:
        raise click.UsageError(str(error)) from error
    measured = load_scene(subject.path)
    with torch.no_grad():
        benches = _benches(subject.target, measured, subject.config, where, threads)
        run_laps(benches, repeat)
    height, width = subject.target.shape[:2]
    rivals = [
        time_resvg(measured, height, width, max(1, repeat // 5)),
        time_diffvg(diffvg, measured, subject.target.to(where)),
    ]
    _print(benches, rivals, {**facts, "scene": subject.path.name, "size": f"{width} x {height}"}, where)


def _benches(
    target: torch.Tensor, scene: Scene, config: FitConfig, device: str, threads: list[int]
) -> dict[str, Bench]:
    """Return a bench by the label of its column: one for each thread count, or one for a GPU."""
    columns = {device: None} if device != "cpu" else {f"{count} thr.": count for count in threads}
    still = replace(config, lr_scale=0.0)
    return {label: Bench(target, scene, replace(still, threads=count), device) for label, count in columns.items()}


def _print(benches: dict[str, Bench], rivals: list[Rival], facts: dict[str, Any], device: str) -> None:
    results = {label: bench.results() for label, bench in benches.items()}
    counts = next(iter(benches.values())).counts
    for whole in WHOLES:
        click.echo(report(whole, {label: result[whole] for label, result in results.items()}) + "\n")
    for label, bench in benches.items():
        click.echo(_report_limits(label, bench, results[label]["step"], device))
    wholes = ({label: result[whole][whole] for label, result in results.items()} for whole in ("step", "render"))
    click.echo(report_rivals(rivals, *wholes) + "\n")
    click.echo(", ".join(f"{count} {name}" for name, count in counts.items()))
    click.echo(machine_line(facts))
    others = [rival.to_dict() for rival in rivals]
    line = {"bench": "step", **facts, "counts": counts, "rivals": others, "ms": results}
    click.echo(json.dumps(line, default=Statistics.milliseconds))


def _report_limits(label: str, bench: Bench, rows: dict[str, Statistics], device: str) -> str:
    """Compare each stage with its ideal time, known for one CPU thread only, and with the roof of the machine."""
    fit = bench._fit
    if fit._config.renderer != "exact":
        return ""
    work = work_of_step(fit._target._renderer, fit._population.scene)
    roof = measure_roof(device, fit._config.threads or 1)
    roofline = report_roofline(work, fit._image[..., 0].numel(), rows, roof, f"step, {label}")
    return "\n\n".join([*([report_ideal(work, rows)] if label == "1 thr." else []), roofline]) + "\n"


if __name__ == "__main__":
    main()
