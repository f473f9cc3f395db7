"""Choose the mode of a picture, unless the settings say it, and draw the picture."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from warpvec.arrays import Mask
from warpvec.condition.jpeg import Jpeg
from warpvec.config.fit_config import FitConfig
from warpvec.drawing.drawing import Drawing
from warpvec.flat.constants.mode_choice import MODE_CHOICE
from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.mode_choice import ModeChoice, choose_mode, is_gray
from warpvec.goals.search import check_possible
from warpvec.image.alpha import is_transparent
from warpvec.modes.lines_apart import with_lines_apart
from warpvec.modes.photo import Photo
from warpvec.modes.request import Mode, Request
from warpvec.modes.restored import Restoration, shown_at_usual_size
from warpvec.svg.measure import draw_like
from warpvec.watch.decisions import Decision, are_wanted, note

if TYPE_CHECKING:  # the modes of drawings load SciPy, which a photo does not need
    from warpvec.condition.condition import Condition
    from warpvec.modes.flat import KnownOutlines

FLAT_PSNR_MIN = 26.0
"""If auto takes a picture for flat art and the drawing reaches fewer dB, the picture is fitted as a photo. Drawings of
logos have 40 to 60 dB; screenshots with small text have 27, which is still more than the fit of a photo gives them."""


PLAIN_PHOTO = Photo()
"""A fit that begins with nothing, and whose state is not saved."""


def draw_picture(
    request: Request,
    photo: Photo = PLAIN_PHOTO,
    outlines: KnownOutlines | None = None,
    known: Restoration | None = None,
) -> Drawing:
    """Return the drawing that ``request`` asks for, in the mode of its settings.

    With the mode auto, the picture decides. Paths to begin with or a checkpoint mean that it is a photo.

    Args:
        request: what to draw.
        photo: how a photo is drawn.
        outlines: of the last picture of flat art; see `warpvec.modes.flat.Flat`.
        known: what has been found out of the picture already.

    Raises:
        InputError: as the modes.
    """
    check_possible(request.goal, request.encoding)
    with request.watch:
        if request.settings.mode == "photo":
            return photo.draw(request)
        if not photo.is_plain:
            return photo.draw(_in_mode(request, "photo"))
        found = with_lines_apart(Restoration.of(request, known))
        condition, drawn = found.condition, found.request
        if request.settings.mode == "auto":
            drawing = _draw_chosen(drawn, request, condition, photo, outlines)
        else:
            drawing = _draw_given(drawn, request, condition, photo, outlines)
        if are_wanted():
            is_taken, reason = drawing.encoding.settings.mode != "photo", drawing.mode_reason or ""
            note(Decision("mode", None, "photo", drawing.encoding.settings.mode, None, None, is_taken, reason))
        return replace(drawing, condition=condition)


def _draw_given(
    request: Request, given: Request, condition: Condition | None, photo: Photo, outlines: KnownOutlines | None
) -> Drawing:
    """Return the drawing in the mode of the settings, or as a photo if its photos have no outline of their own.

    The arguments are those of `_draw_chosen`.
    """
    from warpvec.flat.regions.regions import NotFlatArtError

    name = request.settings.mode
    try:
        with shown_at_usual_size(request, given):
            textures = _textures(request, condition) if name == "mixed" else None
            return _mode(name, photo, outlines, condition, is_texture=textures).draw(request)
    except NotFlatArtError as error:
        return replace(photo.draw(_in_mode(given, "photo")), mode_reason=str(error))


def _draw_chosen(
    request: Request, given: Request, condition: Condition | None, photo: Photo, outlines: KnownOutlines | None
) -> Drawing:
    """Return the drawing in the mode that the picture asks for, or as a photo if it proves to be no flat art.

    Args:
        request: what to draw, with the picture as it was before its enlargement and noise.
        given: the same with the picture as it is, for a photo.
        condition: what has happened to the picture; None if nobody looked.
        photo: how a photo is drawn.
        outlines: of the last picture of flat art.
    """
    choice, textures = suited_mode(request, condition)
    reason = choice.reason
    if choice.mode != "photo":
        from warpvec.flat.regions.regions import NotFlatArtError

        chosen = _in_mode(request, choice.mode)
        refusal = _is_like_picture(chosen.settings), choice.is_doubtful
        try:
            with shown_at_usual_size(chosen, given):
                mode = _mode(choice.mode, photo, outlines, condition, textures, refusal)
                drawing = mode.draw(chosen)
        except NotFlatArtError as error:
            reason = str(error)
        else:
            is_too_far = _is_too_far(drawing, chosen, condition)
            if is_too_far and _has_all_paths(drawing, chosen.settings):
                drawing = mode.draw(_with_more_paths(chosen))
                is_too_far = _is_too_far(drawing, chosen, condition)
            if not is_too_far:
                return replace(drawing, mode_reason=reason)
            reason = f"as flat art it has only {drawing.psnr:.1f} dB"
    return replace(photo.draw(_in_mode(given, "photo")), mode_reason=reason)


def suited_mode(request: Request, condition: Condition | None) -> tuple[ModeChoice, Mask | None]:
    """Return the mode that suits a picture, and which pixels [h, w] are photos: None except in the mode mixed.

    Args:
        request: what to draw, with the picture as it was before its enlargement and noise.
        condition: what has happened to the picture; None if nobody looked.
    """
    choice = chosen_mode(request.picture.sharp_copy, request.settings, condition)
    textures = _textures(request, condition) if _may_be_mixed(choice, request) else None
    if textures is not None:
        choice = ModeChoice("mixed", f"photos on {100 * textures.mean():.0f} % of it")
    return choice, textures


def _may_be_mixed(choice: ModeChoice, request: Request) -> bool:
    """Return whether a picture may have photos in it, and its drawing may have more paths than flat art needs."""
    is_free = _is_like_picture(request.settings) and not request.goal
    return is_free and choice.mode in ("flat", "photo") and request.settings.curves >= FitConfig.curves


def _textures(request: Request, condition: Condition | None) -> Mask | None:
    """Return which pixels [h, w] of the copy of the picture are photos; None if none are, or they cannot be told."""
    if request.picture.is_transparent or not _may_have_texture(condition):
        return None
    from warpvec.flat.textures import find_textures

    picture = request.picture
    is_jpeg = condition is not None and condition.jpeg is not None
    found = find_textures(picture.sharp_copy, is_jpeg, _blocks_of(request, condition))
    if found is None or picture.blocks == 1:
        return found
    rows, columns = picture.reduced_size
    return found.repeat(picture.blocks, 0)[:rows].repeat(picture.blocks, 1)[:, :columns]


def _blocks_of(request: Request, condition: Condition | None) -> Jpeg | None:
    """Return what the copy of the picture was saved as; None for no JPEG, or if its blocks are no longer those."""
    is_whole = request.picture.reduced is request.picture.pixels and request.picture.blocks == 1
    return condition.jpeg if condition is not None and is_whole else None


def _may_have_texture(condition: Condition | None) -> bool:
    """Return whether texture in a picture, as it was before its enlargement, can be a photo.

    Uneven light is texture, too, and so are the traces of a JPEG that came after the enlargement: they are smaller than
    its blocks, and stronger.
    """
    if condition is None:
        return True
    return condition.light is None and (condition.enlargement is None or condition.jpeg is None)


def _has_all_paths(drawing: Drawing, settings: FitConfig) -> bool:
    """Return whether a drawing of flat art has all paths that it may have, and could have more: dots of a halftone."""
    return settings.curves <= len(drawing.scene) < REGIONS.regions_max


def _with_more_paths(request: Request) -> Request:
    return request.with_settings(replace(request.settings, curves=REGIONS.regions_max))


def _mode(
    name: str,
    photo: Photo,
    outlines: KnownOutlines | None,
    condition: Condition | None = None,
    is_texture: Mask | None = None,
    refusal: tuple[bool, bool] = (False, False),
) -> Mode:
    """Return the mode ``name``. The mode flat may refuse a picture: its ``refusal`` is a `Refusal` of modes/flat.py.

    The mode mixed draws the pixels ``is_texture`` [h, w] as photos.

    To add a mode, write its file in this folder, and add it here.
    """
    if name == "photo":
        return photo
    from warpvec.modes.flat import Flat, KnownOutlines, Refusal
    from warpvec.modes.lines import Lines
    from warpvec.modes.mixed import Mixed
    from warpvec.modes.mono import Mono
    from warpvec.modes.pixel import Pixel

    outlines = KnownOutlines() if outlines is None else outlines
    modes: dict[str, Mode] = {
        "flat": Flat(outlines, Refusal(*refusal), condition),
        "mono": Mono(),
        "lines": Lines(),
        "pixel": Pixel(color_tolerance(condition)),
        "mixed": Mixed(is_texture),
    }
    return modes[name]


def _in_mode(request: Request, mode: str) -> Request:
    return request.with_settings(replace(request.settings, mode=mode))


def chosen_mode(reduced: NDArray[np.float32], settings: FitConfig, condition: Condition | None = None) -> ModeChoice:
    """Return the mode that a picture asks for, by its copy that is ``reduced`` to the size of a fit.

    The copy of a blurred picture is its `Picture.sharp_copy`. A drawing that is to have the colours of the ``settings``
    is not black and white art. Pixels are meant only if somebody has looked at the ``condition`` of the picture.
    """
    is_bound = settings.palette is not None or settings.colors > 0 or settings.cutout or settings.strokes == "off"
    if condition is not None and not is_bound:
        from warpvec.flat.pixels.choice import are_pixels_meant

        found = condition.enlargement
        is_exact = found is not None and found.is_of_whole_pixels
        if (found is None or is_exact) and are_pixels_meant(reduced, color_tolerance(condition), is_exact):
            return ModeChoice("pixel", "few colours, edges between whole pixels")
        if found is None and condition.palette is not None and condition.palette.has_two_levels:
            from warpvec.flat.pixels.two_colors import are_pixels_shorter

            if are_pixels_shorter(reduced):
                return ModeChoice("pixel", "two colours, shortest by whole pixels")
    choice = choose_mode(reduced, condition is not None and any(condition.noise))
    has_colors = settings.colors > 0 or settings.palette is not None
    if choice.is_doubtful and not _is_like_picture(settings):
        # What they leave unexplained tells nothing, so that the doubt stays.
        choice = ModeChoice("photo", "textured or shaded")
    if condition is not None and condition.light is not None and is_gray(reduced):
        choice = ModeChoice("mono", "ink on paper in uneven light")
    return choice._replace(mode="flat") if choice.mode == "mono" and has_colors else choice


def color_tolerance(condition: Condition | None) -> int:
    """Return the largest difference of a channel, in levels, between colours that were one before a JPEG."""
    from warpvec.flat.constants.pixels import PIXELS

    return 0 if condition is None or condition.jpeg is None else PIXELS.jpeg_levels


def _is_too_far(drawing: Drawing, request: Request, condition: Condition | None) -> bool:
    """Return whether a drawing of flat art is too far from its picture, although nothing has bounded it.

    It may be far from a poor JPEG, or have thin lines at other places, and it or its regions still say the picture more
    briefly than a photo.
    """
    settings = request.settings
    is_cut_short = request.watch.facts().interrupted or settings.time_budget is not None
    is_bounded = bool(request.goal) or is_cut_short or settings.curves < FitConfig.curves
    is_alike = _is_like_picture(settings) and settings.gradients != 0.0
    is_icon = max(request.picture.reduced_size) <= MODE_CHOICE.icon_side
    is_free = settings.mode == "flat" and is_alike and not is_bounded and not is_icon
    if not is_free or drawing.psnr_as_fitted >= FLAT_PSNR_MIN:
        return False
    from warpvec.flat.explanation import drawing_factor, is_shorter_as_photo

    pixels = request.picture.pixels
    if not is_transparent(pixels):
        jpeg = None if condition is None else condition.jpeg
        if drawing_factor(drawing.scene, draw_like(drawing.text, pixels), pixels, jpeg) <= 1.0:
            return False
    return is_shorter_as_photo(request.picture.reduced, _blocks_of(request, condition))


def _is_like_picture(settings: FitConfig) -> bool:
    """Return whether a drawing with these settings is to look like its picture, so that differences tell something."""
    return not (_has_paints(settings) or settings.cutout or settings.paper != "auto")


def _has_paints(settings: FitConfig) -> bool:
    """Return whether the settings say which paints the file may have."""
    return bool(settings.colors or settings.palette or settings.opacity == "opaque")
