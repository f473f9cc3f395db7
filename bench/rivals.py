"""Time other programs on the scene of a benchmark in the same run, so that times can be read as ratios."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from itertools import pairwise
from typing import Any, NamedTuple

import resvg_py
import torch
from harness import Laps, Statistics, markdown_table
from torch import Tensor

from warpvec.geometry.cubics import to_cubics
from warpvec.geometry.scene import Scene
from warpvec.svg.write import write_svg

# DiffVG's own applications use 2 x 2 samples a pixel, and as many at boundaries for the gradient.
_DIFFVG_SAMPLES = 2
_DIFFVG_REPEAT = 3


class Rival(NamedTuple):
    """The time that another program took for a scene, or the reason why it was skipped."""

    name: str
    does: str
    time: Statistics | None
    skipped: str = ""

    def to_dict(self) -> dict[str, Any]:
        """Return the row for JSON, with times in ms."""
        return {"name": self.name, "ms": self.time and self.time.milliseconds(), "skipped": self.skipped or None}


def time_resvg(scene: Scene, height: int, width: int, repeat: int) -> Rival:
    """Time resvg parsing, drawing and PNG-encoding the scene, which is the work of a step's forward half, and more."""
    text = write_svg(to_cubics(scene)[0], width, height)
    action = lambda: resvg_py.svg_to_bytes(text, skip_system_fonts=True)  # noqa: E731
    return Rival("resvg", "parse, draw, encode", _time(action, repeat))


def time_diffvg(module: str, scene: Scene, target: Tensor) -> Rival:
    """Time DiffVG's forward and backward pass of the mean squared error; ``module`` is pydiffvg, or has its interface.

    It is skipped, with the reason, if the import fails, since no package contains it, or if the step fails.
    """
    does = f"forward and backward, {_DIFFVG_SAMPLES}x{_DIFFVG_SAMPLES} samples"
    try:
        library = import_module(module)
    except Exception as error:  # a build for another torch can raise anything
        return Rival("DiffVG", does, None, f"skipped: {module} cannot be imported ({type(error).__name__}: {error})")
    try:
        return Rival("DiffVG", does, _time(diffvg_step(library, scene, target), _DIFFVG_REPEAT, target.device))
    except Exception as error:
        return Rival("DiffVG", does, None, f"skipped: {module} failed ({type(error).__name__}: {error})")


def diffvg_step(library: Any, scene: Scene, target: Tensor) -> Callable[[], Tensor]:
    """Return a function that takes one step without the optimizer and returns the loss.

    The step is that of ``apps/painterly_rendering.py`` in DiffVG. It adds its gradients to those of the points [3 S, 2]
    of each loop and the colours [4] of each path.
    """
    library.set_use_gpu(target.is_cuda)
    cubics = to_cubics(scene.cpu())[0]
    paints = torch.cat([cubics.color, cubics.opacity[:, None]], 1)
    shapes, groups = [], []
    for first, end in pairwise(cubics.structure.loop_first_segment.tolist()):
        inner = torch.full((end - first,), 2, dtype=torch.int32)  # inner control points of each segment
        leaf = cubics.segments[first:end].reshape(-1, 2).clone().requires_grad_()
        shapes.append(library.Path(num_control_points=inner, points=leaf, is_closed=True))
    for (first, end), paint in zip(pairwise(cubics.structure.path_first_loop.tolist()), paints, strict=True):
        ids, fill = torch.arange(first, end), paint.clone().requires_grad_()
        groups.append(library.ShapeGroup(shape_ids=ids, fill_color=fill, use_even_odd_rule=False))
    height, width = target.shape[:2]
    background = cubics.background.to(target)

    def step() -> Tensor:
        arguments = library.RenderFunction.serialize_scene(width, height, shapes, groups)
        samples = (_DIFFVG_SAMPLES, _DIFFVG_SAMPLES)
        drawn = library.RenderFunction.apply(width, height, *samples, 0, None, *arguments)
        alpha = drawn[..., 3:]
        loss = (alpha * drawn[..., :3] + (1.0 - alpha) * background - target).square().mean()
        loss.backward()
        return loss

    return step


def _time(action: Callable[[], object], repeat: int, device: torch.device | str = "cpu") -> Statistics:
    """Time ``action`` after one run that is not counted."""
    action()
    laps = Laps(str(device))
    for _ in range(repeat):
        laps.start()
        laps.time("it", action)
    return laps.statistics()["it"]


def report_rivals(rivals: list[Rival], steps: dict[str, Statistics], renders: dict[str, Statistics]) -> str:
    """Return a table of the rivals' times, and of our step and render as fractions of them."""
    header = ["the same scene", "does", "ms, median"]
    header += [f"{whole} {label} / it" for whole in ("step", "render") for label in steps]
    ours = [*steps.values(), *renders.values()]
    rows = [[rival.name, rival.does, *_cells(rival, ours)] for rival in rivals]
    return markdown_table(header, rows)


def _cells(rival: Rival, ours: list[Statistics]) -> list[str]:
    if rival.time is None:
        return [rival.skipped, *("-" for _ in ours)]
    return [f"{1e3 * rival.time.median:.1f}", *(_share(row.median / rival.time.median) for row in ours)]


def _share(ratio: float) -> str:
    return f"{ratio:.3g}"
