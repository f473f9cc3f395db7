"""A drawing of a picture: the fitted scene, the scene in the file, and figures of the file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import torch
from torch import Tensor

from warpvec.drawing.encoding import Encoding
from warpvec.drawing.file_options import FileOptions
from warpvec.fit.target import Target
from warpvec.fit.visibility import canvas_areas, removal_changes, visible_areas, without_invisible
from warpvec.geometry.cubics import to_cubics
from warpvec.geometry.scene import Scene
from warpvec.svg.measure import draw

if TYPE_CHECKING:  # it loads SciPy, which the fit of a photo does not need
    from warpvec.condition.condition import Condition


@dataclass(frozen=True, eq=False)
class Drawing:
    """A drawing of a picture. `Drawing.of` makes one from the scene of a fit.

    Attributes:
        fitted: the scene of the fit, in pixels of the reduced picture.
        scene: the scene in the file: cubics in pixels of the picture, rounded as the file states them.
        conversion_px: largest distance of the file's cubics from the fitted curves before rounding, in pixels of the
            picture.
        encoding: how the scene becomes a file.
        device: the processor that the fit ran on.
        mode_reason: why the drawing is of this mode; None if a setting decided it.
        left_out: number of parts of the picture or drawing that the file leaves out, by their name.
        roughly: number of parts of the picture that the drawing shows only roughly, by their name; see
            `warpvec.drawing.not_kept`.
        given: text of the file that was refined, if the drawing is this file as it came in.
        start_psnr: PSNR in dB of the file that was refined; None without one.
        line_facts: what a drawing of lines says of them; see `warpvec.modes.lines`. None for other drawings.
        goal_facts: the goal, if there was one, and whether the file meets it; see `warpvec.goals.search`.
        condition: what had happened to the picture; None if nobody looked.
    """

    fitted: Scene
    scene: Scene
    conversion_px: float
    encoding: Encoding
    device: str
    mode_reason: str | None = None
    left_out: dict[str, int] = field(default_factory=dict)
    roughly: dict[str, int] = field(default_factory=dict)
    given: str | None = None
    start_psnr: float | None = None
    line_facts: dict[str, Any] | None = None
    goal_facts: dict[str, Any] | None = None
    condition: Condition | None = None

    @staticmethod
    def of(fitted: Scene, encoding: Encoding, device: str, *, is_late: bool = False, **more: Any) -> Drawing:
        """Return the drawing of the ``fitted`` scene, in pixels of the reduced picture; ``more`` are other attributes.

        Unless the encoding keeps all paths, paths that cannot be seen and paths below ``min_area`` are left out. If the
        time of the run is over, ``is_late``, fewer are looked at.
        """
        cubics, distance = to_cubics(fitted.scaled(*encoding.picture.enlargement))
        scene = encoding.round(cubics)
        if not encoding.keeps_paths:
            scene = _large_paths(_visible_paths(scene, encoding, is_late), encoding)
        return Drawing(fitted, encoding.trim(scene), distance, encoding, device, **more)

    def with_fitted(self, fitted: Scene) -> Drawing:
        """Return the drawing of another ``fitted`` scene, otherwise like this one."""
        made = Drawing.of(fitted, self.encoding, self.device)
        return replace(self, fitted=fitted, scene=made.scene, conversion_px=made.conversion_px, given=None)

    def without(self, count: int) -> Drawing:
        """Return the drawing without the ``count`` paths of lowest removal cost; the others stay as they are."""
        return self.with_fitted(self.fitted.select(self.costly_rows(count)))

    def costly_rows(self, count: int, kept: Tensor | None = None) -> Tensor:
        """Return the paths of the fitted scene but for the ``count`` of lowest removal cost, in order.

        Paths that ``kept`` [N] (bool) marks stay before others.
        """
        encoding = self.encoding
        target = Target(torch.from_numpy(encoding.picture.reduced), encoding.settings, "cpu")
        with torch.no_grad():
            removal_cost = target.removal_costs(self.fitted)
        if kept is not None:
            removal_cost = removal_cost.masked_fill(kept, torch.inf)
        return removal_cost.topk(len(self.fitted) - count).indices.sort().values

    @cached_property
    def text(self) -> str:
        """The text of the SVG."""
        is_as_given = self.given is not None and self.encoding.options.purpose == "web"
        return self.given if self.given is not None and is_as_given else self.encoding.text(self.scene)

    @cached_property
    def replaced(self) -> list[str]:
        """What the file draws by other means for its purpose, in words."""
        return self.encoding.shown(self.scene).words

    @cached_property
    def psnr(self) -> float:
        """PSNR in dB of the file against the picture, as resvg draws it."""
        return self.encoding.text_psnr(self._text_of_all)

    @cached_property
    def psnr_as_fitted(self) -> float:
        """PSNR in dB of the file against what was fitted; see `Encoding.psnr_as_fitted`."""
        is_other = self.encoding.picture.is_damage_undone
        return self.encoding.psnr_as_fitted(self._text_of_all) if is_other else self.psnr

    @property
    def _text_of_all(self) -> str:
        """The text with all that the drawing has: modes and goals judge the drawing, whatever its file is for."""
        if self.encoding.options.purpose == "web":
            return self.text
        options = replace(self.encoding.options, purpose="web")
        return replace(self.encoding, options=options).text(self.scene)


def _visible_paths(scene: Scene, encoding: Encoding, is_late: bool) -> Scene:
    """Return ``scene`` without the paths that change no pixel of the file, as resvg draws it."""
    picture = encoding.picture
    plain = replace(encoding, options=FileOptions(no_metadata=True))

    def draw_pixels(some: Scene) -> bytes:
        return draw(plain.text(some), picture.width, picture.height, transparent=some.transparent).tobytes()

    visible, changes = _areas(visible_areas, scene, encoding), _areas(removal_changes, scene, encoding)
    return without_invisible(scene, visible, changes, draw_pixels, is_late)


def _large_paths(scene: Scene, encoding: Encoding) -> Scene:
    """Return ``scene`` without the paths below the smallest area of the settings."""
    area_min = encoding.settings.min_area
    return scene if area_min == 0 else scene.select(_areas(canvas_areas, scene, encoding) >= area_min)


def _areas(measure: Callable[..., Tensor], scene: Scene, encoding: Encoding) -> Tensor:
    """Return the areas [N] that ``measure`` finds at the size of the fit, in square pixels of the picture."""
    x_factor, y_factor = encoding.picture.reduction
    rows, columns = encoding.picture.reduced_size
    areas = measure(scene.scaled(x_factor, y_factor), rows, columns, encoding.settings.threads)
    return areas / (x_factor * y_factor)
