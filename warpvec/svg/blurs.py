"""The blurs of soft paths as filters of SVG, written and read back. Paths of equal softness share one.

A filter states its region in shares of the box of a path, so that it follows when the path is moved or scaled; a path
without a width or a height, such as a straight line that is stroked, has a filter of its own in user space.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import NamedTuple
from xml.etree.ElementTree import Element

import torch

from warpvec.geometry.bezier import path_boxes
from warpvec.geometry.scene import Scene
from warpvec.geometry.softness import SIGMA_MIN
from warpvec.svg.document import local_name
from warpvec.svg.path_data import OWN_NUMBER, format_number
from warpvec.svg.quantize import SIGMA_DECIMALS, ticks_of

REGION_SIGMAS = 3.0
"""Distance in standard deviations from a path at which its filter ends: what lies beyond is 0.1 % of an edge, a third
of an 8-bit level. Viewers blur by three boxes, which do not reach as far."""

SHARE_MAX = 10_000
"""Most per cent of its own width or height that a filter reaches beyond a path, before it is stated in user space."""

MAX_SIGMA = 1e6
"""Standard deviation in units from which on a filter is none of warpvec's own."""

_PERCENT = re.compile(r"-?\d{1,5}%", re.ASCII)
_SIDES = ("x", "y", "width", "height")


class _Region(NamedTuple):
    """Where a filter works: per cent of a path's box that it reaches beyond it, or a box in user space."""

    across: int
    down: int
    box: tuple[int, int, int, int] | None = None


def blurs_of(scene: Scene, name: Callable[[str, list[str]], str]) -> tuple[list[str], list[str]]:
    """Return the attribute of each path that blurs it, with the space before it ("" if sharp), and the filters.

    Args:
        scene: has whole ticks, as a file states them.
        name: returns the id of a filter from its text without one, and the ids taken.
    """
    found = [""] * len(scene)
    if scene.softness is None:
        return found, []
    soft = scene.softness.is_soft.nonzero().flatten().tolist()
    regions, ticks = _regions(scene), ticks_of(scene.softness.sigma, 10**SIGMA_DECIMALS).tolist()
    shared: dict[tuple[int, object], _Region] = {}
    for path in soft:
        key, own = (ticks[path], regions[path].box), regions[path]
        other = shared.get(key, own)
        shared[key] = _Region(max(own.across, other.across), max(own.down, other.down), own.box)
    names: dict[tuple[int, object], str] = {}
    texts = []
    for key, region in shared.items():
        text = _filter(key[0], region)
        names[key] = name(text, list(names.values()))
        texts.append(text.replace(" ", f' id="{names[key]}" ', 1))
    for path in soft:
        found[path] = f' filter="url(#{names[ticks[path], regions[path].box]})"'
    return found, texts


def _filter(sigma: int, region: _Region) -> str:
    """Return the element of a filter, whose standard deviation is in ticks, without its id."""
    values = [f"{-region.across}%", f"{-region.down}%", f"{100 + 2 * region.across}%", f"{100 + 2 * region.down}%"]
    units = ""
    if region.box is not None:
        left, top, right, bottom = region.box
        values, units = [str(each) for each in (left, top, right - left, bottom - top)], ' filterUnits="userSpaceOnUse"'
    sides = "".join(f' {side}="{value}"' for side, value in zip(_SIDES, values, strict=True))
    blur = f'<feGaussianBlur stdDeviation="{format_number(sigma, SIGMA_DECIMALS)}"/>'
    return f'<filter{units}{sides} color-interpolation-filters="sRGB">{blur}</filter>'


def _regions(scene: Scene) -> list[_Region]:
    """Return the region of each path's filter."""
    assert scene.softness is not None
    outline = path_boxes(_without_strokes(scene)).double()
    sizes = outline[:, 2:] - outline[:, :2]
    reach = REGION_SIGMAS * scene.softness.sigma.double() + 1.0
    if scene.strokes is not None:
        reach = reach + scene.strokes.reach.double()
    shares = torch.ceil(100.0 * reach[:, None] / sizes.clamp_min(1e-9)).clamp_max(SHARE_MAX + 1.0)
    corners = torch.cat([outline[:, :2] - reach[:, None], outline[:, 2:] + reach[:, None]], 1)
    found = []
    for (across, down), (left, top, right, bottom) in zip(shares.int().tolist(), corners.tolist(), strict=True):
        is_flat = max(across, down) > SHARE_MAX
        box = (math.floor(left), math.floor(top), math.ceil(right), math.ceil(bottom)) if is_flat else None
        found.append(_Region(0, 0, box) if is_flat else _Region(across, down))
    return found


def _without_strokes(scene: Scene) -> Scene:
    """Return the scene whose boxes are those that shares of a filter's region refer to."""
    return Scene(
        scene.segments, scene.structure, scene.color, scene.opacity, scene.background, scene.generation
    )  # fmt: skip


def read_blur(element: Element) -> float | None:
    """Return the standard deviation of a filter that `blurs_of` has written; None for any other element."""
    if local_name(element.tag) != "filter" or len(element) != 1 or local_name(element[0].tag) != "feGaussianBlur":
        return None
    in_user_space = element.get("filterUnits") == "userSpaceOnUse"
    known = {"id", *_SIDES, "color-interpolation-filters"} | ({"filterUnits"} if in_user_space else set())
    deviation = element[0].get("stdDeviation", "")
    is_own = element.attrib.keys() == known and element[0].attrib.keys() == {"stdDeviation"}
    is_own = is_own and element.get("color-interpolation-filters") == "sRGB" and len(element[0]) == 0
    pattern = OWN_NUMBER if in_user_space else _PERCENT
    if not is_own or not all(pattern.fullmatch(element.get(side, "")) for side in _SIDES):
        return None
    if not OWN_NUMBER.fullmatch(deviation) or not SIGMA_MIN <= float(deviation) < MAX_SIGMA:
        return None
    return float(deviation)
