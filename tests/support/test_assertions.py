"""Each assertion passes when it should, and fails on the fault that it must find."""

from __future__ import annotations

from collections.abc import Callable

import pytest
import torch
from assertions import (
    assert_close_off_edges,
    assert_grad_close,
    assert_grad_present,
    assert_same_direction,
    finite_difference,
)
from torch import Tensor

Check = Callable[[Tensor, Tensor], None]

ALL: dict[str, Check] = {
    "close": lambda got, want: assert_grad_close(got, want, 1e-3, 1e-6, "adj"),
    "present": lambda got, want: assert_grad_present(got, want, "adj"),
    "direction": lambda got, want: assert_same_direction(got, want, 0.999, "adj"),
    "off_edges": lambda got, want: assert_close_off_edges(got, want, atol=1e-3, outlier_share=0.0, outlier_atol=1.0),
}

each_assertion = pytest.mark.parametrize("check", ALL.values(), ids=ALL.keys())


def gradient() -> Tensor:
    return torch.randn(40, 6, 2, dtype=torch.float64)


@each_assertion
def test_equal_tensors_pass_in_any_precision(check: Check) -> None:
    want = gradient()
    check(want, want)
    check(want.float(), want)
    check(torch.zeros_like(want), torch.zeros_like(want))


@each_assertion
@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_values_that_are_not_finite_fail_on_either_side(check: Check, value: float) -> None:
    want = gradient()
    bad = want.clone()
    bad[3, 1, 0] = value
    for pair in ((bad, want), (want, bad), (bad, bad)):
        with pytest.raises(AssertionError, match="has 1 entries that are not finite"):
            check(*pair)


@each_assertion
def test_shapes_that_would_broadcast_fail(check: Check) -> None:
    want = gradient()
    with pytest.raises(AssertionError, match=r"got shape \[1, 6, 2\], want \[40, 6, 2\]"):
        check(want[:1], want)


@each_assertion
def test_a_flipped_sign_fails(check: Check) -> None:
    want = gradient()
    if check is ALL["present"]:
        check(-want, want)  # compares lengths only; use it together with the other two
    else:
        with pytest.raises(AssertionError):
            check(-want, want)


def test_grad_close_bounds_the_relative_distance_and_names_the_worst_entry() -> None:
    want = gradient()
    got = want * (1 + 0.9e-3)
    assert_grad_close(got, want, 1e-3, 0.0, "adj_points")
    got[7, 2, 1] += 0.1
    with pytest.raises(AssertionError, match=r"adj_points: .* worst at \[7, 2, 1\]: got .*, want "):
        assert_grad_close(got, want, 1e-3, 0.0, "adj_points")


def test_grad_close_takes_a_zero_within_the_absolute_bound() -> None:
    want = torch.zeros(5, 2, dtype=torch.float64)
    assert_grad_close(want + 1e-9, want, 1e-3, 1e-8, "adj")
    with pytest.raises(AssertionError):
        assert_grad_close(want + 1e-7, want, 1e-3, 1e-8, "adj")


def test_grad_present_finds_a_small_row_that_is_zero() -> None:
    want = gradient()
    want[5] *= 1e-4
    got = want.clone()
    got[5] = 0
    assert_grad_close(got, want, 1e-3, 0.0, "adj")
    with pytest.raises(AssertionError, match=r"adj: 1 of 40 rows have the wrong length: row 5 got 0.000e"):
        assert_grad_present(got, want, "adj")


@pytest.mark.parametrize("factor", [0.4, 2.1])
def test_grad_present_finds_a_row_of_the_wrong_length(factor: float) -> None:
    want = gradient()
    got = want.clone()
    got[11] *= factor
    with pytest.raises(AssertionError, match="row 11"):
        assert_grad_present(got, want, "adj")


def test_grad_present_finds_a_row_where_none_belongs() -> None:
    want = gradient()
    want[2] = 0
    got = want.clone()
    got[2] = 1e-7
    assert_grad_present(got, want, "adj")
    got[2] = 1e-3
    with pytest.raises(AssertionError, match="row 2"):
        assert_grad_present(got, want, "adj")


def test_grad_present_finds_a_gradient_that_should_be_zero_everywhere() -> None:
    want = torch.zeros(3, 2, dtype=torch.float64)
    got = want.clone()
    got[1, 1] = 1e-30
    with pytest.raises(AssertionError, match="row 1"):
        assert_grad_present(got, want, "adj")


def test_grad_present_takes_rows_of_single_values_and_no_rows() -> None:
    assert_grad_present(torch.ones(4), torch.ones(4), "adj_opacity")
    assert_grad_present(torch.zeros(0, 12, 2), torch.zeros(0, 12, 2), "adj_points")


def test_same_direction_ignores_the_length_and_sees_the_angle() -> None:
    want = torch.tensor([1e-200, 0.0], dtype=torch.float64)
    assert_same_direction(3e5 * want, want, 0.999, "adj")
    turned = torch.tensor([1.0, 0.1], dtype=torch.float64)
    with pytest.raises(AssertionError, match=r"adj: the cosine is 0.995037"):
        assert_same_direction(turned, want, 0.999, "adj")


def test_same_direction_fails_where_only_one_is_zero() -> None:
    want = gradient()
    for pair in ((torch.zeros_like(want), want), (want, torch.zeros_like(want))):
        with pytest.raises(AssertionError, match="one of the two is zero"):
            assert_same_direction(*pair, 0.9, "adj")


def image_with_outliers(count: int, size: float) -> tuple[Tensor, Tensor]:
    want = torch.rand(10, 20, 3)
    got = want + 5e-4
    got.view(-1, 3)[:count, 1] += size
    return got, want


def test_close_off_edges_takes_its_share_of_outliers() -> None:
    assert_close_off_edges(*image_with_outliers(4, 0.05), atol=1e-3, outlier_share=0.02, outlier_atol=0.1)


def test_close_off_edges_fails_on_one_outlier_too_many() -> None:
    with pytest.raises(AssertionError, match=r"image: 2.500% of the pixels .* 2.000% may be; worst at \[0, \d, 1\]"):
        assert_close_off_edges(*image_with_outliers(5, 0.05), atol=1e-3, outlier_share=0.02, outlier_atol=0.1)


@pytest.mark.parametrize("size", [0.2, -0.2])
def test_close_off_edges_fails_on_an_outlier_too_large(size: float) -> None:
    with pytest.raises(AssertionError, match=r"a pixel is off by more than 1.0e-01"):
        assert_close_off_edges(*image_with_outliers(1, size), atol=1e-3, outlier_share=0.02, outlier_atol=0.1)


def test_finite_difference_is_exact_on_a_quadratic() -> None:
    x = torch.tensor([[1.0, -2.0], [0.5, 3.0]], dtype=torch.float64)
    got = finite_difference(lambda value: (value**2).sum(), x, 1e-3)
    torch.testing.assert_close(got, 2 * x.flatten(), rtol=0, atol=1e-9)


def test_finite_difference_gives_the_entries_asked_for_and_leaves_the_point_alone() -> None:
    x = torch.tensor([[1.0, -2.0], [0.5, 3.0]], dtype=torch.float64, requires_grad=True)
    before = x.detach().clone()
    got = finite_difference(lambda value: value[1, 0] * value[1, 1], x, 1e-4, [3, 0])
    torch.testing.assert_close(got, torch.tensor([0.5, 0.0], dtype=torch.float64), rtol=0, atol=1e-9)
    assert torch.equal(x, before)


def test_finite_difference_refuses_single_precision() -> None:
    with pytest.raises(AssertionError, match="x must be float64"):
        finite_difference(torch.sum, torch.ones(2), 1e-3)


def test_finite_difference_steps_through_a_view() -> None:
    x = torch.arange(6, dtype=torch.float64).reshape(2, 3).T
    got = finite_difference(lambda value: (value * torch.tensor([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]])).sum(), x, 1e-3)
    torch.testing.assert_close(got, torch.arange(1.0, 7.0, dtype=torch.float64), rtol=0, atol=1e-9)
