"""Iterations that follow each other on a GPU without a look from the host: replays of one graph.

The graph draws the paths, differentiates the loss and the regularizers, and takes the optimizer's step. It reads the
number of paths, the factor of the learning rates and the position in a table of these from the device. So adding and
removing paths changes nothing of it, as long as they fit into their arena (``arena.py``).
"""

from __future__ import annotations

from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit import schedule
from warpvec.fit.opacity_columns import OpacityColumns
from warpvec.fit.path_models import Regularizer
from warpvec.fit.population import Population
from warpvec.fit.target import Target
from warpvec.rendering.tile_renderer import Adjoints


def can_chain(config: FitConfig, target: Target, regularizer: Regularizer, has_grid: bool) -> bool:
    """Return whether a fit with ``config`` can have chains: all that an iteration does are launches of kernels."""
    is_plain = not (config.lod or config.colors or config.palette or config.gradients or config.closing_line)
    is_plain = is_plain and not has_grid and config.z_order == "creation" and config.opacity == "free"
    return is_plain and target.can_chain and regularizer.can_record


class Chain:
    """The chains of one fit."""

    def __init__(self, config: FitConfig, target: Target, population: Population, regularizer: Regularizer) -> None:
        self._config, self._target, self._population = config, target, population
        self._regularizer = regularizer
        self._columns = OpacityColumns(target.device)

    def take(self, first: int, count: int, iteration_count: int) -> tuple[Tensor, int]:
        """Take up to ``count`` steps from the iteration ``first`` on, of which 0 is the first.

        Without a graph it is one step, for which the host reads counts. Return the last one's loss, and their number.
        """
        assert self._population.padded is not None
        if self._target.has_chain(self._population.padded):
            return self.run(first, count, iteration_count), count
        return self._follow_each(first, 1, iteration_count), 1

    def run(self, first: int, count: int, iteration_count: int) -> Tensor:
        """Take ``count`` steps from the iteration ``first`` on by replays of the graph; return the last one's loss."""
        return self._follow_each(first, count, iteration_count)

    def _follow_each(self, first: int, count: int, iteration_count: int) -> Tensor:
        iterations = range(first, first + count)
        self._population.begin_chain([schedule.lr_factor(k, self._config, iteration_count) for k in iterations])
        padded = self._population.padded
        assert padded is not None
        for _ in iterations:
            adjoints = self._target.chained_step(padded, self._follow)
        return adjoints.loss.clone()

    def _follow(self, adjoints: Adjoints) -> None:
        """Add the regularizers to the ``adjoints`` of a drawing, and step the paths."""
        population, target = self._population, self._target
        assert population.padded is not None and target.fits is not None
        opacity = self._columns.joined(adjoints.opacity, adjoints.side_opacity)
        self._regularizer.add_adjoint(population.padded, adjoints.segments, opacity, population.counts)
        found = (adjoints.segments, adjoints.color, opacity, adjoints.background)
        population.chained_step(*found, target.step_fits, target.fits)
