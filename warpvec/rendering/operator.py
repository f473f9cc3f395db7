"""The bridge: a renderer as a differentiable torch operator. Nothing but the bridge lives here.

It is registered as a custom operator, so ``torch.compile(fullgraph=True)`` takes it, and its backward pass is an
operator of its own: the hand-written adjoint, which renders again from the inputs and saves nothing in between.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, lru_cache
from threading import Lock
from typing import Any

import torch
import warp as wp
from torch import Tensor

from warpvec.checks import check_count
from warpvec.config.renderers import check_renderer_settings
from warpvec.errors import InputError
from warpvec.geometry.scene import Scene
from warpvec.image.alpha import MATTES
from warpvec.rendering.launch import start_warp
from warpvec.rendering.registry import make_renderer
from warpvec.rendering.tile_renderer import Adjoints

# A renderer holds buffers for its canvas; a handful serves a user who alternates between sizes.
_RENDERERS_KEPT = 4
# Renderers reuse their buffers from call to call, so calls take turns.
_lock = Lock()

_OPERATOR: dict[str, Any] = {"mutates_args": ()}
# A render reads counts back to size its buffers, which no CUDA graph can record. Torch before 2.9 cannot be told.
if hasattr(torch.Tag, "cudagraph_unsafe"):
    _OPERATOR["tags"] = (torch.Tag.cudagraph_unsafe,)


def render(
    scene: Scene,
    height: int,
    width: int,
    *,
    renderer: str = "exact",
    alpha: bool = False,
    threads: int | None = None,
    **settings: Any,
) -> Tensor:
    """The image [height, width, 3] of ``scene``, differentiable in its points, colour, opacity and background.

    With ``alpha`` it is that of the paths alone, without the background, [height, width, 4]: premultiplied colours, and
    alpha, which is 1 less the transmittance of all paths. `warpvec.image.alpha.straight` takes it to colours as PNGs
    have them.

    Runs where the scene's tensors are, in their precision (float32 or float64), on ``threads`` CPU threads (all
    cores if None). Colours are sRGB-encoded and blended as they stand, as SVG viewers do. A path that is not finite
    is not drawn and gets a zero gradient. ``settings`` are those of the renderer: none for "exact", which draws cubics
    only; ``samples``, ``lines``, ``interior_gradient`` and ``covariance_gradient`` of `warpvec.FitConfig` for "splat".

    Raises:
        InputError: no such renderer or setting of it, a degree that it does not draw, an empty canvas, fewer than one
            thread, or tensors of several dtypes or devices, or of one that has no renderer.
    """
    return _image(_render, scene, height, width, renderer, alpha, threads, settings)


def draw(
    scene: Scene,
    height: int,
    width: int,
    *,
    renderer: str = "exact",
    alpha: bool = False,
    threads: int | None = None,
    **settings: Any,
) -> Tensor:
    """The image of `render` without its gradient: the first call of an operator of torch's takes half a second."""
    with torch.no_grad():
        return _image(_draw, scene, height, width, renderer, alpha, threads, settings)


def draw_adjoint(
    scene: Scene, adj_image: Tensor, *, renderer: str = "exact", threads: int | None = None, **settings: Any
) -> Adjoints:
    """The adjoints of ``scene`` for ``adj_image`` = dL/d(image) [h, w, 3]: what `render` gives autograd, without it."""
    _check_kinds(_inputs(scene))
    thread_count = 0 if threads is None else check_count("threads", threads, 1)
    text = _as_text(renderer, scene.degree, settings)
    with torch.no_grad():
        return _draw_adjoint(*_inputs(scene), adj_image, renderer, thread_count, text)


def _inputs(scene: Scene) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    return scene.points, scene.color, scene.opacity, scene.background


def _image(
    operator: Callable[..., Tensor],
    scene: Scene,
    height: int,
    width: int,
    renderer: str,
    alpha: bool,
    threads: int | None,
    settings: dict[str, Any],
) -> Tensor:
    height, width = check_count("height", height, 1), check_count("width", width, 1)
    thread_count = 0 if threads is None else check_count("threads", threads, 1)
    inputs = _inputs(scene)
    _check_kinds(inputs)
    drawn_by = (height, width, renderer, thread_count, _as_text(renderer, scene.degree, settings))
    if not alpha:
        return operator(*inputs, *drawn_by)
    black, white = (operator(*inputs[:3], torch.full_like(inputs[3], page), *drawn_by) for page in MATTES)
    return torch.cat([black, 1.0 - (white - black).mean(-1, keepdim=True)], -1)


def _as_text(renderer: str, degree: int, settings: dict[str, Any]) -> str:
    """All arguments of the renderer for curves of ``degree`` as JSON: operators take no dictionaries."""
    return json.dumps({**check_renderer_settings(renderer, settings), "degree": degree}, sort_keys=True)


# torch.compile cannot trace it, and guards the arguments. This is all that torch.compiler.assume_constant_result does
# once it has imported the compiler, for half a second.
_as_text._dynamo_marked_constant = True  # type: ignore[attr-defined]


def _check_kinds(inputs: tuple[Tensor, ...]) -> None:
    kinds = {(str(tensor.dtype), str(tensor.device)) for tensor in inputs}
    if len(kinds) > 1 or inputs[0].dtype not in (torch.float32, torch.float64):
        raise InputError(f"scene must hold float32 or float64 tensors on one device, got {sorted(kinds)}; convert them")
    if inputs[0].device.type not in ("cpu", "cuda"):
        raise InputError(f"scene must be on the CPU or a CUDA device, got {inputs[0].device}; move its tensors there")


@contextmanager
def _turn(device: torch.device) -> Iterator[None]:
    """A caller's turn at the renderers; on CUDA, Warp works on torch's current stream for as long."""
    start_warp()
    with _lock:
        stream = _warp_stream(torch.cuda.current_stream(device)) if device.type == "cuda" else None
        # Warp's own stream waits for this one at the end, and this one waited for it at the start: so turns on
        # several streams come one after another on the device too, where they share buffers.
        with wp.ScopedStream(stream, sync_exit=True):
            yield


@cache  # Torch takes its streams from a small pool that lives as long as the process.
def _warp_stream(stream: torch.cuda.Stream) -> Any:
    return wp.stream_from_torch(stream)


@lru_cache(maxsize=_RENDERERS_KEPT)
def _renderer(name: str, height: int, width: int, device: str, dtype: torch.dtype, threads: int, settings: str) -> Any:
    arguments = json.loads(settings)
    return make_renderer(name, height, width, device=device, dtype=dtype, threads=threads or None, **arguments)


def _draw(
    points: Tensor,
    color: Tensor,
    opacity: Tensor,
    background: Tensor,
    height: int,
    width: int,
    renderer: str,
    threads: int,
    settings: str,
) -> Tensor:
    with _turn(points.device):
        stages = _renderer(renderer, height, width, str(points.device), points.dtype, threads, settings)
        image: Tensor = stages.render(points, color, opacity, background)
    return image


@torch.library.custom_op("warpvec::render", **_OPERATOR)
def _render(
    points: Tensor,
    color: Tensor,
    opacity: Tensor,
    background: Tensor,
    height: int,
    width: int,
    renderer: str,
    threads: int,
    settings: str,
) -> Tensor:
    return _draw(points, color, opacity, background, height, width, renderer, threads, settings)


@_render.register_fake
def _(
    points: Tensor,
    color: Tensor,
    opacity: Tensor,
    background: Tensor,
    height: int,
    width: int,
    renderer: str,
    threads: int,
    settings: str,
) -> Tensor:
    return points.new_empty((height, width, 3))


def _draw_adjoint(
    points: Tensor,
    color: Tensor,
    opacity: Tensor,
    background: Tensor,
    adj_image: Tensor,
    renderer: str,
    threads: int,
    settings: str,
) -> Adjoints:
    height, width = adj_image.shape[:2]
    with _turn(points.device):
        stages = _renderer(renderer, height, width, str(points.device), points.dtype, threads, settings)
        adjoints: Adjoints = stages.adjoint(points, color, opacity, background, adj_image)
    return adjoints


@torch.library.custom_op("warpvec::render_adjoint", **_OPERATOR)
def _render_adjoint(
    points: Tensor,
    color: Tensor,
    opacity: Tensor,
    background: Tensor,
    adj_image: Tensor,
    renderer: str,
    threads: int,
    settings: str,
) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    adjoints = _draw_adjoint(points, color, opacity, background, adj_image, renderer, threads, settings)
    # An operator's outputs must not share memory with one another.
    return adjoints.points, adjoints.color.clone(), adjoints.opacity.clone(), adjoints.background.clone()


@_render_adjoint.register_fake
def _(
    points: Tensor,
    color: Tensor,
    opacity: Tensor,
    background: Tensor,
    adj_image: Tensor,
    renderer: str,
    threads: int,
    settings: str,
) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    inputs = (points, color, opacity, background)
    return tuple(torch.empty_like(tensor, memory_format=torch.contiguous_format) for tensor in inputs)  # type: ignore[return-value]


def _setup(ctx: Any, inputs: tuple[Any, ...], output: Tensor) -> None:
    ctx.save_for_backward(*inputs[:4])
    ctx.drawn_by = inputs[6:]


def _backward(ctx: Any, adj_image: Tensor) -> tuple[Any, ...]:
    adjoints = _render_adjoint(*ctx.saved_tensors, adj_image, *ctx.drawn_by)
    return (*adjoints, None, None, None, None, None)


_render.register_autograd(_backward, setup_context=_setup)
