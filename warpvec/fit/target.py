"""The image that a fit compares its scene with, and the renderer that draws the scene."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial, reduce
from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor
from torch.nn.functional import avg_pool2d

from warpvec.config.fit_config import FitConfig
from warpvec.fit.path_models import path_model
from warpvec.fit.similarity import Similarity
from warpvec.geometry.gradients import Gradients
from warpvec.geometry.paints.registry import LINEAR
from warpvec.geometry.scene import Scene
from warpvec.image.alpha import ALPHA_MIN, MATTES, is_transparent, over, premultiplied
from warpvec.image.gaussian_blur import GaussianBlur
from warpvec.rendering.capacity import Counts
from warpvec.rendering.exact import ExactRenderer
from warpvec.rendering.graph import RecordedStep
from warpvec.rendering.outline_adjoint import OutlineAdjoint
from warpvec.rendering.registry import make_renderer
from warpvec.rendering.stages.compositing import from_tiles
from warpvec.rendering.stages.pixel_slopes import HitSlopes
from warpvec.rendering.tile_renderer import Adjoints, TileRenderer, mean_adjoints

CHORDS_A_SEGMENT, STRIPS_A_PATH = 36, 9
PAIRS_A_TILE, PAIRS_A_PATH = 16, 16
SLOTS_A_TILE, SLOTS_A_PATH = 8, 12
"""What a graph has room for at least, so that it need not be recorded again while paths are added: twice the most of
fits of 512 and 1024 paths to kodim07 at 768 x 512, of 1024 at 384 x 256, and of 128 at 192 x 128."""


class OutlineStep(NamedTuple):
    """The adjoint of the outlines of a scene, and how strongly its paths show, on the CPU.

    Attributes:
        adjoint: dL/d(edges).
        contrast: half of the second derivative of the loss by the opacity of each path, times the square of its
            opacity [N]: the sum of c^2 / (3 h w) over the pixels of the path, which the path changes by c.
    """

    adjoint: OutlineAdjoint
    contrast: Tensor


class Target:
    """An image [h, w, 3 or 4] on ``device``, with a renderer of its size.

    An image with (straight) alpha is compared over a black and over a white matte, which take the place of the scene's
    background. One renderer draws both; on the CPU it covers the paths once for them. The opacity that paths need
    follows from the two together: the more a path lets through, the more its pixels differ between the mattes.

    If the image is blurred, scenes are blurred as it is before both are compared, so that the scene that explains it is
    sharp. Renders and areas are those of the sharp scene.

    Attributes:
        device: where the image is.
        blur: how scenes are blurred; None for not at all.
        fits: [1] float64 on the device, or None where every step fits. It is 1, or -1 from the first step on that
            exceeded the renderer's capacity until :meth:`make_room`. Paths and optimizer state must then not change:
            the adjoints of such a step are zero.
    """

    def __init__(self, image: Tensor, config: FitConfig, device: str, blur: float = 0.0) -> None:
        """Compare scenes with ``image``, whose blur has this standard deviation in pixels."""
        self.device = device
        self._path_count = config.curves
        self.blur = GaussianBlur(blur) if blur > 0.0 else None
        self._views = list(_views(image.to(device, torch.float32)))
        height, width = image.shape[:2]
        self._renderer = make_renderer(
            height=height, width=width, device=device, degree=path_model(config).degree, **config.render_settings
        )
        self._prepared = [(self._renderer.prepare_target(pixels), matte) for pixels, matte in self._views]
        for prepared, _ in self._prepared:
            self._renderer.measure_target(prepared)
        # What the views are compared with; with `follow` not the views themselves.
        self._aims = [pixels for pixels, _ in self._views]
        self._similarities: list[Similarity] = []
        self._is_shiftable = False
        self._costs: Adjoints | None = None
        self._tiles: Tensor | None = None
        self._steps = [RecordedStep(self._renderer) for _ in self._views]
        self._least = least_counts(self._renderer.grid.count, config.curves, config.segments)
        self.error_scale = 1.0 / (3 * height * width)
        may_drop = any(step.may_drop for step in self._steps)
        self.fits = torch.ones_like(self._renderer.fits) if may_drop else None
        if may_drop and config.ssim_weight > 0.0 and not config.lod:
            self._make_shiftable()  # later the target would lie in other memory, and a graph be recorded again

    def fit_step(self, scene: Scene, want_removal_cost: bool) -> Adjoints:
        """Return the loss (mean squared error) of ``scene``, its adjoints and, on request, each path's removal cost.

        The next step overwrites the memory of all but the loss. If the image is blurred, the quadratic part of a
        removal cost is that of a sharp one.
        """
        if self._views[0][1] is not None and self.fits is None and self.blur is None:
            return self._renderer.mean_fit_step(scene, self._mattes(), want_removal_cost)
        return _mean_adjoints([self._take(view, scene, want_removal_cost) for view in range(len(self._views))])

    def removal_step(self, padded: Scene, live: Scene) -> Adjoints:
        """Return what `fit_step` does of the paths ``live``, with removal costs, by a graph if there is one.

        They lie in the memory of ``padded``, which has room for more. The next such step overwrites all but the loss.
        """
        assert self.fits is not None  # else there is no such memory
        if self._costs is None or self._costs.segments.shape != padded.segments.shape:
            kept = self._renderer.make_adjoints(padded)
            self._costs = replace(kept, removal_cost=torch.empty_like(kept.opacity))
        prepared = self._prepared[0][0]
        step = partial(self._renderer.fit_step, padded, prepared, True, self._costs)
        adjoints = _mean_adjoints([self._steps[0].drawn("costs", padded, prepared, step)])
        torch.minimum(self.fits, self._renderer.fits, out=self.fits)
        names = ("color", "opacity", "removal_cost", "side_opacity")
        values = ((name, getattr(adjoints, name)) for name in names)
        found = {name: value[: len(live)] for name, value in values if value is not None}
        return replace(adjoints, segments=adjoints.segments[: live.structure.segment_count], **found)

    def _mattes(self) -> list[tuple[Tensor, Tensor]]:
        return [(prepared, matte) for prepared, matte in self._prepared if matte is not None]

    def removal_costs(self, scene: Scene) -> Tensor:
        """Return how the loss of ``scene`` rises without each path [N]."""
        costs = self.fit_step(scene, True).removal_cost
        assert costs is not None  # they were asked for
        return costs

    def follow(self, scene: Scene, weight: float, padded: Scene | None = None) -> None:
        """Let adjoints, removal costs and errors of the next steps contain 1 - SSIM of ``scene``.

        ``padded`` is memory with the same paths, of which there may be a graph. The term has ``weight`` times the mean
        squared error; see `warpvec.fit.similarity`. The loss that steps return is still the mean squared error.
        """
        if not self._similarities:
            self._similarities = [Similarity(pixels, self._path_count) for pixels, _ in self._views]
            if not self._is_shiftable:
                self._make_shiftable()
        images = self._images(scene, padded)
        for view, (image, similarity) in enumerate(zip(images, self._similarities, strict=True)):
            pixels, _ = self._views[view]
            shift = similarity.shift(image, weight * (image - pixels).square().mean())
            self._renderer.change_shift(self._prepared[view][0], shift)
            self._aims[view] = pixels + shift[..., None]

    def _make_shiftable(self) -> None:
        """Give the prepared targets a shift of zero."""
        blank = torch.zeros_like(self._views[0][0][..., 0])
        self._prepared = [(self._renderer.prepare_target(pixels, blank), matte) for pixels, matte in self._views]
        self._is_shiftable = True

    @property
    def can_chain(self) -> bool:
        """Whether steps can follow each other as one graph: there is one view, and a graph can be recorded."""
        return self.fits is not None and len(self._views) == 1 and self._views[0][1] is None and self.blur is None

    @property
    def step_fits(self) -> Tensor:
        """[1] float64 on the device: 1, or -1 if the last drawing exceeded the renderer's capacity."""
        return self._renderer.fits

    def chained_step(self, scene: Scene, after: Callable[[Adjoints], None]) -> Adjoints:
        """Take a step like `fit_step` of a scene with room in its memory, and do with it what comes ``after``.

        A graph contains both, and `fits` is left to ``after``. The next step overwrites the adjoints.
        """
        return self._steps[0].take(scene, self._prepared[0][0], after=after, least=self._least)

    def has_chain(self, scene: Scene) -> bool:
        """Return whether `chained_step` of ``scene`` would be a replay of a graph."""
        return self._steps[0].has_recorded(scene, self._prepared[0][0])

    def outline_step(self, scene: Scene) -> tuple[Adjoints, OutlineStep]:
        """Return the adjoints of `fit_step` with removal costs, and figures along the outlines of ``scene``.

        Only the exact renderer can.
        """
        parts, outlines = [], []
        for view in range(len(self._views)):
            parts.append(self._take(view, scene, True, want_outlines=True))
            outlines.append(self._exact.outline_adjoint(scene))
        adjoints = _mean_adjoints(parts)
        contrast = adjoints.contrast(scene.opacity)
        outline = OutlineStep(reduce(OutlineAdjoint.averaged, outlines), contrast.cpu().double())
        return adjoints, outline

    def _take(self, view: int, scene: Scene, want_removal_cost: bool, want_outlines: bool = False) -> Adjoints:
        prepared, matte = self._prepared[view]
        shown = _over(scene, matte)
        if self.blur is None:
            step = partial(self._steps[view].take, shown, prepared, want_removal_cost)
            # No graph has removal costs, but its capacity will do. Figures along outlines need the step's counts.
            is_bounded = want_removal_cost and not want_outlines
            adjoints = self._steps[view].within(step) if is_bounded else step()
        else:
            pixels = self._views[view][0]
            adjoints = blurred_step(self._renderer, shown, pixels, self.blur, want_removal_cost)
        if self.fits is not None:  # the renderer tells of its last drawing only
            torch.minimum(self.fits, self._renderer.fits, out=self.fits)
        return adjoints

    def has_dropped(self) -> bool:
        """Return whether a step has exceeded the capacity since the last :meth:`make_room`; waits for the device."""
        return self.fits is not None and float(self.fits) < 0.0

    def make_room(self) -> None:
        """Give the next steps a capacity for the present paths."""
        if self.fits is not None:
            self.fits.fill_(1.0)
        for step in self._steps:
            step.forget()

    def pause_recording(self, is_paused: bool) -> None:
        """Launch each kernel of the next steps by itself, or replay recorded graphs again.

        ``bench/bench_step.py`` needs this: the stages of a graph cannot be timed one by one.
        """
        for step in self._steps:
            step.is_paused = is_paused

    def visible_areas(self, scene: Scene) -> Tensor:
        """Measure the visible area of each path and, last, of the canvas [N + 1], in pixels.

        This is the sum over the pixels of coverage, opacity, and the transmittance of everything above.
        """
        ones = torch.ones_like(self._views[0][0])
        adjoints = self._renderer.adjoint(scene, ones)
        return torch.cat([adjoints.whole_color[:, 0], adjoints.background[:1]])

    def whole_step(self, scene: Scene) -> Adjoints:
        """Return what `fit_step` does, with all paths: it is repeated if a GPU had no room for them."""
        adjoints = self.fit_step(scene, False)
        if self.has_dropped():
            self.make_room()
            adjoints = self.fit_step(scene, False)
        return adjoints

    def random_adjoints(self, scene: Scene, generator: torch.Generator, count: int) -> Iterator[Adjoints]:
        """Yield the adjoints of ``scene`` for ``count`` images of random signs, over each matte if there are any.

        They are scaled so that the sum of their squares over the mattes is, like the loss, a mean over these.
        """
        return self._renderer.adjoints_over(scene, self._random_views(scene, generator, count))

    def _random_views(self, scene: Scene, generator: torch.Generator, count: int) -> Iterator[tuple[Tensor, Tensor]]:
        shape, share = self._views[0][0].shape, len(self._views) ** -0.5
        for _, matte in count * self._views:
            signs = _random_bits(shape, generator).to(scene.segments).mul_(2.0 * share).sub_(share)
            yield self._renderer.prepare_target(self._blurred(signs)), scene.background if matte is None else matte

    def pixel_slopes(self, scene: Scene) -> Iterator[HitSlopes]:
        """Yield how pixels change with the paints and the windings of the paths of ``scene``, some tiles at a time.

        Only the exact renderer can. If there are mattes, the scene lies over a grey one; see `matte_scale`. Blur
        spreads a change over the pixels around. Here the pixel has a change whose square is the sum of theirs, which is
        good enough for a matrix that steers steps.
        """
        if self._views[0][1] is not None:
            scene = replace(scene, background=torch.full_like(scene.background, sum(MATTES) / 2.0))
        spread = 1.0 if self.blur is None else self.blur.edge_share**0.5
        for part in self._exact.pixel_slopes(scene):
            yield part if self.blur is None else part._replace(slopes=spread * part.slopes)

    @property
    def matte_scale(self) -> float:
        """Factor of the derivatives of transmittance that makes them half of the difference of black and white mattes.

        With it, the sum of the squares of derivatives over the grey matte and of this is their mean over black and
        white. All channels share the difference. It is 0 without mattes.
        """
        return 0.0 if self._views[0][1] is None else 0.5 * 3.0**0.5

    @property
    def _exact(self) -> ExactRenderer:
        assert isinstance(self._renderer, ExactRenderer)
        return self._renderer

    @property
    def size(self) -> tuple[int, int]:
        """Height and width of the image."""
        grid = self._renderer.grid
        return grid.height, grid.width

    def ramp_moments(self, scene: Scene, box: Tensor) -> tuple[Tensor, Tensor]:
        """Measure the moments of each path's visible pixels, for ``warpvec.fit.ramps``.

        With w the visible share of the path in a pixel at (x, y), and g the adjoint of the image in each channel:

        Returns:
            the sums of w g, w g x and w g y for each channel [N, 3, 3], and
            the sums of w, w x, w y, w x x, w x y, w y x and w y y [N, 7].
        """
        residual = self._residual(scene)
        height, width = residual.shape[:2]
        rows, columns = (torch.arange(n, dtype=residual.dtype, device=residual.device) + 0.5 for n in (height, width))
        places = torch.stack([torch.ones_like(residual[..., 0]), *torch.meshgrid(columns, rows, indexing="xy")], -1)
        sums = [[self._shares(scene, box, axis, image) for axis in (0, 1)] for image in (residual, places)]
        (gx, gy), (px, py) = sums
        first = torch.stack([gx[0], gx[1], gy[1]], 2)
        second = torch.stack([px[0][:, 0], px[0][:, 1], px[0][:, 2], *px[1][:, 1:].T, *py[1][:, 1:].T], 1)
        return first, second

    def _shares(self, scene: Scene, box: Tensor, axis: int, adj_image: Tensor) -> tuple[Tensor, Tensor]:
        """Return the sums of w g and of w g x (``axis`` 0) or w g y (1) for g = ``adj_image`` [h, w, 3]: [N, 3] each.

        The renderer gives them as the adjoints of the two colours of a gradient across the ``box`` [N, 4] of a path.
        """
        low, high = box[:, axis] - 1.0, box[:, axis + 2] + 1.0
        zero = torch.zeros_like(low)
        geometry = torch.stack([low, zero, high, zero] if axis == 0 else [zero, low, zero, high], 1)
        kind = torch.full((len(scene),), LINEAR, dtype=torch.int32, device=box.device)
        probe = replace(scene, gradients=Gradients(kind, geometry.contiguous(), scene.color.clone()))
        adjoints = self._renderer.adjoint(probe, adj_image)
        assert adjoints.end_color is not None
        total = adjoints.whole_color
        return total, low[:, None] * total + (high - low)[:, None] * adjoints.end_color

    def _residual(self, scene: Scene) -> Tensor:
        """Return dL/d(image) [h, w, 3] of the loss, averaged over the mattes."""
        return torch.stack([2.0 * self.error_scale * self._blurred(each) for each in self._differences(scene)]).mean(0)

    def squared_error(self, scene: Scene, padded: Scene | None = None) -> Tensor:
        """Return the squared error of ``scene`` in each pixel [h, w], summed over the channels.

        With :meth:`follow` it is the square of what the adjoint is proportional to: it tells where the loss can fall.
        ``padded`` is memory with the same paths, of which there may be a graph.
        """
        if padded is not None and not self._similarities:
            return self._renderer.error_of([self._prepared[0][0]], [self._picture(padded).clone()])
        if self.blur is None and not self._similarities:
            views = [(each, scene.background if matte is None else matte) for each, matte in self._prepared]
            return self._steps[0].within(lambda: self._renderer.squared_error(scene, views))
        return torch.stack([each.square().sum(-1) for each in self._differences(scene, padded)]).mean(0)

    def _differences(self, scene: Scene, padded: Scene | None = None) -> Iterator[Tensor]:
        """Yield ``scene``, over each matte if there are any, less what it is compared with [h, w, 3]."""
        for aim, image in zip(self._aims, self._images(scene, padded), strict=True):
            yield self._blurred(image) - aim

    def _images(self, scene: Scene, padded: Scene | None) -> list[Tensor]:
        """Return ``scene`` [h, w, 3], over each matte if there are any."""
        if padded is not None:
            return [from_tiles(self._picture(padded), self._renderer.grid)]
        backgrounds = [scene.background if matte is None else matte for _, matte in self._views]
        return self._steps[0].within(lambda: list(self._renderer.render_over(scene, backgrounds)))

    def _picture(self, padded: Scene) -> Tensor:
        """Return ``padded`` in tiles, by a graph if there is one; the next picture overwrites it."""
        if self._tiles is None:
            self._tiles = self._renderer.make_tiles()
        draw = partial(self._renderer.draw_tiles, padded, self._tiles)
        return self._steps[0].drawn("picture", padded, self._prepared[0][0], draw)

    def _blurred(self, image: Tensor) -> Tensor:
        return image if self.blur is None else self.blur(image)


def least_counts(tile_count: int, path_count: int, segment_count: int) -> Counts:
    """Return a capacity that fits of so many paths, of so many segments each, on so many tiles hardly exceed."""
    pairs = PAIRS_A_TILE * tile_count + PAIRS_A_PATH * path_count
    slots = SLOTS_A_TILE * tile_count + SLOTS_A_PATH * path_count
    return Counts(CHORDS_A_SEGMENT * segment_count * path_count, STRIPS_A_PATH * path_count, pairs, slots)


def _random_bits(shape: torch.Size, generator: torch.Generator) -> Tensor:
    """Return random numbers of 0 and 1 [*shape] (uint8), eight from each number of the ``generator``."""
    count = shape.numel()
    eights = torch.randint(0, 256, (-(-count // 8),), generator=generator, dtype=torch.uint8)
    return torch.from_numpy(np.unpackbits(eights.numpy())[:count]).view(shape)


def blurred_step(
    renderer: TileRenderer, scene: Scene, pixels: Tensor, blur: GaussianBlur, want_removal_cost: bool = False
) -> Adjoints:
    """Return the mean squared error of ``scene``, blurred, against ``pixels`` [h, w, 3], and its adjoints.

    With B for the blur, the error (B f - p)^2 of the image f has the adjoint 2 B (B f - p), because B is symmetric. It
    is that of the squared error against f - B (B f - p), which a step of ``renderer`` takes.
    """
    image = renderer.render(scene)
    rest = blur(image) - pixels
    adjoints = renderer.fit_step(scene, renderer.prepare_target(image - blur(rest)), want_removal_cost)
    loss = rest.square().mean(dtype=torch.float64).to(adjoints.canvas_sums)
    return replace(adjoints, canvas_sums=torch.cat([adjoints.canvas_sums[:3], loss[None]]))


def _over(scene: Scene, matte: Tensor | None) -> Scene:
    """Return ``scene`` with the background ``matte`` [3], or with its own if that is None."""
    return scene if matte is None else replace(scene, background=matte)


def blank_error(image: Tensor, background: Tensor) -> Tensor:
    """Return the squared error [h, w] of an empty canvas in the colour ``background`` [3].

    If ``image`` has alpha, the canvas shows the mattes instead.
    """
    errors = [(pixels - (background if matte is None else matte)).square().sum(-1) for pixels, matte in _views(image)]
    return torch.stack(errors).mean(0)


def opaque_colors(image: Tensor) -> Tensor:
    """Return the colours [h, w, 3] of ``image`` [h, w, 3 or 4]; transparent pixels take those of their surroundings."""
    if not is_transparent(image):
        return image
    return _filled_colors(premultiplied(image) * (image[..., 3:] >= ALPHA_MIN))


def _views(image: Tensor) -> Iterator[tuple[Tensor, Tensor | None]]:
    """Yield the pixels [h, w, 3] to compare with, and the colour [3] of their matte.

    There is one view without a matte if ``image`` is opaque, and one for each matte if it has alpha.
    """
    if not is_transparent(image):
        yield image, None
        return
    for matte in MATTES:
        yield over(image, matte), image.new_full((3,), matte)


def _mean_adjoints(adjoints: list[Adjoints]) -> Adjoints:
    """Return the mean of ``adjoints``; the next step leaves its loss alone."""
    if len(adjoints) == 1:
        return replace(adjoints[0], canvas_sums=adjoints[0].canvas_sums.clone())
    return mean_adjoints(adjoints)


def _filled_colors(image: Tensor) -> Tensor:
    """Return straight colours of ``image`` [h, w, 4], which is premultiplied; fill gaps from the image at half size."""
    alpha = image[..., 3:]
    color = (image[..., :3] / alpha).nan_to_num(0.0)
    if bool((alpha > 0.0).all()) or alpha.numel() == 1:
        return color
    around = _filled_colors(halved(image)).repeat_interleave(2, 0).repeat_interleave(2, 1)
    return torch.where(alpha > 0.0, color, around[: image.shape[0], : image.shape[1]])


def halved(image: Tensor) -> Tensor:
    """Average ``image`` [h, w, c] over squares of 2x2 pixels; squares at the right and bottom edge may be cut."""
    planes = avg_pool2d(image.permute(2, 0, 1)[None], 2, ceil_mode=True, count_include_pad=False)
    return planes[0].permute(1, 2, 0).contiguous()
