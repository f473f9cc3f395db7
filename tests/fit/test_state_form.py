"""No state reaches native code unchecked: each value of a saved state is damaged in many ways, and refused.

A value that could be true may pass. The fit then runs to its end.
"""

from __future__ import annotations

import copy
import math
import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
import torch
from logo import logo
from paints import painted_scene, values_of, with_values
from torch import Tensor

from warpvec.config.fit_config import MACHINE_SETTINGS, FitConfig
from warpvec.config.presets import make_config
from warpvec.errors import InputError
from warpvec.fit.loop import fit
from warpvec.fit.state import Saving, State
from warpvec.geometry.scene import Scene, straightened

QUICK: dict[str, Any] = {
    "curves": 12,
    "initial_curves": 6,
    "inflation_gap": 3,
    "iterations": 24,
    "device": "cpu",
    "threads": 1,
}
SPLAT: dict[str, Any] = {"samples": 8, "lines": 4}
KINDS: dict[str, dict[str, Any]] = {
    "default": {"recycle_gap": 4},
    "palette": {"colors": 3, "z_order": "area"},
    "given palette": {"palette": "#123,#89a,#fff"},
    "replacement": {"preset": "bezier-splatting", "replace_gap": 2, "lr_points": 0.05, **SPLAT},
    "splat": {"renderer": "splat", "color_parameter": "logit", **SPLAT},
    "transparent": {},
    "transparent palette": {"colors": 3},
    "timed": {"time_budget": 1e6},
    "refined levels": {"lod": True, "recycle_gap": 2},
    "gradients": {"gradients": 0.5, "recycle_gap": 3},
    "refined drawing": {"recycle_gap": 5},
}

REFUSAL = re.compile("checkpoint must hold a whole fit, got one whose .* [(]it is damaged[)]; start again without it")

Change = Callable[[Any], Any]
Path = tuple[Any, ...]


class Case:
    """A target, the settings of a fit, and the state of the fit after two thirds of it."""

    def __init__(self, kind: str) -> None:
        self.kind = kind
        torch.manual_seed(0)
        pixels = logo().astype(np.float32)[::4, ::4] / 255.0
        self.target = torch.from_numpy(pixels if "transparent" in kind else np.ascontiguousarray(pixels[..., :3]))
        self.config = make_config(**{**QUICK, **KINDS[kind]})
        start = self._start()
        if start is not None:
            self.config = replace(self.config, curves=20)
        states: list[State] = []
        fit(self.target, self.config, start=start, saving=Saving(16, lambda state: states.append(copy.deepcopy(state))))
        self.state = states[0]

    def _start(self) -> Scene | None:
        """Return what a refining fit begins with."""
        if self.kind == "refined levels":
            return fit(self.target, self.config).scene
        if self.kind != "refined drawing":
            return None
        scene = painted_scene(0, 9, *self.target.shape[:2])
        is_line = torch.arange(len(scene.segments)) % 4 == 0
        structure = replace(scene.structure, is_line=is_line)
        values = [value.float() for value in values_of(scene)]
        drawing = with_values(scene, [straightened(values[0], structure), *values[1:]])
        return replace(drawing, structure=structure, generation=torch.zeros_like(scene.generation))

    def refusal(self, path: Path, change: Change) -> str | None:
        """Return the error of a fit of the changed state; None if it runs to its end, to finite paths."""
        try:
            result = fit(self.target, self.config, resume=_changed(self.state, path, change))
        except InputError as error:
            message = str(error)
        else:
            assert result.iterations == self.config.iterations
            assert torch.isfinite(result.scene.segments).all()
            assert torch.isfinite(result.scene.color).all()
            return None
        assert REFUSAL.fullmatch(message), message
        return message


@cache
def _case(kind: str) -> Case:
    return Case(kind)


def _places(value: Any, path: Path = ()) -> Iterator[tuple[Path, Any]]:
    """Yield the path of each value in a state, and the value."""
    yield path, value
    items = value.items() if isinstance(value, dict) else enumerate(value[:1]) if isinstance(value, list) else ()
    for name, item in items:
        yield from _places(item, (*path, name))


def _changed(value: Any, path: Path, change: Change) -> Any:
    """Return ``value`` with ``change`` at ``path``; the state itself stays."""
    if not path:
        return change(value)
    changed = copy.copy(value)
    try:
        changed[path[0]] = _changed(value[path[0]], path[1:], change)
    except KeyError:
        del changed[path[0]]
    return changed


def _remove(_: Any) -> Any:
    raise KeyError


OTHER_TYPES: dict[str, Change] = {
    "removed": _remove, "none": lambda _: None, "a text": lambda _: "1", "a list": lambda _: [1],
    "a flag": lambda _: True,
    "a dictionary": lambda _: {"a": 1}, "an array": lambda _: torch.zeros(3, dtype=torch.float64),
}  # fmt: skip
NUMBERS: dict[str, Change] = {
    "immense": lambda _: 10**400, "NaN": lambda _: math.nan, "minus infinity": lambda _: -math.inf,
    "negative": lambda value: -1 - abs(value),
    "of the other type": lambda value: float(value) if isinstance(value, int) else 1,
}  # fmt: skip
SHAPES: dict[str, Change] = {
    "empty": lambda values: values.reshape(-1)[:0], "a half": lambda values: values[: len(values) // 2],
    "one more": lambda values: torch.cat([values, values[:1]]), "one axis more": lambda values: values[None],
    "narrower": lambda values: values[..., 1:].contiguous(), "wider": lambda values: torch.cat([values, values], -1),
    "not in order": lambda values: values.repeat_interleave(2, -1)[..., ::2],
    "64 bits": lambda values: values.to(torch.float64 if values.is_floating_point() else torch.int32),
}  # fmt: skip


def _with(number: float, row: int) -> Change:
    def change(values: Tensor) -> Tensor:
        changed = values.clone()
        changed[row].reshape(-1)[:1] = number
        return changed

    return change


def _wrong_forms(value: Any) -> dict[str, Change]:
    """Return changes that no state of a fit can have."""
    others = {name: change for name, change in OTHER_TYPES.items() if not _is_possible(value, change)}
    if isinstance(value, bool) or value is None:
        return others
    if isinstance(value, int | float):
        return others | NUMBERS
    if isinstance(value, dict):
        return others | {"with one more": lambda fields: {**fields, "more": 1}}
    if isinstance(value, list):
        return others | {"twice": lambda items: [*items, *items]}
    if isinstance(value, Tensor) and value.dim():
        return others | SHAPES | _wrong_values(value)
    return others


def _is_possible(value: Any, change: Change) -> bool:
    """Return whether the change keeps the type of a text, a flag or None."""
    return change is not _remove and isinstance(value, str | bool | None) and type(change(value)) is type(value)


def _wrong_values(values: Tensor) -> dict[str, Change]:
    if not values.is_floating_point():
        return {f"{number}": _with(number, -1) for number in (-(2**62), 2**62) if values.dtype == torch.int64}
    return {f"{number} in {row}": _with(number, row) for number in (math.nan, math.inf) for row in (0, -1)}


def _is_free(path: Path, name: str, value: Any) -> bool:
    """Return whether the change ``name`` leaves a state that a fit can have."""
    if len(path) == 2 and path[0] == "config":  # settings of the machine, and defaults that are left out
        return path[1] in MACHINE_SETTINGS or (name == "removed" and FitConfig().to_dict()[path[1]] == value)
    if name == "none" and path[-1:] in [
        ("is_line",),
        ("gradients",),
    ]:  # any path may be curved, and any best scene flat
        return path[-1] == "is_line" or path[0] == "best"
    return (path, name) in [((), "none"), ((), "removed"), (("best",), "none"), (("history", 0), "removed")]


FORMS = ["default", "refined drawing", "replacement", "transparent palette", "refined levels", "gradients"]
"""In the first two, one of paths of one loop and one of others, every value is damaged; in the others only those that
the first does not have in the same form."""


def _form(value: Any) -> Any:
    """Return what a check of ``value`` looks at: its type, and its kind of numbers and axes."""
    return (value.dtype, value.dim()) if isinstance(value, Tensor) else type(value)


def _new_places(kind: str) -> list[tuple[Path, Any]]:
    places = [(path, value) for path, value in _places(_case(kind).state)]
    if kind == FORMS[0]:
        return places
    known = {path: _form(value) for path, value in _places(_case(FORMS[0]).state)} if kind not in FORMS[:2] else {}
    # The settings are checked alike.
    return [
        (path, value)
        for path, value in places
        if path[:1] != ("config",) and (path not in known or known[path] != _form(value))
    ]


@pytest.mark.slow
@pytest.mark.parametrize("kind", FORMS)
def test_a_state_of_another_form_is_refused(kind: str) -> None:
    case, accepted = _case(kind), []
    for path, value in _new_places(kind):
        for name, change in _wrong_forms(value).items():
            if not _is_free(path, name, value) and case.refusal(path, change) is None:
                accepted.append((path, name))
    assert not accepted


def _planes(state: State) -> Iterator[tuple[Path, int]]:
    """Yield the path of each array of floats in a state, and each of its planes or rows."""
    for path, value in _places(state):
        if isinstance(value, Tensor) and value.is_floating_point() and value.dim():
            for row in range(min(5, len(value))):
                yield path, row


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["default", "given palette", "replacement", "splat", "transparent", "refined drawing"])
def test_a_value_that_could_be_true_is_refused_or_runs_to_the_end(kind: str) -> None:
    case = _case(kind)
    is_run = [
        case.refusal(path, _with(number, row)) is None for path, row in _planes(case.state) for number in (-1.0, 1e30)
    ]
    assert any(is_run)
    assert sum(is_run) < 0.3 * len(is_run)


@pytest.mark.parametrize("kind", ["default", "palette", "gradients", "refined drawing"])
def test_a_state_may_be_resumed_twice(kind: str) -> None:
    case = _case(kind)
    first, second = (fit(case.target, case.config, resume=case.state).scene for _ in range(2))
    assert torch.equal(first.segments, second.segments)


def _generator(at: int, number: int) -> Change:
    """Return a change of the 32-bit number at a byte of a random generator's state."""

    def change(state: Tensor) -> Tensor:
        data = state.numpy().copy()
        data[at : at + 4] = np.frombuffer(np.int32(number).tobytes(), np.uint8)
        return torch.from_numpy(data)

    return change


IMPOSSIBLE: dict[str, tuple[str, Path, Change]] = {
    "at the end": ("default", ("iteration",), lambda _: 24),
    "not begun": ("default", ("iteration",), lambda _: 0),
    "after the end": ("timed", ("iteration_count",), lambda _: 16),
    "longer than the settings": ("timed", ("iteration_count",), lambda _: 25),
    "shorter without a time budget": ("default", ("iteration_count",), lambda _: 20),
    "a first iteration longer than all": ("default", ("first_seconds",), lambda _: 1e6),
    "an age above the iteration": ("default", ("population", "age"), lambda ages: ages + 16),
    "two paths of one number": ("default", ("population", "serial"), lambda serial: serial * 0),
    "a number that was not given yet": ("default", ("population", "serial"), lambda serial: serial + 10**6),
    "more created than there was time for": ("default", ("population", "created"), lambda _: 10**6),
    "paths of a later generation": ("default", ("population", "live", "generation"), lambda values: values + 9),
    "fewer paths than the generation has": ("default", ("policy", "generation"), lambda _: 0),
    "a generation that is not due": ("default", ("policy", "generation"), lambda _: 9),
    "a turn that is not due": ("refined levels", ("policy", "turn"), lambda _: 17),
    "more missing than there can be": ("replacement", ("policy", "missing"), lambda _: 13),
    "a replacement in each iteration": ("replacement", ("policy", "generation"), lambda _: 17),
    "random numbers beyond the last": ("default", ("policy", "generator"), _generator(16, 700)),
    "random numbers after the last": ("default", ("policy", "generator"), _generator(8, 624)),
    "random numbers of another seed": ("default", ("policy", "generator"), _generator(0, 1)),
    "an entry that is not there": ("palette", ("population", "palette", "entry"), lambda entries: entries + 3),
    "another given palette": ("given palette", ("population", "palette", "free"), lambda colors: colors.flip(0)),
    "steps of a given palette": ("given palette", ("population", "palette", "optimizer"), lambda _: {"step": 1}),
    "a palette without a setting": ("default", ("population", "palette"), lambda _: {}),
    "translucent paths": ("palette", ("population", "live", "opacity"), lambda opacity: opacity * 0.5),
    "colours from no palette": ("palette", ("population", "live", "color"), lambda color: 1.0 - color),
    "paths elsewhere": ("default", ("population", "live", "segments"), lambda points: points + 1.0),
    "a history beyond the present": ("default", ("history", 0, "iteration"), lambda _: 17),
    "a history of the future": ("default", ("history", 0, "seconds"), lambda _: 1e8),
    "the history twice": ("default", ("history",), lambda entries: entries * 2),
    "gradients without squares": ("default", ("population", "segments"), lambda planes: planes * PLANES),
    "other settings": ("default", ("config", "lr_color"), lambda rate: 2.0 * rate),
    "other growth": ("refined levels", ("config", "initial_radius"), lambda radius: 2.0 * radius),
}  # fmt: skip
PAINTS = ("population", "live", "gradients")
STEPPED = ("population", "gradients")
IMPOSSIBLE |= {
    "an empty loop": ("refined drawing", ("population", "live", "loop_first_segment"), _with(0, 1)),
    "a path without a loop": ("refined drawing", ("population", "live", "path_first_loop"), _with(0, 1)),
    "loops that begin late": ("refined drawing", ("best", "scene", "loop_first_segment"), _with(1, 0)),
    "loops of no row": ("refined drawing", ("population", "live", "loop_first_segment"), lambda rows: rows + 1),
    "a paint of no kind": ("gradients", (*PAINTS, "kind"), _with(3, 0)),
    "a gradient that is no number": ("gradients", (*PAINTS, "geometry"), _with(math.nan, 0)),
    "gradients of the future": ("gradients", (*STEPPED, "geometry", "steps", "step"), lambda n: n + 16),
    "steps without squares": ("gradients", (*STEPPED, "end_color", "steps", "exp_avg_sq"), lambda v: v * 0.0),
    "gradients elsewhere": ("gradients", (*STEPPED, "geometry", "value"), lambda ends: ends + 0.1),
}  # fmt: skip
PLANES = torch.tensor([1.0, 1.0, 1.0, 0.0, 1.0])[:, None, None]


@pytest.mark.parametrize("name", IMPOSSIBLE)
def test_a_state_that_cannot_be_is_refused(name: str) -> None:
    kind, path, change = IMPOSSIBLE[name]
    assert _case(kind).refusal(path, change) is not None
