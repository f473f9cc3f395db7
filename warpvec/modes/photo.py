"""Draw a photo: fit paths by gradient descent, with the given settings or towards a goal."""

from __future__ import annotations

from dataclasses import dataclass, replace

import torch

from warpvec.config.fit_config import FitConfig
from warpvec.drawing.drawing import Drawing
from warpvec.drawing.encoding import Encoding
from warpvec.errors import InputError
from warpvec.fit.budget import Budget, Written
from warpvec.fit.checkpoint import Checkpoint
from warpvec.fit.loop import fit
from warpvec.fit.state import Saving, digest
from warpvec.fit.target import Target
from warpvec.geometry.scene import Scene
from warpvec.goals.goal import refuse_states
from warpvec.goals.search import meet, with_path_limit
from warpvec.modes.path_count import PathCount
from warpvec.modes.request import Request
from warpvec.polish.finishing import finish, planned_iterations
from warpvec.watch.watch import Part

SHARE_AFTER_FIT = 0.1
"""Share of a time budget that must be left after a fit for all that may follow. A fit that uses its time up ends some
iterations early, with a hundredth of it left."""


@dataclass(frozen=True)
class Photo:
    """The mode of photos.

    Attributes:
        start: paths to begin with, in pixels of the picture; None to begin with none.
        resume: a checkpoint of this picture and these settings to continue from.
        saving: when and where states of the fit are saved.
    """

    start: Scene | None = None
    resume: Checkpoint | None = None
    saving: Saving | None = None

    @property
    def is_plain(self) -> bool:
        """Whether the fit begins with nothing, and its state is not saved."""
        return self.start is None and self.resume is None and self.saving is None

    def draw(self, request: Request) -> Drawing:
        """Return the drawing of a photo.

        Raises:
            InputError: the checkpoint is of another photo, a state is saved or resumed in spite of a goal, or as
                `warpvec.fit.loop.fit`.
        """
        refuse_states(request.goal, {"checkpoint": self.saving, "resume": self.resume})
        request = _with_free_opacity(request)
        picture, settings = request.picture, request.settings
        if self.resume is not None and self.resume.target_digest != digest(torch.from_numpy(picture.reduced)):
            rule = "must be the photo of the checkpoint, unchanged"
            raise InputError("image", rule, "another one", "give that photo, or start anew without the checkpoint")
        start = None if self.start is None else replace(self.start, softness=None).scaled(*picture.reduction)
        fits = PhotoFits(request, self.resume, self.saving)
        if not request.goal:
            return fits.finished(fits.once(settings, start, request.watch.part()))
        return with_path_limit(meet(request.goal, PathCount(request, fits, start)), settings.curves)


def _with_free_opacity(request: Request) -> Request:
    """Return the request without a common opacity if the picture is transparent: soft edges need paths of their own."""
    if request.settings.opacity != "common" or not request.picture.is_transparent:
        return request
    return request.with_settings(replace(request.settings, opacity="free"))


@dataclass(frozen=True)
class PhotoFits:
    """The fits of one photo."""

    request: Request
    resume: Checkpoint | None
    saving: Saving | None

    def encoding(self, settings: FitConfig) -> Encoding:
        """Return the encoding of the file of a fit with ``settings``."""
        return self.request.encoding.of_photo(settings, gzip=self.request.goal.gzip)

    def once(self, settings: FitConfig, start: Scene | None, part: Part, budget: Budget | None = None) -> Drawing:
        """Fit once with ``settings``, and return the drawing.

        Args:
            start: paths to begin with, in pixels of the reduced picture.
            part: the part of the run.
            budget: rule for the number of paths while the fit runs.
        """
        encoding, picture = self.encoding(settings), self.request.picture
        across, down = picture.reduction
        fitted = fit(
            torch.from_numpy(picture.reduced),
            replace(settings, min_area=settings.min_area * across * down),
            part,
            start=start,
            resume=None if self.resume is None else self.resume.state,
            saving=self.saving,
            written=Written(encoding.grid_step, budget),
        )
        watch = self.request.watch
        is_late = watch.is_over() or not watch.has_time_for(SHARE_AFTER_FIT)
        return Drawing.of(fitted.scene, encoding, fitted.device, is_late=is_late)

    def finished(self, drawing: Drawing, *, sharp: bool = False) -> Drawing:
        """Return the ``drawing`` of a whole fit after `finish`, or itself if that does not apply or no time is left.

        If it must stay ``sharp``, no path becomes soft.
        """
        encoding, watch = drawing.encoding, self.request.watch
        settings = encoding.settings
        count = planned_iterations(settings)
        if not count or drawing.fitted.degree != 3 or watch.is_over():
            return drawing
        part = watch.part(planned=watch.iterations + count)
        target = Target(torch.from_numpy(encoding.picture.reduced), settings, drawing.device)
        soft_max = 0 if sharp else settings.soft_max
        fitted = finish(drawing.fitted, target, settings, part, soft_max=soft_max, step=encoding.grid_step)
        return drawing.with_fitted(fitted.cpu())
