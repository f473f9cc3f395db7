"""Draw black and white art: outline the dark areas in black, and fit what a renderer has drawn."""

from __future__ import annotations

from dataclasses import dataclass, replace

import torch

from warpvec.config.fit_config import FitConfig
from warpvec.drawing.drawing import Drawing
from warpvec.fit.loop import single_torch_thread
from warpvec.flat.constants.curves import CURVES
from warpvec.flat.constants.mono import MONO
from warpvec.flat.drawing import FlatDrawing
from warpvec.flat.mono import MonoTracing, mono_tracing
from warpvec.flat.simplification.critic import Critic
from warpvec.flat.simplification.forms import find_forms
from warpvec.geometry.scene import Scene, over_white
from warpvec.modes.flat import drawn, finished, reduced_settings
from warpvec.modes.request import Request


@dataclass(frozen=True)
class Mono:
    """The mode of black and white art."""

    def draw(self, request: Request) -> Drawing:
        """Return the drawing of black and white art. A goal decides the detail.

        With the default detail the tolerance follows the noise of the picture; else it is proportional to the detail.
        """
        settings, threshold = reduced_settings(request), request.settings.threshold

        def draw(detail: float) -> Drawing:
            tracing = mono_tracing(
                request.picture.reduced,
                "auto" if threshold == "auto" else float(threshold),
                tolerance=None if detail == FitConfig.detail else CURVES.tolerance * detail / FitConfig.detail,
                min_area=max(MONO.area_min, settings.min_area) if settings.min_area else None,
                blur=request.picture.blur,
                is_to_be_fitted=True,
                watch=request.watch,
            )
            if tracing.is_clean and 0 < tracing.scene.structure.loop_count <= MONO.form_loops_max:
                scene, left_out = _fitted(tracing, request, settings, detail)
            else:
                scene, left_out = _with_forms(tracing.scene, request, settings, detail), {}
            return finished(
                request, scene, detail, {"speck": tracing.speck_count, "faint line": tracing.faint_count} | left_out
            )

        with single_torch_thread(), torch.no_grad():
            return drawn(request, draw)


def _fitted(tracing: MonoTracing, request: Request, settings: FitConfig, detail: float) -> tuple[Scene, dict[str, int]]:
    """Return a clean tracing, fitted as flat art in black, with strokes and forms, and what it leaves out."""
    coverage = torch.from_numpy(tracing.coverage).float()
    ink = torch.cat([coverage.new_zeros(*coverage.shape, 3), coverage[..., None]], 2)
    settings = replace(settings, opacity="opaque")
    work = FlatDrawing(ink, settings, request.watch, tracing=tracing.scene, blur=request.picture.blur)
    scene, left_out = work.draw(detail)
    return replace(scene, color=torch.zeros_like(scene.color), opacity=torch.ones_like(scene.opacity)), left_out


def _with_forms(scene: Scene, request: Request, settings: FitConfig, detail: float) -> Scene:
    """Return ``scene`` with circles, ellipses and rectangles, if most of its few outlines are some."""
    if not 0 < scene.structure.loop_count <= MONO.form_loops_max:
        return scene
    image = torch.from_numpy(request.picture.reduced)
    seen = over_white(scene) if image.shape[2] == 3 else scene
    found = find_forms(seen, Critic(image, settings, request.picture.blur), request.watch, detail)
    return replace(found, background=scene.background, transparent=True)
