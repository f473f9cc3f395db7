"""Find shadows, which are copies of traced pieces, moved and blurred, and soft spots, if they shorten the drawing."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats, Floats32
from warpvec.flat.constants.softness import SOFTNESS
from warpvec.flat.evidence.evidence import ROUNDING, Evidence
from warpvec.flat.price import FORM_NUMBERS, SHADOW_NUMBERS, number_nats
from warpvec.flat.regions.regions import Regions, find_regions
from warpvec.flat.softness.shadow_fitting import FoundShadow
from warpvec.flat.softness.shadows import Shadow, channels_of, is_soft
from warpvec.flat.softness.spots import find_spot
from warpvec.flat.softness.traced_casters import Casting
from warpvec.flat.softness.traced_grounds import TracedGround, find_traced_grounds
from warpvec.flat.softness.unshading import REACH, mark_for, without_shadow
from warpvec.geometry.forms.registry import ELLIPSE
from warpvec.watch.decisions import Decision, are_wanted, box_of, note


def find_shadows(
    image: Floats32, traced: Regions, is_time_up: Callable[[], bool], saved: Evidence | None = None
) -> list[Shadow]:
    """Return the shadows and soft spots of a picture that pay, each found in the picture without those before it.

    Args:
        image: [h, w, 3 or 4], sRGB-encoded in [0, 1], with straight alpha.
        traced: a rough tracing of it, with its shadows.
        is_time_up: whether the search is to end.
        saved: what it says if it was saved as JPEG; None for no JPEG.
    """
    steps: list[_Step] = []
    explained: list[Floats] = []
    while len(steps) < SOFTNESS.shadows_max and 1 < len(traced) <= SOFTNESS.pieces_max:
        step = _next(image, traced, is_time_up, saved, explained)
        if step is None:
            break
        shadow = step.shadow
        if shadow.look.unexplained <= SOFTNESS.explained and not shadow.ground.is_part:
            explained.append(shadow.ground.color)
        joint = steps and _joint(steps[-1], step, saved)
        steps = [*steps[:-1], joint] if joint else [*steps, step]
        image, traced = steps[-1].shadow.clean, steps[-1].after
    return [step.shadow for step in steps]


@dataclass(frozen=True)
class _Step:
    """One shadow of a picture.

    Attributes:
        image: the picture with it [h, w, 3 or 4].
        before: the regions of that.
        ground: the whole ground that the shadow lies on a part of, or on.
        shadow: the shadow.
        after: the regions of the picture without it.
        nats: what it saves.
    """

    image: Floats32
    before: Regions
    ground: TracedGround
    shadow: Shadow
    after: Regions
    nats: float


def _joint(first: _Step, second: _Step, saved: Evidence | None) -> _Step | None:
    """Return two successive shadows as one shadow, which the casters of both cast; None if two are shorter.

    A rough tracing swells some shapes, so that the shadow of several is found part by part.
    """
    one, two = first.shadow, second.shadow
    if one.spot is not None or two.spot is not None or not np.array_equal(one.ground.color, two.ground.color):
        return None
    both = replace(two, casters=np.maximum(one.casters, two.casters), ground=first.ground)
    shadow, after = both, second.after
    for _ in range(2):
        shadow, after = _measured_again(shadow, after, first.image, saved is not None)
    if shadow is both:
        return None
    nats = gain(_evidence(first.image, shadow, saved), first.before, shadow, after)
    return replace(first, shadow=shadow, after=after, nats=nats) if nats > first.nats + second.nats else None


def _evidence(image: Floats32, shadow: Shadow, saved: Evidence | None) -> Evidence:
    """Return what an ``image`` [h, w, 3 or 4] with a ``shadow`` says; ``saved`` is as for `find_shadows`."""
    seen = 255.0 * channels_of(image)[..., -3:]  # a transparent picture over white
    if saved is not None:
        return replace(saved, levels=seen)
    return Evidence(seen, np.full(3, math.sqrt(ROUNDING + shadow.ground.noise**2)))


def _next(
    image: Floats32,
    traced: Regions,
    is_time_up: Callable[[], bool],
    saved: Evidence | None,
    explained: list[Floats],
) -> _Step | None:
    """Return the first shadow that pays; None without one.

    Grounds of colours on which all is ``explained`` are not searched again.
    """
    levels = 255.0 * channels_of(image)
    for ground in find_traced_grounds(levels, traced, saved is not None):
        if any(np.array_equal(ground.color, color) for color in explained):
            continue
        for rough in _lights_on(ground, image, traced, is_time_up):
            if saved is not None and _is_bleed(rough.look):
                continue
            evidence = _evidence(image, rough, saved)
            after = find_regions(rough.clean, is_jpeg=saved is not None)
            nats = gain(evidence, traced, rough, after)
            if nats + _left_near(evidence, rough, after) <= 0.0:
                continue  # another look can explain no more
            shadow, after = _measured_again(rough, after, image, saved is not None)
            if shadow is not rough:
                nats = gain(_evidence(image, shadow, saved), traced, shadow, after)
            if are_wanted():
                place = box_of(np.argwhere(shadow.casters > 0.5)[:, ::-1].astype(np.float64))
                note(Decision("shadow", place, "regions", f"blur of {shadow.look.sigma:.2f} px", nats, 0.0, nats > 0.0))
            if nats > 0.0:
                return _Step(image, traced, ground, shadow, after, nats)
    return None


def _is_bleed(look: FoundShadow) -> bool:
    """Return whether a shadow is what a JPEG with colours at half size makes around each shape: unmoved and narrow."""
    return look.sigma <= SOFTNESS.bleed_sigma and math.hypot(*look.offset) <= SOFTNESS.bleed_offset


def gain(evidence: Evidence, before: Regions, shadow: Shadow, after: Regions) -> float:
    """Return by how many nats the picture of ``evidence`` is shorter to say with a ``shadow``.

    Args:
        evidence: the picture, over white if it is transparent.
        before: its regions, with slabs of the shadow.
        shadow: a shadow of it.
        after: the regions of the picture without it.
    """
    numbers = SHADOW_NUMBERS if shadow.spot is None else SHADOW_NUMBERS + FORM_NUMBERS[ELLIPSE] + 1
    said = numbers * number_nats(max(evidence.levels.shape))
    return before.nats(evidence) - after.nats(evidence, _added(evidence, shadow)) - said


def _added(evidence: Evidence, shadow: Shadow) -> Floats:
    """Return what a ``shadow`` adds to the picture without it [h, w, 3], in levels.

    What was taken away at edges is a mix; elsewhere it may be noise too.
    """
    shade = shadow.look.shade_of(shadow.casters, shadow.ground.deviation)[..., -3:]
    clean = 255.0 * channels_of(shadow.clean)[..., -3:]
    return np.where(shadow.ground.is_open[..., None], shade, evidence.levels - clean)


def _left_near(evidence: Evidence, shadow: Shadow, after: Regions) -> float:
    """Return the nats that `gain` counts where a ``shadow`` may be seen, the most that another look of it can save."""
    near = ndimage.binary_dilation(shadow.ground.is_open, iterations=REACH)
    return float(evidence.misfit(after.shown() + _added(evidence, shadow))[near].sum())


def _lights_on(
    ground: TracedGround, image: Floats32, regions: Regions, is_time_up: Callable[[], bool]
) -> Iterator[Shadow]:
    """Yield what may be the light on a ``ground``: the shadow of all, or that of each thing on it, or a spot."""
    whole = _copy_on(ground, image, regions)
    if whole is None or whole.look.unexplained > SOFTNESS.explained:
        for part in ground.parts():
            if is_time_up():
                return
            found = _copy_on(part, image, regions) or _spot_on(part, image, regions, SOFTNESS.spot_part_unexplained)
            if found is not None and found.look.unexplained <= SOFTNESS.part_unexplained:
                everything = _copy_on(ground, image, regions, found.look) if found.spot is None else None
                if everything is not None and everything.look.unexplained <= SOFTNESS.well_explained:
                    yield everything
                yield found
        spot = None if is_time_up() else _spot_on(ground, image, regions, SOFTNESS.spot_unexplained)
        if spot is not None:
            yield spot
    if whole is not None:
        yield whole


def _copy_on(ground: TracedGround, image: Floats32, regions: Regions, look: FoundShadow | None = None) -> Shadow | None:
    """Return the shadow on a ``ground`` of a picture that copies of its pieces explain best; None without one.

    With a ``look`` it is that of all of them, nearly with this look.
    """
    if ground.soft_count < SOFTNESS.zone_area:
        return None
    casting = Casting(ground, _change(image, ground), regions)
    if not casting.everything:
        return None
    found = casting.best() if look is None else casting.finished(casting.everything, look)
    return None if found is None else _shadow_of(image, *found, regions)


def _shadow_of(
    image: Floats32, casting: Casting, chosen: frozenset[int], look: FoundShadow, regions: Regions
) -> Shadow | None:
    """Return the shadow of ``chosen`` pieces with a ``look``; None if that is not soft."""
    ground, cast = casting.ground, casting.exact_mask(chosen, look)
    if not is_soft(ground, look):
        return None
    mark = mark_for(ground, image, cast, regions)
    covered = casting.exact_mask(casting.everything, look)
    return Shadow(cast, ground, look, without_shadow(image, ground, cast, covered, look, mark), None, mark)


def _spot_on(ground: TracedGround, image: Floats32, regions: Regions, most: float) -> Shadow | None:
    """Return a soft spot on a ``ground`` that leaves at ``most`` this share unexplained; None without one."""
    if ground.soft_count < SOFTNESS.zone_area:
        return None
    found = find_spot(ground.zone(_change(image, ground)))
    if found is None or found[2].unexplained > most or not is_soft(ground, found[2]):
        return None
    values, cast, look = found
    casting = Casting(ground, _change(image, ground), regions)
    covered = casting.exact_mask(casting.everything, look, cast)
    return Shadow(cast, ground, look, without_shadow(image, ground, cast, covered, look, None), values)


def _change(image: Floats32, ground: TracedGround) -> Floats:
    return 255.0 * channels_of(image, ground.below.shape[2]) - ground.below


def _measured_again(shadow: Shadow, after: Regions, image: Floats32, is_jpeg: bool) -> tuple[Shadow, Regions]:
    """Return a shadow of pieces of the picture without it, which has no slabs, and the regions without that shadow.

    ``after`` are the regions without the one given.
    """
    for _ in range(0 if shadow.spot is not None else SOFTNESS.same_rounds):
        below = shadow.ground.below
        ground = shadow.ground.below_pieces(after, 255.0 * channels_of(shadow.clean, below.shape[2]))
        casting = Casting(ground.after(_change(image, ground) + below), _change(image, ground), after)
        settled = casting.settled(casting.within(shadow.casters), shadow.look)
        again = None if settled is None else _shadow_of(image, casting, *settled, after)
        if again is None:
            break
        is_settled = abs(math.log(again.look.sigma / shadow.look.sigma)) < SOFTNESS.settled
        shadow, after = again, find_regions(again.clean, is_jpeg=is_jpeg)
        if is_settled:
            break
    return shadow, after
