"""Give drawing modes the picture as it was before it was enlarged, unevenly lit or noisy, and say how blurred it is."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from warpvec.condition.constants import CONDITION
from warpvec.image.alpha import is_transparent, premultiplied, straight
from warpvec.image.picture import Picture, mean_image
from warpvec.modes.request import Request
from warpvec.watch.progress import Progress

if TYPE_CHECKING:  # measuring loads SciPy, which the fit of a photo does not need
    from warpvec.condition.condition import Condition


@dataclass(frozen=True, eq=False)
class Restoration:
    """What has happened to a picture, and a request for its drawing as it was before.

    Attributes:
        given: the request with the picture as it is.
        condition: what has happened; None if nobody looked.
        request: the same request with the picture as it was before, for modes of drawings.
    """

    given: Request
    condition: Condition | None
    request: Request

    @staticmethod
    def of(request: Request, known: Restoration | None = None) -> Restoration:
        """Return the restoration of ``request``, with what is ``known`` from another request for the same picture."""
        if known is None or not known._is_of(request):
            condition = measured(request)
        else:
            condition = known.condition
            if known._suits(request):
                picture = replace(known.request.picture, title=request.picture.title)
                return Restoration(request, condition, _with_picture(request, picture))
        return Restoration(request, condition, restored(request, condition))

    def _is_of(self, request: Request) -> bool:
        """Return whether the condition is that of the picture of ``request``."""
        is_same = self.given.picture.pixels is request.picture.pixels
        return is_same and self.given.settings.as_is == request.settings.as_is

    def _suits(self, request: Request) -> bool:
        """Return whether ``request`` gets the same copy of its picture; see `restored`."""
        one, other = self.given, request
        deciding = ("threshold", "fit_size", "blur")
        is_same = all(getattr(one.settings, name) == getattr(other.settings, name) for name in deciding)
        return is_same and (one.goal.quality is None) == (other.goal.quality is None)


def measured(request: Request) -> Condition | None:
    """Return what has happened to the picture of ``request``; None if its settings take it as it is."""
    if request.settings.as_is:
        return None
    from warpvec.condition.condition import measure_condition

    return measure_condition(request.picture.pixels)


def restored(request: Request, condition: Condition | None) -> Request:
    """Return ``request`` with a copy of the picture as it was before it was damaged.

    The blur of the copy stays in it, and its deviation is stated. The file keeps the size of the given picture. A goal
    for the quality is about the picture as it is, and so is a threshold that is given: it is one level for the whole
    picture.
    """
    if request.goal.quality is not None:
        return _with_means(request)
    before = request if condition is None else _before(request, condition)
    return with_blur(before if before.picture.is_restored else _with_means(before), request.settings.blur, condition)


def _with_means(request: Request) -> Request:
    """Return ``request`` with a copy of its picture that was reduced without halos, if it was reduced at all."""
    picture = request.picture
    if picture.reduced_size == (picture.height, picture.width):
        return request
    return _with_picture(request, replace(picture, reduced=mean_image(picture.pixels, request.settings.fit_size)))


def with_blur(request: Request, blur: str, condition: Condition | None) -> Request:
    """Return ``request`` with a picture whose copy states its blur.

    Args:
        request: what to draw.
        blur: deviation in pixels of the picture as it is, as a number, or "auto" for that of ``condition``.
        condition: what has happened to the picture; None if nobody looked.
    """
    deviation = _blur_of_copy(request, blur, condition)
    return request if deviation == 0.0 else _with_picture(request, replace(request.picture, blur=deviation))


def _blur_of_copy(request: Request, blur: str, condition: Condition | None) -> float:
    """Return the deviation in pixels of the blur of the copy of the picture; 0 for none, or so little as not to count.

    Where light is uneven, paper and shades are as soft as blur. Arguments as `with_blur`.
    """
    if blur != "auto":
        given = float(blur)
    elif condition is None or not condition.edge_blur.is_even or condition.light is not None:
        given = 0.0
    else:
        given = condition.blur * (1.0 if condition.enlargement is None else condition.enlargement.factor)
    of_copy = given * request.picture.reduction[0]
    return of_copy if of_copy >= CONDITION.blur_min else 0.0


def _with_picture(request: Request, picture: Picture) -> Request:
    return replace(request, encoding=replace(request.encoding, picture=picture))


def _before(request: Request, condition: Condition) -> Request:
    """Return ``request`` with a copy of the picture as it was before its ``condition``; the blur stays."""
    picture, settings, pixels = request.picture, request.settings, request.picture.pixels
    if condition.enlargement is not None:
        from warpvec.condition.restoration import before_enlargement

        pixels = before_enlargement(picture.pixels, condition.enlargement)
        if condition.enlargement.is_of_whole_pixels and condition.jpeg is None:
            from warpvec.flat.pixels.choice import are_rectangles

            if are_rectangles(pixels):  # the picture has their edges as exactly
                return request
    elif condition.light is not None and not picture.is_transparent and settings.threshold == "auto":
        from warpvec.condition.light import in_even_light

        pixels = in_even_light(picture.pixels, condition.light)
    if condition.reduction is not None and max(pixels.shape[:2]) <= settings.fit_size:
        pixels = _without_rims(pixels, condition.reduction, request.watch.seconds_left())
    is_noisy = any(condition.noise) and condition.light is None
    if pixels is picture.pixels and not is_noisy:
        return request
    reduced = mean_image(pixels, settings.fit_size)
    if is_noisy:
        reduced = _without_noise(reduced, condition.noise, reduced[..., 0].size / pixels[..., 0].size)
    return _with_picture(request, replace(picture, reduced=reduced, is_restored=True))


def _without_rims(pixels: NDArray[np.float32], kernel: str, seconds: float) -> NDArray[np.float32]:
    """Return ``pixels`` [h, w, 3 or 4] without the rims of a reduction, or with them where there are photos.

    These would lose their texture. The arguments are those of `without_rims`.
    """
    from warpvec.condition.unrimming import without_rims
    from warpvec.flat.textures import find_textures

    if not is_transparent(pixels):
        return without_rims(pixels, kernel, seconds) if find_textures(pixels) is None else pixels
    given = premultiplied(pixels)
    found = without_rims(given, kernel, seconds)
    return pixels if found is given else straight(found)


def _without_noise(reduced: NDArray[np.float32], noise: tuple[float, ...], share: float) -> NDArray[np.float32]:
    """Return the picture ``reduced`` [h, w, 3 or 4] without noise, of which a smaller ``share`` of the pixels has less.

    The noise of transparent pictures was measured over white, and stays.
    """
    if is_transparent(reduced):
        return reduced
    from warpvec.condition.denoising import before_noise

    return before_noise(reduced, tuple(np.sqrt(share) * each for each in noise))


@contextmanager
def shown_at_usual_size(request: Request, given: Request) -> Iterator[None]:
    """Show the scenes of ``request``, with a restored picture, in pixels of the copy that ``given`` has."""
    watch, show = request.watch, request.watch.on_progress
    if show is None or not request.picture.is_restored:
        yield
        return
    (rows, columns), (height, width) = request.picture.reduced_size, given.picture.reduced_size

    def show_scaled(progress: Progress) -> None:
        show(replace(progress, scene=lambda: progress.scene().scaled(width / columns, height / rows)))

    watch.on_progress = show_scaled
    try:
        yield
    finally:
        watch.on_progress = show
