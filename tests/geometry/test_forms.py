"""The forms of paths: rows from parameters with their derivative, parameters from an outline, and transforms."""

from __future__ import annotations

import math

import numpy as np
import pytest
import torch

from warpvec.errors import InputError
from warpvec.geometry.bezier import bernstein
from warpvec.geometry.form_slopes import form_derivative
from warpvec.geometry.forms.registry import CIRCLE, ELLIPSE, FORMS, OUTLINE, RECT, ROUND_RECT, form_of
from warpvec.geometry.path_forms import Forms, is_used
from warpvec.geometry.structure import Structure

PARAMETERS = torch.tensor([[50.0, 40.0, 20.0, 12.0, 0.3, 4.0], [-3.0, 7.5, 9.0, 11.0, -0.7, 2.0]], dtype=torch.float64)

KINDS = pytest.mark.parametrize("number", FORMS)


def parameters_of(number: int) -> torch.Tensor:
    """Some parameters [2, 6] of a form, with 0 where it has none."""
    kind = torch.full((2,), number)
    return torch.where(is_used(PARAMETERS, kind), PARAMETERS, 0.0)


def points_along(number: int, parameters: torch.Tensor) -> np.ndarray:
    """Points [K, 2] along the first of some forms."""
    rows = form_of(number).segments(parameters[:1])[0]
    cubics = torch.cat([rows, rows.roll(-1, 0)[:, :1]], 1)
    return (bernstein(3, torch.linspace(0.0, 1.0, 9, dtype=torch.float64)[:-1]) @ cubics).reshape(-1, 2).numpy()


@KINDS
def test_the_derivative_is_that_of_autograd(number: int) -> None:
    form, parameters = form_of(number), parameters_of(number)
    for row, found in zip(parameters, form.derivative(parameters), strict=True):
        whole = torch.autograd.functional.jacobian(lambda one: form.segments(one[None])[0], row)
        torch.testing.assert_close(found[..., list(form.free)], whole[..., list(form.free)], atol=1e-12, rtol=0.0)
    step = 1e-6 * torch.eye(6, dtype=torch.float64)[form.free[-1]]
    rise = (form.segments(parameters + step) - form.segments(parameters - step)) / 2e-6
    torch.testing.assert_close(form.derivative(parameters)[..., form.free[-1]], rise, atol=1e-7, rtol=0.0)


@KINDS
def test_an_outline_gives_its_parameters_back(number: int) -> None:
    form, parameters = form_of(number), parameters_of(number)
    points = points_along(number, parameters)
    fitted = form.fit(points, np.ones(len(points)))
    assert fitted is not None and fitted.distance < 4e-4 * 20  # cubics are as far off a circle, as a share of its size
    assert fitted.parameters == pytest.approx(parameters[0].numpy(), abs=4e-4 * 20)


@KINDS
def test_lines_have_their_handles_at_thirds_and_forms_go_clockwise(number: int) -> None:
    form = form_of(number)
    rows = form.segments(parameters_of(number))[0]
    ends = rows.roll(-1, 0)[:, 0]
    line = torch.tensor(form.is_line)
    torch.testing.assert_close(rows[line, 1], (rows[line, 0] * 2 + ends[line]) / 3)
    assert (rows[:, 0, 0] * ends[:, 1] - rows[:, 0, 1] * ends[:, 0]).sum() > 0


def test_the_largest_distance_is_that_of_the_worst_point() -> None:
    points = points_along(CIRCLE, parameters_of(CIRCLE))
    moved = points.copy()
    moved[0] += (0.5, 0.0)  # outwards, as it is the one at the right
    weights = np.ones(len(points))
    weights[0] = 1e-6
    fitted = form_of(CIRCLE).fit(moved, weights)
    assert fitted is not None and fitted.distance == pytest.approx(0.5, abs=0.01)
    weights[0] = 0.0  # what is hidden is no evidence
    hidden = form_of(CIRCLE).fit(moved, weights)
    assert hidden is not None and hidden.distance < 0.01


def test_a_part_of_a_circle_is_completed() -> None:
    points = points_along(CIRCLE, parameters_of(CIRCLE))
    fitted = form_of(CIRCLE).fit(points[:10], np.ones(10))
    assert fitted is not None and fitted.parameters[:3] == pytest.approx([50.0, 40.0, 20.0], abs=0.02)


def test_points_on_a_line_are_no_form() -> None:
    points = np.stack([np.arange(9.0), np.zeros(9)], 1)
    found = [form.fit(points, np.ones(9)) for form in FORMS.values()]
    assert all(each is None or each.distance > 0.1 or each.parameters[2:4].max() > 100 for each in found)


@KINDS
def test_attributes_of_a_file_give_the_parameters_back(number: int) -> None:
    form, parameters = form_of(number), parameters_of(number)
    numbers = form.numbers(parameters)
    assert numbers.shape[1] == len(form.sides)
    torch.testing.assert_close(form.parameters(numbers, parameters[:, 4]), parameters)


def forms_of_all() -> tuple[Forms, Structure]:
    kind = torch.tensor([CIRCLE, ELLIPSE, RECT, ROUND_RECT, OUTLINE], dtype=torch.int32)
    parameters = PARAMETERS[0].expand(5, 6).float()
    counts = [[form_of(number).row_count] if number else [3, 2] for number in kind.tolist()]
    return Forms(kind, torch.where(is_used(parameters, kind), parameters, 0.0)), Structure.of_loops(counts)


def test_the_curves_follow_the_parameters_as_their_derivative_says() -> None:
    forms, structure = forms_of_all()
    forms = Forms(forms.kind, forms.parameters.double())

    def curves(parameters: torch.Tensor) -> torch.Tensor:
        placed = Forms(forms.kind, parameters).placed(torch.zeros(structure.segment_count, 3, 2).double(), structure)
        return torch.cat([placed, placed[structure.segment_next.long(), :1]], 1).flatten()

    move = torch.where(is_used(forms.parameters, forms.kind), torch.randn(5, 6, dtype=torch.float64), 0.0)
    rise = (curves(forms.parameters + 1e-6 * move) - curves(forms.parameters - 1e-6 * move)) / 2e-6
    slopes = form_derivative(forms, structure) @ move.flatten().numpy()
    np.testing.assert_allclose(slopes, rise.numpy(), atol=1e-6)


def test_rows_follow_a_scale_and_a_move() -> None:
    forms, structure = forms_of_all()
    rows = forms.placed(torch.zeros(structure.segment_count, 3, 2), structure)
    scaled, moved = forms.scaled(1.5, 1.5), forms.moved(3.0, -2.0)
    assert scaled is not None
    torch.testing.assert_close(scaled.placed(rows, structure)[:20], 1.5 * rows[:20])
    torch.testing.assert_close(moved.placed(rows, structure)[:20], rows[:20] + torch.tensor([3.0, -2.0]))


def test_an_uneven_scale_makes_ellipses_of_circles_and_outlines_of_tilted_forms() -> None:
    forms, structure = forms_of_all()
    scaled = forms.scaled(2.0, 1.0)
    assert scaled is not None and scaled.kind.tolist() == [ELLIPSE, OUTLINE, OUTLINE, OUTLINE, OUTLINE]
    rows = forms.placed(torch.zeros(structure.segment_count, 3, 2), structure)
    torch.testing.assert_close(scaled.placed(rows, structure)[:4], rows[:4] * torch.tensor([2.0, 1.0]))
    nearly = forms.scaled(1.0, 1.001)
    assert nearly is not None and nearly.kind.tolist() == forms.kind.tolist()
    assert forms.scaled(-1.0, 1.0) is None


def test_a_wrong_form_is_refused() -> None:
    forms, _ = forms_of_all()
    with pytest.raises(InputError, match="one closed loop of 4 rows for a circle"):
        forms.check(Structure.of_loops([[5], [4], [4], [8], [1]]))
    with pytest.raises(InputError, match=r"must be 0 \(outline\), 1 \(circle\)"):
        list(Forms(torch.tensor([9], dtype=torch.int32), torch.zeros(1, 6)).groups())


def test_an_angle_stays_below_half_a_right_one() -> None:
    points = points_along(RECT, torch.tensor([[0.0, 0.0, 20.0, 10.0, math.radians(80), 0.0]], dtype=torch.float64))
    fitted = form_of(RECT).fit(points, np.ones(len(points)))
    assert fitted is not None
    assert fitted.parameters[2:5] == pytest.approx([10.0, 20.0, math.radians(-10)], abs=1e-6)
