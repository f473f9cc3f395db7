"""Forms as elements of SVG: circles, ellipses and rectangles, written in ticks and read back exactly."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import NamedTuple

import torch
from torch import Tensor

from warpvec.geometry.forms.form import ANGLE, Form
from warpvec.geometry.forms.registry import FORMS
from warpvec.geometry.loops import OutlineForm
from warpvec.geometry.path_forms import Forms
from warpvec.svg.path_data import decimals_of, format_number
from warpvec.svg.quantize import ANGLE_DECIMALS, MAX_TICKS, ticks_of

FORM_ELEMENTS = frozenset(form.element for form in FORMS.values())
"""The elements that state a form."""

FORM_ATTRIBUTES = frozenset({"transform", *(side for form in FORMS.values() for side in form.sides)})
"""Their attributes."""

_NUMBER = r"-?(?:\d{1,15}(?:\.\d{1,7})?|\.\d{1,7})"
OWN_TURN = re.compile(rf"rotate\(({_NUMBER}) ({_NUMBER}) ({_NUMBER})\)", re.ASCII)
"""A turn about a point: degrees, x and y."""

_OWN_SIDE = re.compile(r"-?(?:\d{1,15}(?:\.\d{1,6})?|\.\d{1,6})", re.ASCII)


class Shape(NamedTuple):
    """An element of SVG without its paint: its name, and its attributes with a space before each."""

    element: str
    attributes: str


def form_shapes(forms: Forms, precision: int) -> dict[int, Shape]:
    """Return the shape of each path with a form; the ``forms`` have whole ticks of ``10**-precision``."""
    shapes = {}
    for _, form, paths in forms.groups():
        parameters = forms.parameters[paths].double()
        ticks = ticks_of(form.numbers(parameters), 10**precision).tolist()
        turns = _turns(parameters, precision) if form.turns else [""] * len(paths)
        for path, numbers, turn in zip(paths.tolist(), ticks, turns, strict=True):
            texts = [format_number(number, precision) for number in numbers]
            shapes[path] = Shape(form.element, _sides(form, texts) + turn)
    return shapes


def _sides(form: Form, texts: list[str]) -> str:
    """Return the attributes of a form's sides; the radius of corners twice, since some programs need both."""
    stated = dict(zip(form.sides, texts, strict=True))
    if _has_round_corners(stated):
        stated["ry"] = stated["rx"]
    return "".join(f' {side}="{text}"' for side, text in stated.items())


def _has_round_corners(attributes: Mapping[str, str]) -> bool:
    return "rx" in attributes and "width" in attributes


def _turns(parameters: Tensor, precision: int) -> list[str]:
    """Return the attribute for the turn of each form; "" for one that is level. Its centre may lie at half a tick."""
    degrees = ticks_of(torch.rad2deg(parameters[:, ANGLE]), 10**ANGLE_DECIMALS).tolist()
    centers = ticks_of(parameters[:, :2], 10 ** (precision + 1)).tolist()
    return [_turn(*each, precision) for each in zip(degrees, centers, strict=True)]


def _turn(degrees: int, center: list[int], precision: int) -> str:
    if degrees == 0:
        return ""
    x, y = (format_number(number, precision + 1) for number in center)
    return f' transform="rotate({format_number(degrees, ANGLE_DECIMALS)} {x} {y})"'


def form_decimals(attributes: Mapping[str, str]) -> int:
    """Return the largest number of decimals of the sides of a form."""
    return max(decimals_of(attributes.get(side, "")) for form in FORMS.values() for side in form.sides)


def read_form(element: str, attributes: Mapping[str, str], decimals: int) -> OutlineForm | None:
    """Return the form that `form_shapes` has written as ``element``; None if that is not what it writes.

    Args:
        element: name of the element.
        attributes: its attributes.
        decimals: of the file.
    """
    if _has_round_corners(attributes) and attributes.get("ry") == attributes["rx"]:
        attributes = {name: text for name, text in attributes.items() if name != "ry"}
    given = attributes.keys() & FORM_ATTRIBUTES - {"transform"}
    for number, form in FORMS.items():
        if form.element == element and given == set(form.sides):
            return _read(number, form, attributes, decimals)
    return None


def _read(number: int, form: Form, attributes: Mapping[str, str], decimals: int) -> OutlineForm | None:
    texts = [attributes[side] for side in form.sides]
    turn = OWN_TURN.fullmatch(attributes.get("transform", "rotate(0 0 0)"))
    if turn is None or not all(_OWN_SIDE.fullmatch(text) for text in texts):
        return None
    per_unit, degrees = 10**decimals, float(turn[1])
    values = torch.tensor([[round(float(text) * per_unit) / per_unit for text in texts]], dtype=torch.float64)
    angle = torch.tensor([math.radians(degrees)], dtype=torch.float64)
    parameters = form.parameters(values, angle)
    forms = Forms(torch.tensor([number], dtype=torch.int32), parameters)
    if not bool((values.abs() * per_unit < MAX_TICKS / 4).all()):
        return None
    is_same = form_shapes(forms, decimals).get(0) == Shape(form.element, _stated(form, texts, attributes))
    if not is_same or bool((values[:, 2:] <= 0.0).any()):
        return None
    return OutlineForm(number, tuple(parameters[0].tolist()))


def _stated(form: Form, texts: list[str], attributes: Mapping[str, str]) -> str:
    """Return the attributes as `form_shapes` writes them."""
    return _sides(form, texts) + (f' transform="{attributes["transform"]}"' if "transform" in attributes else "")
