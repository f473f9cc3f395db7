"""Compare the predicted values of nodes with the true ones, for photos in the middle of a fit.

A fit is stopped, and its state is fitted on for a few small steps: once as it is, and once for each of many segments
with a new node in the middle. The gain is the difference of the losses. What a node is worth is the rise of the loss
when one cubic replaces the two at it, and what is left of that rise after as many steps. Predictions are those of
`warpvec.fit.node_gains`. It prints rank correlations, and writes an SVG with a plot of each.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import NamedTuple

import click
import torch
from harness import machine_facts, machine_line, markdown_table
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.loop import fit, single_torch_thread
from warpvec.fit.node_exchange import SEGMENTS_MIN
from warpvec.fit.node_gains import merge_costs, node_values
from warpvec.fit.population import Population
from warpvec.fit.target import Target
from warpvec.geometry import nodes
from warpvec.geometry.quick_merge import quick_merges
from warpvec.geometry.scene import Scene
from warpvec.image.picture import reduce_image
from warpvec.image.read import read_image
from warpvec.watch.progress import Progress
from warpvec.watch.watch import Watch

RATE = 0.25
"""Factor of the learning rates at the first step after a change; it falls to 0, so that the last loss is quiet."""

_SIDE, _MARGIN = 320, 48


class Pairs(NamedTuple):
    """Predictions and truths of one kind [K]."""

    name: str
    predicted: Tensor
    true: Tensor

    def rank_correlation(self) -> float:
        """Return Spearman's correlation."""
        ranks = torch.stack([values.argsort().argsort().double() for values in (self.predicted, self.true)])
        return float(torch.corrcoef(ranks)[0, 1])

    def top_share(self, share: float = 0.1) -> float:
        """Return what the best ``share`` by prediction gain, over what the best by truth gain."""
        count = max(1, int(share * len(self.true)))
        return float(self.true[self.predicted.topk(count).indices].sum() / self.true.topk(count).values.sum())


class Case:
    """A fit of ``image`` [h, w, 3] that was stopped, and the losses of changed scenes."""

    def __init__(self, image: Tensor, config: FitConfig, steps: int) -> None:
        self._config, self._steps, self._half_side = config, steps, max(image.shape[:2]) / 2
        self.scene = _half_fitted(image, config)
        self._target = Target(image, config, "cpu")
        adjoints, outline = self._target.outline_step(self.scene)
        self.loss = float(adjoints.loss)
        values, merges = node_values(self.scene.structure, *outline), quick_merges(self.scene)
        self.gain, self.cost = values.gain, merge_costs(values, merges)

    def immediate(self, scene: Scene) -> float:
        """Return the loss of ``scene``."""
        return float(self._target.fit_step(scene, False).loss)

    def fitted(self, scene: Scene) -> float:
        """Return the loss of ``scene`` after a few steps."""
        population = Population(scene, self._config, self._half_side)
        for step in range(self._steps):
            adjoints = self._target.fit_step(population.live, False)
            values = (adjoints.segments, adjoints.color, adjoints.opacity.contiguous(), adjoints.background)
            population.step(*values, RATE * (1.0 - step / self._steps))
        return self.immediate(population.live)


def _half_fitted(image: Tensor, config: FitConfig) -> Scene:
    """Return the paths after half of the iterations."""
    kept = []

    def keep(progress: Progress) -> None:
        if progress.iteration == config.iterations // 2:
            kept.append(progress.scene())

    fit(image, config, Watch(keep, config.time_budget).part())
    return kept[0]


def compare(case: Case, count: int, seed: int) -> list[Pairs]:
    """Return the pairs of ``count`` new nodes and of as many that go, drawn evenly over the ranks of predictions."""
    generator = torch.Generator().manual_seed(seed)
    loop_counts = case.scene.structure.loop_first_segment.long().diff()
    can_go = (loop_counts > SEGMENTS_MIN).repeat_interleave(loop_counts).nonzero().flatten()
    base = case.fitted(case.scene)
    divided = torch.randperm(len(case.gain), generator=generator)[:count]
    gains = [base - case.fitted(nodes.split(case.scene, row[None]).scene) for row in divided]
    dropped = can_go[torch.randperm(len(can_go), generator=generator)[:count]]
    found = quick_merges(case.scene)
    scenes = [
        nodes.merge(case.scene, row[None], found.handles[row][None], found.share[row][None]).scene for row in dropped
    ]
    at_once = [case.immediate(scene) - case.loss for scene in scenes]
    return [
        Pairs("gain of a new node", case.gain[divided], torch.tensor(gains)),
        Pairs("cost of a lost node, at once", case.cost[dropped], torch.tensor(at_once)),
        Pairs("cost of a lost node, fitted", case.cost[dropped], torch.tensor([case.fitted(s) for s in scenes]) - base),
    ]


def plot(all_pairs: list[Pairs]) -> str:
    """Return an SVG of the pairs, both axes logarithmic; values below 1e-4 of the largest are at the edge."""
    parts = []
    for place, pairs in enumerate(all_pairs):
        top = math.log10(max(float(pairs.predicted.max()), float(pairs.true.max()), 1e-12))
        points = []
        for x, y in zip(pairs.predicted.tolist(), pairs.true.tolist(), strict=True):
            across, up = (min(max((math.log10(max(v, 1e-30)) - top + 4.0) / 4.0, 0.0), 1.0) for v in (x, y))
            points.append(f'<circle cx="{_SIDE * across:.1f}" cy="{_SIDE * (1.0 - up):.1f}" r="1.5"/>')
        title = f"{pairs.name}: rank correlation {pairs.rank_correlation():.2f}"
        parts.append(
            f'<g transform="translate({_MARGIN + place * (_SIDE + _MARGIN)},{_MARGIN})"><rect width="{_SIDE}" '
            f'height="{_SIDE}" fill="none" stroke="#888"/><path d="M0 {_SIDE}L{_SIDE} 0" stroke="#ccc"/>'
            f'<text y="-8">{title}</text><text y="{_SIDE + 16}">predicted, 10^{top - 4:.1f} to 10^{top:.1f}; up: true'
            f'</text><g fill="#06c" fill-opacity=".5">{"".join(points)}</g></g>'
        )
    width, height = len(all_pairs) * (_SIDE + _MARGIN) + _MARGIN, _SIDE + 2 * _MARGIN
    head = f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-family="sans-serif"'
    return f'{head} font-size="12"><rect width="{width}" height="{height}" fill="#fff"/>{"".join(parts)}</svg>\n'


@click.command()
@click.argument("image", type=click.Path(exists=True, dir_okay=False))
@click.option("--curves", default=256, show_default=True)
@click.option(
    "--iterations", default=1000, show_default=True, help="Iterations of the fit; its paths are those at half."
)
@click.option("--side", default=384, show_default=True, help="Longest side in pixels of the fitted image.")
@click.option("--count", default=500, show_default=True, help="New nodes, and nodes that go.")
@click.option("--steps", default=20, show_default=True, help="Steps after a change.")
@click.option("--seed", default=0, show_default=True)
@click.option("--out", type=click.Path(dir_okay=False, path_type=Path), help="SVG of the plots.")
def main(
    image: str, curves: int, iterations: int, side: int, count: int, steps: int, seed: int, out: Path | None
) -> None:
    """Compare the predicted values of nodes of a fit of IMAGE with the true ones."""
    config = FitConfig(curves=curves, iterations=iterations, threads=1, mode="photo")
    pixels = torch.from_numpy(reduce_image(read_image(image), side))[..., :3].contiguous()
    with single_torch_thread(), torch.no_grad():
        all_pairs = compare(Case(pixels, config, steps), count, seed)
    rows = [[p.name, len(p.true), f"{p.rank_correlation():.3f}", f"{p.top_share():.2f}"] for p in all_pairs]
    click.echo(markdown_table(("value", "number", "rank correlation", "best tenth over true best"), rows) + "\n")
    click.echo(json.dumps({p.name: round(p.rank_correlation(), 4) for p in all_pairs}))
    click.echo(machine_line(machine_facts()))
    if out is not None:
        out.write_text(plot(all_pairs))


if __name__ == "__main__":
    main()
