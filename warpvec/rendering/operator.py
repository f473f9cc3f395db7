"""The renderers as a differentiable torch operator, ``render``.

It is registered as a custom operator, so ``torch.compile(fullgraph=True)`` accepts it. Its backward pass is an operator
of its own: the hand-written adjoint, which renders again from the inputs instead of saving intermediate results.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache, lru_cache
from threading import Lock
from typing import Any

import torch
import warp as wp
from torch import Tensor

from warpvec.checks import check_count
from warpvec.config.limits import MAX_THREADS
from warpvec.errors import InputError
from warpvec.geometry.gradients import Gradients
from warpvec.geometry.scene import Scene
from warpvec.geometry.side_opacity import SideOpacity
from warpvec.geometry.softness import Softness
from warpvec.geometry.stops import Stops
from warpvec.geometry.strokes import Strokes
from warpvec.geometry.structure import Structure
from warpvec.image.alpha import MATTES
from warpvec.rendering.launch import start_warp
from warpvec.rendering.registry import check_renderer_settings, make_renderer
from warpvec.rendering.tile_renderer import Adjoints

# Number of tensors of a scene that the operator differentiates, which come first.
_VALUES = 13
# A renderer holds buffers for its canvas. A few of them serve a user who alternates between sizes.
_RENDERERS_KEPT = 4
# Renderers reuse their buffers from call to call, so only one call runs at a time.
_lock = Lock()
# A fork waits for the call that is running: the child could not finish it, and would find the lock held for ever.
if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=_lock.acquire, after_in_parent=_lock.release, after_in_child=_lock.release)

_OPERATOR: dict[str, Any] = {"mutates_args": ()}
# A render reads counts back to size its buffers, which a CUDA graph cannot record. Torch has this tag since 2.9.
if hasattr(torch.Tag, "cudagraph_unsafe"):
    _OPERATOR["tags"] = (torch.Tag.cudagraph_unsafe,)


def render(
    scene: Scene,
    height: int = 0,
    width: int = 0,
    *,
    renderer: str = "exact",
    alpha: bool = False,
    threads: int | None = None,
    **settings: Any,
) -> Tensor:
    """Return the image [height, width, 3] of ``scene``, differentiable in every tensor of floating point in it.

    With ``alpha`` return the image [height, width, 4] of the paths alone, without the background: premultiplied
    colours, and alpha, which is 1 minus the transmittance of all paths. `warpvec.image.alpha.straight` converts it to
    straight colours, as PNG files have them.

    The renderer runs on the device of the scene's tensors, in their precision (float32 or float64), on ``threads`` CPU
    threads (all cores if None). Colours are sRGB-encoded and blended without decoding, as SVG viewers do. A path that
    is not finite is not drawn and gets a zero gradient. ``settings`` are those of the renderer: none for "exact", which
    draws cubics only; ``samples``, ``lines``, ``interior_gradient`` and ``covariance_gradient`` of `warpvec.FitConfig`
    for "splat".

    Once this function has been imported, torch runs on one thread in every process that is forked from this one,
    because it would wait there for threads that a fork does not copy. Processes started with the method "spawn" keep
    all threads.

    Raises:
        InputError: the renderer or one of its settings does not exist, or does not draw this degree; the canvas is
            empty; ``threads`` is not from 1 to 4096; or the tensors differ in dtype or device or have one without a
            renderer.
    """
    return _image(_render, scene, height, width, renderer=renderer, alpha=alpha, threads=threads, **settings)


def draw(scene: Scene, height: int, width: int, **options: Any) -> Tensor:
    """Return the image of `render` without a gradient; avoids the half second of a torch operator's first call."""
    with torch.no_grad():
        return _image(_draw, scene, height, width, **options)


def draw_adjoint(
    scene: Scene, adj_image: Tensor, *, renderer: str = "exact", threads: int | None = None, **settings: Any
) -> Adjoints:
    """Return the adjoints of ``scene`` for ``adj_image`` = dL/d(image) [h, w, 3], without autograd."""
    _check_kinds(_inputs(scene)[:_VALUES])
    thread_count = 0 if threads is None else check_count("threads", threads, 1, MAX_THREADS)
    text = _as_text(renderer, scene.degree, settings)
    with torch.no_grad():
        return _adjoints(scene, adj_image, renderer, thread_count, text)


def outline_slopes(scene: Scene, height: int, width: int, threads: int | None = None) -> Tensor:
    """Return how sums over all pixels change with the segments of ``scene``; see `ExactRenderer.outline_slopes`."""
    tensors = _inputs(scene)[:_VALUES]
    _check_kinds(tensors)
    thread_count = 0 if threads is None else check_count("threads", threads, 1, MAX_THREADS)
    device, dtype = scene.segments.device, scene.segments.dtype
    with torch.no_grad(), _turn(device):
        stages = _renderer("exact", height, width, str(device), dtype, thread_count, _as_text("exact", 3, {}))
        found: Tensor = stages.outline_slopes(scene)
    return found


def _inputs(scene: Scene) -> list[Tensor]:
    """Return the tensors of an operator: ``_VALUES`` that it differentiates, the kinds of paint, and the structure.

    Those of gradients, strokes, softness and side opacities are empty in a scene without any, those of stops without
    `Stops`.
    """
    structure, color = scene.structure, scene.color
    gradients = scene.gradients or Gradients.none(color[:0])
    strokes = scene.strokes or Strokes.none(color).map(lambda tensor: tensor[:0])
    values = (scene.segments, color, scene.opacity, scene.background, gradients.end_color, gradients.geometry)
    stops = gradients.stops or Stops.two(color[:0])
    of_stops = (stops.inner_color, stops.offset, stops.opacity, stops.breadth)
    is_open = strokes.cap.new_zeros(0, dtype=torch.bool) if structure.is_open is None else structure.is_open
    looks = (gradients.kind, stops.count, strokes.cap, strokes.join, strokes.miter_limit)
    loops = (structure.loop_first_segment, structure.path_first_loop)
    sigma = color.new_zeros(0) if scene.softness is None else scene.softness.sigma
    sides = color.new_zeros(0, 2) if scene.side_opacity is None else scene.side_opacity.value
    return [*values, strokes.width, *of_stops, sigma, sides, *looks, is_open, *loops]


def _scene(inputs: Sequence[Tensor], segment_count: int) -> Scene:
    """Return the scene of `_inputs`; ``segment_count`` is that of every path of a uniform scene, else 0."""
    segments, color, opacity, background, end_color, geometry, width, *of_stops, sigma, sides = inputs[:_VALUES]
    kind, count, *looks, is_open, loops, paths = inputs[_VALUES:]
    structure = Structure(loops, paths, None, segment_count or None, is_open if len(is_open) else None, check=False)
    stops = None
    if len(count):
        inner_color, offset, stop_opacity, breadth = of_stops
        stops = Stops(count, offset, inner_color, stop_opacity, breadth)
    gradients = Gradients(kind, geometry, end_color, stops) if len(kind) else None
    strokes = Strokes(width, *looks) if len(width) else None
    softness = Softness(sigma) if len(sigma) else None
    generation = torch.zeros_like(opacity, dtype=torch.int64)  # a renderer does not look at it
    return Scene(
        segments, structure, color, opacity, background, generation, gradients=gradients, strokes=strokes,
        softness=softness, side_opacity=SideOpacity(sides) if len(sides) else None,
    )  # fmt: skip


def _image(
    operator: Callable[..., Tensor],
    scene: Scene,
    height: int,
    width: int,
    *,
    renderer: str = "exact",
    alpha: bool = False,
    threads: int | None = None,
    **settings: Any,
) -> Tensor:
    if not isinstance(scene, Scene):
        remedy = "give result.scene, or vectorize the picture first"
        raise InputError("scene", "must be a warpvec.Scene", type(scene).__name__, remedy)
    height, width = check_count("height", height, 1), check_count("width", width, 1)
    thread_count = 0 if threads is None else check_count("threads", threads, 1, MAX_THREADS)
    inputs = _inputs(scene)
    _check_kinds(inputs[:_VALUES])
    segment_count = scene.structure.uniform_count or 0
    drawn_by = (segment_count, height, width, renderer, thread_count, _as_text(renderer, scene.degree, settings))
    if not alpha:
        return operator(inputs, *drawn_by)
    mattes = (torch.full_like(scene.background, matte) for matte in MATTES)
    black, white = (operator([*inputs[:3], matte, *inputs[4:]], *drawn_by) for matte in mattes)
    return torch.cat([black, 1.0 - (white - black).mean(-1, keepdim=True)], -1)


def _as_text(renderer: str, degree: int, settings: dict[str, Any]) -> str:
    """Return the renderer's settings for curves of ``degree`` as JSON, because operators take no dictionaries."""
    return json.dumps({**check_renderer_settings(renderer, settings), "degree": degree}, sort_keys=True)


# torch.compile cannot trace this function. The attribute makes it take the result as constant and guard the arguments.
# torch.compiler.assume_constant_result only sets it as well, after importing the compiler for half a second.
_as_text._dynamo_marked_constant = True  # type: ignore[attr-defined]


def _check_kinds(inputs: Sequence[Tensor]) -> None:
    kinds = {(str(tensor.dtype), str(tensor.device)) for tensor in inputs}
    if len(kinds) > 1 or inputs[0].dtype not in (torch.float32, torch.float64):
        rule = "must hold tensors of one dtype, float32 or float64, on one device"
        raise InputError("scene", rule, str(sorted(kinds)), "convert them")
    if inputs[0].device.type not in ("cpu", "cuda"):
        raise InputError(
            "scene", "must be on the CPU or a CUDA device", str(inputs[0].device), "move its tensors there"
        )


@contextmanager
def _turn(device: torch.device) -> Iterator[None]:
    """Hold the renderers for one call; on CUDA, let Warp work on torch's current stream."""
    start_warp()
    with _lock:
        stream = _stream_to_join(device) if device.type == "cuda" else None
        # This stream waits for Warp's own stream at the start, and Warp's for this one at the end. Calls on different
        # streams share buffers, and so run one after another on the device too.
        with wp.ScopedStream(stream, sync_exit=True):
            yield


def _stream_to_join(device: torch.device) -> Any:
    """Return torch's stream as one of Warp's, or None if torch already works on Warp's own, as it does in a fit."""
    stream = torch.cuda.current_stream(device)
    own = wp.device_from_torch(device).stream
    return None if stream.cuda_stream == own.cuda_stream else _warp_stream(stream)


@cache  # Torch takes its streams from a small pool that lives as long as the process does.
def _warp_stream(stream: torch.cuda.Stream) -> Any:
    return wp.stream_from_torch(stream)


@lru_cache(maxsize=_RENDERERS_KEPT)
def _renderer(name: str, height: int, width: int, device: str, dtype: torch.dtype, threads: int, settings: str) -> Any:
    arguments = json.loads(settings)
    return make_renderer(name, height, width, device=device, dtype=dtype, threads=threads or None, **arguments)


def _draw(
    inputs: Sequence[Tensor], segment_count: int, height: int, width: int, renderer: str, threads: int, settings: str
) -> Tensor:
    device, dtype = inputs[0].device, inputs[0].dtype
    with _turn(device):
        stages = _renderer(renderer, height, width, str(device), dtype, threads, settings)
        image: Tensor = stages.render(_scene(inputs, segment_count))
    return image


_render = torch.library.custom_op("warpvec::render", _draw, **_OPERATOR)


@_render.register_fake
def _(inputs: Sequence[Tensor], segment_count: int, height: int, width: int, *rest: Any) -> Tensor:
    return inputs[0].new_empty((height, width, 3))


def _adjoints(scene: Scene, adj_image: Tensor, renderer: str, threads: int, settings: str) -> Adjoints:
    (height, width), (device, dtype) = adj_image.shape[:2], (scene.segments.device, scene.segments.dtype)
    with _turn(device):
        stages = _renderer(renderer, height, width, str(device), dtype, threads, settings)
        adjoints: Adjoints = stages.adjoint(scene, adj_image)
    return adjoints


@torch.library.custom_op("warpvec::render_adjoint", **_OPERATOR)
def _render_adjoint(
    inputs: Sequence[Tensor], adj_image: Tensor, segment_count: int, renderer: str, threads: int, settings: str
) -> list[Tensor]:
    adjoints = _adjoints(_scene(inputs, segment_count), adj_image, renderer, threads, settings)
    # The outputs of an operator must not share memory with one another.
    paths = [adjoints.segments, adjoints.color.clone(), adjoints.opacity.clone(), adjoints.background.clone()]
    names = ["end_color", "geometry", "width", "inner_color", "offset", "stop_opacity", "breadth", "softness"]
    others = (getattr(adjoints, name) for name in [*names, "side_opacity"])
    empty = (torch.empty_like(each) for each in inputs[4:_VALUES])
    return [*paths, *(none if own is None else own for own, none in zip(others, empty, strict=True))]


@_render_adjoint.register_fake
def _(inputs: Sequence[Tensor], *rest: Any) -> list[Tensor]:
    return [torch.empty_like(tensor, memory_format=torch.contiguous_format) for tensor in inputs[:_VALUES]]


def _setup(ctx: Any, inputs: tuple[Any, ...], output: Tensor) -> None:
    tensors, ctx.segment_count, _, _, *ctx.drawn_by = inputs
    ctx.save_for_backward(*tensors)


def _backward(ctx: Any, adj_image: Tensor) -> tuple[Any, ...]:
    tensors = ctx.saved_tensors
    adjoints = _render_adjoint(tensors, adj_image, ctx.segment_count, *ctx.drawn_by)
    return ([*adjoints, *[None] * (len(tensors) - _VALUES)], *[None] * 6)


_render.register_autograd(_backward, setup_context=_setup)
