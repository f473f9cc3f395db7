"""Models of a path: number and degree of its curves, and its first shape in a fit."""

from __future__ import annotations

from typing import Protocol

from torch import Tensor

from warpvec.config import rooms
from warpvec.config.fit_config import FitConfig
from warpvec.fit.regularization import Regularization
from warpvec.geometry.circles import circle_points
from warpvec.geometry.scene import Scene


class Regularizer(Protocol):
    """The regularizers of the paths of one fit.

    Attributes:
        can_record: whether a graph can record them.
    """

    can_record: bool

    def add_adjoint(
        self, scene: Scene, adj_segments: Tensor, adj_opacity: Tensor, counts: Tensor | None = None
    ) -> None:
        """Add their dL/dsegments [R, M, 2] and dL/dopacity [N], in place.

        ``counts`` [1] (int32), on the device, is the number of paths that there are, if the scene has room for more.
        """


class PathModel(Protocol):
    """The shape of the paths of a fit with some settings."""

    def __init__(self, config: FitConfig) -> None: ...

    @property
    def degree(self) -> int:
        """Degree of the curves between the control points."""

    @property
    def piece_count(self) -> int:
        """Number of curves of a path."""

    def circles(self, center: Tensor, radius: Tensor) -> Tensor:
        """Return the control points [N, P, 2] of circles with these centres [N, 2] and radii [N]."""

    def regularizer(self, height: int, width: int, config: FitConfig, device: str) -> Regularizer:
        """Return the regularizers of paths on a canvas [height, width] with the weights of ``config``."""


class Segments:
    """A path is a loop of cubics."""

    degree = 3

    def __init__(self, config: FitConfig) -> None:
        self.piece_count = config.segments

    def circles(self, center: Tensor, radius: Tensor) -> Tensor:
        """Return the control points [N, 3 S, 2] of circles."""
        return circle_points(center, radius, self.piece_count)

    def regularizer(self, height: int, width: int, config: FitConfig, device: str) -> Regularizer:
        """Return the regularizers of cubics."""
        return Regularization(height, width, config, device)


def path_model(config: FitConfig) -> PathModel:
    """Return the model of the paths of a fit with ``config``."""
    make = Segments if config.path_model == "segments" else rooms.load("path_models", config.path_model)
    model: PathModel = make(config)
    return model
