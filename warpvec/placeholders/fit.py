"""Fit the shapes of a placeholder: add more than fit into the bytes, remove those that matter least, then round.

Everything follows from the image; there are no random numbers.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import torch
from torch import Tensor

from warpvec.placeholders.canvas import BlurredCanvas, Shapes, blur_matrix, rounded

ITERATIONS = 300
"""Steps of the fit, about a second. With 900 it gains 0.05 dB, with 150 it loses 0.2 dB (mean of six photos)."""

GROWTH_END, ADDITIONS = 0.35, 5
"""Share of the iterations in which shapes are added, in so many equal parts."""

REMOVAL_START, REMOVAL_END = 0.4, 0.75
"""Shares of the iterations between which shapes are removed."""

REMOVAL_GAP = 10
"""Iterations between two removals."""

SURPLUS = 1.33
"""Shapes that are added for each that fits in. Without a surplus it loses 0.1 dB; with 1.6 it gains nothing."""

SHAPE_BYTES = 46
"""Bytes of a shape in the data URI, to guess how many fit in."""

ROUNDED_FROM = 0.8
"""Share of the iterations from which the error is that of the rounded shapes."""

RADIUS = 1.2
"""Radius of the first shapes before `RADIUS_FACTOR`, as a share of the longest side over the root of their number."""

RADIUS_FACTOR = 0.8
"""Factor by which each addition shrinks the radius, the first one too."""

RESIDUAL_BLUR = 3.0
"""Standard deviation in units of the blur of the residual, where shapes are added."""

RATES = (0.6, 0.02, 0.02)
"""Rates of corners in units, of colours and of the background. They fall by a cosine to ``RATE_END`` of that."""

RATE_END = 0.02

BETAS = (0.9, 0.98)
"""Decay of the means of the adjoints and of their squares, of Adam (Kingma and Ba, 2015)."""

COST_MIN = 1e-8
"""Removal cost, a mean squared error, of a shape that nobody sees: one level of 255 everywhere would be 1.5e-5."""

OUTSIDE_MAX = 8
"""Units by which a corner may lie outside of the canvas: more would not change the picture, but take more digits."""


def fit_shapes(canvas: BlurredCanvas, max_bytes: int, size_of: Callable[[Shapes], int]) -> Shapes:
    """Return shapes for the target of ``canvas`` whose file has at most ``max_bytes`` bytes.

    Args:
        size_of: returns the bytes of a file with given shapes; more shapes are more bytes.
    """
    fit = _Fit(canvas, max_bytes, size_of)
    for iteration in range(ITERATIONS):
        fit.change(iteration)
        fit.step(iteration)
    fit.shapes = rounded(fit.shapes)
    fit.cut(max_bytes)
    return _without_useless(canvas, fit.shapes)


def _without_useless(canvas: BlurredCanvas, shapes: Shapes) -> Shapes:
    """Remove the shapes that do not lower the error, one after another because equal shapes hide each other."""
    while len(shapes.corners):
        cost = canvas.removal_cost(shapes)
        if float(cost.min()) > COST_MIN:
            break
        rows = torch.arange(len(cost))
        shapes = shapes.select(rows[rows != cost.argmin()])
    return shapes


class _Fit:
    def __init__(self, canvas: BlurredCanvas, max_bytes: int, size_of: Callable[[Shapes], int]) -> None:
        self._canvas, self._max_bytes, self._size_of = canvas, max_bytes, size_of
        background = canvas.target.mean((0, 1))
        self.shapes = Shapes(torch.zeros(0, 4, 2), torch.zeros(0, 3), background)
        self._bytes_before = size_of(self.shapes)
        room = max(1, (max_bytes - self._bytes_before) // SHAPE_BYTES)
        self._count = math.ceil(SURPLUS * room)
        self._radius = RADIUS * max(canvas.height, canvas.width) / math.sqrt(self._count)
        self._residual = canvas.target - background
        # Mean of the adjoint, that of its square, and steps taken, of each of the corners, colours and background.
        self._states = [
            [torch.zeros_like(each), torch.zeros_like(each), torch.zeros(len(each))] for each in self.shapes
        ]

    def change(self, iteration: int) -> None:
        """Add or remove shapes before ``iteration`` if it is time."""
        growth_gap = int(GROWTH_END * ITERATIONS) // ADDITIONS
        turn, start, end = iteration // growth_gap, REMOVAL_START * ITERATIONS, REMOVAL_END * ITERATIONS
        if turn < ADDITIONS and iteration % growth_gap == 0:
            self._add(math.ceil(self._count * (turn + 1) / ADDITIONS) - len(self.shapes.corners))
        elif iteration >= start and iteration % REMOVAL_GAP == 0:
            surplus = (SURPLUS - 1.0) * max(0.0, (end - iteration) / (end - start))
            self.cut(round(self._max_bytes * (1.0 + surplus)))

    def cut(self, max_bytes: int) -> None:
        """Remove the shapes of the lowest removal cost until the file has at most ``max_bytes`` bytes."""
        while (size := self._size_of(self.shapes)) > max_bytes and len(self.shapes.corners):
            each = (size - self._bytes_before) / len(self.shapes.corners)
            count = min(len(self.shapes.corners), max(1, round((size - max_bytes) / each)))
            rows = self._canvas.removal_cost(self.shapes).argsort(stable=True)[count:].sort().values
            self.shapes = self.shapes.select(rows)
            for states in self._states[:2]:
                states[:] = [each[rows] for each in states]

    def step(self, iteration: int) -> None:
        """Take a step of Adam."""
        is_rounded = iteration >= ROUNDED_FROM * ITERATIONS
        adjoints, self._residual = self._canvas.step(rounded(self.shapes) if is_rounded else self.shapes)
        wave = 0.5 * (1.0 + math.cos(math.pi * iteration / ITERATIONS))
        factor = RATE_END + (1.0 - RATE_END) * wave
        for value, adjoint, rate, (mean, square, age) in zip(self.shapes, adjoints, RATES, self._states, strict=True):
            age += 1.0
            shape = (-1,) + (1,) * (value.ndim - 1)
            mean.lerp_(adjoint, 1.0 - BETAS[0])
            square.lerp_(adjoint.square(), 1.0 - BETAS[1])
            unbiased = [
                state / (1.0 - beta**age).view(shape) for state, beta in zip((mean, square), BETAS, strict=True)
            ]
            value -= factor * rate * unbiased[0] / (unbiased[1].sqrt() + 1e-9)
        self.shapes.color.clamp_(0.0, 1.0)
        self.shapes.background.clamp_(0.0, 1.0)
        for axis, side in enumerate((self._canvas.width, self._canvas.height)):
            self.shapes.corners[..., axis].clamp_(-OUTSIDE_MAX, side + OUTSIDE_MAX)

    def _add(self, count: int) -> None:
        """Add ``count`` squares where the residual is largest, in the colours of the target there, on top."""
        self._radius *= RADIUS_FACTOR
        if not count:
            return
        corners, color = _squares_at(self._canvas.target, self._residual, count, self._radius)
        self.shapes = Shapes(
            torch.cat([self.shapes.corners, corners]), torch.cat([self.shapes.color, color]), self.shapes.background
        )
        for states in self._states[:2]:
            states[:] = [torch.cat([each, each.new_zeros(count, *each.shape[1:])]) for each in states]


def _squares_at(target: Tensor, residual: Tensor, count: int, radius: float) -> tuple[Tensor, Tensor]:
    """Return the corners [count, 4, 2] and colours [count, 3] of new squares, whose corners are ``radius`` away."""
    height, width = target.shape[:2]
    error = residual.square().sum(2)
    error = blur_matrix(height, 0, RESIDUAL_BLUR) @ error @ blur_matrix(width, 0, RESIDUAL_BLUR).T
    rows, columns = torch.arange(height, dtype=torch.float32)[:, None], torch.arange(width, dtype=torch.float32)
    angle = 2.0 * math.pi * (torch.arange(4) + 0.5) / 4
    square = radius * torch.stack([angle.cos(), angle.sin()], -1)
    corners, colors = [], []
    for _ in range(count):
        row, column = divmod(int(error.argmax()), width)
        near = torch.exp(-0.5 * ((rows - row).square() + (columns - column).square()) / radius**2)
        corners.append(torch.tensor([column + 0.5, row + 0.5]) + square)
        colors.append((target * near[..., None]).sum((0, 1)) / near.sum())
        error = error * (1.0 - near)
    return torch.stack(corners), torch.stack(colors)
