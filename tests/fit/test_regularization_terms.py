"""The regularizers of cubics against closed forms and scalar versions."""

import itertools
import math

import pytest
import torch
from regularization_cases import HEIGHT, LARGE, WIDTH, polygon, random_points, sine, to_pixels

from warpvec.config.fit_config import FitConfig
from warpvec.fit.regularization import bezier_loss, opacity_loss, regularization, xing_loss
from warpvec.geometry.circles import circle_points
from warpvec.kernels.constants import LEG_MIN, TIP_PARAMETER, XING_SCALE


def circles():
    center = torch.tensor([[100.0, 90.0], [60.0, 120.0]], dtype=torch.float64)
    return circle_points(center, torch.tensor([50.0, 20.0], dtype=torch.float64), 4)


def test_opacity_is_the_mean_distance_to_one():
    assert opacity_loss(torch.tensor([1.0, 0.5, 0.0])).item() == pytest.approx(0.5)
    assert opacity_loss(torch.ones(4)).item() == 0.0


# Xing


def scalar_xing(points):
    """Return LIVE's loss without its factor, by a loop, for paths without short legs."""
    losses = []
    for path in points.tolist():
        for start in range(0, len(path), 3):
            corners = [path[(start + k) % len(path)] for k in range(4)]
            legs = [(q[0] - p[0], q[1] - p[1]) for p, q in itertools.pairwise(corners)]
            d1, d2 = sine(legs[0], legs[1]) >= 0.0, sine(legs[0], legs[2])
            losses.append(max(-d2, 0.0) if d1 else max(d2, 0.0))
    return sum(losses) / len(losses)


@pytest.mark.parametrize("segment_count", [2, 4, 5])
def test_xing_follows_the_loop(segment_count):
    points = random_points(30, segment_count)
    expected = scalar_xing(points)
    assert expected > 0.1
    assert xing_loss(points).item() == pytest.approx(expected, rel=1e-12)


def test_xing_of_convex_paths_is_zero():
    assert xing_loss(circles()).item() == 0.0
    # Straight cubics turn by rounding errors only.
    assert xing_loss(polygon((10, 10), (90, 10), (90, 60), (10, 60))).item() < 1e-15


@pytest.mark.parametrize("mirror", [1.0, -1.0])
def test_xing_of_an_s_bend_is_the_sine_of_its_ends(mirror):
    # AB to the right, BC down, CD up and to the right: 45 degrees against the turn. The way back is straight.
    bend = [(0, 0), (10, 0), (10, 10), (20, 0), (15, 0), (5, 0)]
    points = torch.tensor([bend], dtype=torch.float64) * torch.tensor([1.0, mirror])
    assert xing_loss(points).item() == pytest.approx(math.sqrt(0.5) / 2, rel=1e-12)


def test_xing_ignores_rotation_scale_and_place():
    points = random_points(20, 4)
    cosine, sine = math.cos(0.7), math.sin(0.7)
    moved = 3.0 * points @ torch.tensor([[cosine, sine], [-sine, cosine]], dtype=torch.float64) + 17.0
    assert xing_loss(moved).item() == pytest.approx(xing_loss(points).item(), rel=1e-12)


def test_xing_of_a_leg_without_direction_is_zero_and_its_gradient_too():
    bend = [(0, 0), (10, 0), (10, 10), (10, 10 - 0.5 * LEG_MIN), (5, 5), (2, 2)]
    points = torch.tensor([bend], dtype=torch.float64).requires_grad_()
    loss = xing_loss(points)
    loss.backward()
    assert loss.item() == 0.0
    assert points.grad.abs().max() == 0.0


def test_descent_on_xing_untangles_an_s_bend():
    points = torch.tensor([[(0, 0), (10, 0), (10, 10), (20, 0), (15, 0), (5, 0)]], dtype=torch.float64).requires_grad_()
    optimizer = torch.optim.SGD([points], lr=20.0)
    for _ in range(200):
        optimizer.zero_grad()
        xing_loss(points).backward()
        optimizer.step()
    assert xing_loss(points).item() < 1e-3


# The Bezier regularizer


def test_bezier_of_a_smooth_path_on_the_canvas_is_zero():
    assert bezier_loss(circles(), WIDTH, HEIGHT).item() == 0.0
    assert bezier_loss(polygon((10, 10), (90, 10), (90, 60), (10, 60)), WIDTH, HEIGHT).item() < 1e-15


def test_projection_of_two_curves_is_the_original():
    # Two curves share their chord, as in Bezier Splatting, so its own formula applies.
    inner = [(-0.6, 0.1), (0.0, 0.1), (0.6, -0.05), (0.1, -0.2)]
    points = to_pixels([(-0.5, 0.0), *inner[:2], (0.5, 0.0), *inner[2:]])
    shares = [x + 0.5 for x, _ in inner]
    expected = 0.01 * sum(max(a - 1, 0.0) ** 2 + max(-a, 0.0) ** 2 for a in shares)
    assert bezier_loss(points, *LARGE).item() == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(
    "inner", [((-0.7, 0.3), (0.1, 0.3)), ((0.7, 0.3), (0.2, 0.3)), ((-0.2, 0.3), (-0.7, 0.3)), ((0.1, 0.3), (0.7, 0.3))]
)
def test_projection_of_each_inner_point_beyond_each_end(inner):
    start, end, back = (-0.5, 0.0), (0.5, 0.0), [(0.5, -0.4), (-0.5, -0.4)]
    points = to_pixels([start, *inner, end, *back])

    def extent_of(corners):
        return max(1.0, sum(math.dist(p, q) ** 2 for p, q in itertools.pairwise(corners)))

    extent = (extent_of([start, *inner, end]) + extent_of([end, *back, start])) / 2
    expected = 0.01 * ((0.7 - 0.5) / extent) ** 2
    assert bezier_loss(points, *LARGE).item() == pytest.approx(expected, rel=1e-6)


def test_projection_divides_by_the_mean_squared_chord_of_the_path():
    # A rectangle with chords 0.8 and 0.4, and one handle on a long chord, 0.1 beyond its end.
    points = polygon((-0.4, 0.0), (0.4, 0.0), (0.4, 0.4), (-0.4, 0.4))
    points[0, 2, 0] = 0.5
    expected = 0.01 * (0.1 * 0.8 / ((0.8**2 + 0.4**2) / 2)) ** 2
    assert bezier_loss(to_pixels(points), *LARGE).item() == pytest.approx(expected, rel=1e-6)


def test_projection_divides_by_the_control_polygon_where_that_is_larger():
    # The same with the handle a whole chord beyond its end: legs of 0.8 / 3, 5 * 0.8 / 3 and 0.8.
    points = polygon((-0.4, 0.0), (0.4, 0.0), (0.4, 0.4), (-0.4, 0.4))
    points[0, 2, 0] = 1.2
    legs = (0.8 / 3) ** 2 + (5 * 0.8 / 3) ** 2 + 0.8**2
    expected = 0.01 * (0.8 * 0.8 / ((legs + 0.8**2 + 2 * 0.4**2) / 4)) ** 2
    assert bezier_loss(to_pixels(points), *LARGE).item() == pytest.approx(expected, rel=1e-6)


def test_projection_is_damped_for_a_path_of_a_few_pixels():
    # A lens with a chord of 5 px along e on a square canvas of 200 px; one handle is 0.3 px beyond the end. The added
    # pixel is 1^2 + 1^2 beside the chord's 5^2.
    e, n = torch.tensor([0.6, 0.8]), torch.tensor([-0.8, 0.6])
    outline = [(0.0, 0.0), (1.2, 1.2), (5.3, 1.2), (5.0, 0.0), (3.8, -1.2), (1.2, -1.2)]
    points = torch.stack([50 + x * e + y * n for x, y in outline]).double()[None]
    assert bezier_loss(points, 200, 200).item() == pytest.approx(0.01 * (0.3 * 5 / (25 + 2)) ** 2, rel=1e-4)


def test_projection_is_a_mean_over_paths():
    one = to_pixels([(-0.5, 0.0), (-0.7, 0.2), (0.6, 0.3), (0.5, 0.0), (0.9, -0.3), (0.1, -0.2)])
    both = torch.cat([one, one])
    assert bezier_loss(both, *LARGE).item() == pytest.approx(bezier_loss(one, *LARGE).item())


def test_tips_count_below_sixty_degrees_only():
    # A right-angled triangle: two corners of 45 degrees, with legs 0.5 and the hypotenuse between them.
    triangle = [(-0.25, -0.25), (0.25, -0.25), (-0.25, 0.25)]
    points = to_pixels(polygon(*triangle))
    leg, hypotenuse = 0.5, 0.5 * math.sqrt(2)
    # |u + w|^2 by the law of cosines: straight cubics with inner points at the thirds are linear in their parameter.
    one_tip = TIP_PARAMETER**2 * (leg**2 + hypotenuse**2 + 2 * leg * hypotenuse * math.sqrt(0.5))
    assert bezier_loss(points, *LARGE).item() == pytest.approx(2 * one_tip / 3, rel=1e-9)


def test_a_sliver_has_a_tip_at_both_ends():
    points = to_pixels(polygon((-0.5, 0.1), (0.5, 0.1)))
    assert bezier_loss(points, *LARGE).item() == pytest.approx((2 * TIP_PARAMETER) ** 2, rel=1e-9)


def test_a_curved_tip_is_probed_on_the_curve():
    # A leaf, symmetric about the axis of x: its tip at 0 opens by (x, y) and (x, -y) on the curve, its round end by
    # more than 60 degrees.
    points = [(0.0, 0.0), (0.2, 0.05), (0.4, 0.4), (0.5, 0.0), (0.4, -0.4), (0.2, -0.05)]
    t, s = TIP_PARAMETER, 1 - TIP_PARAMETER
    x = 3 * s * s * t * 0.2 + 3 * s * t * t * 0.4 + t**3 * 0.5
    assert bezier_loss(to_pixels(points), *LARGE).item() == pytest.approx((2 * x) ** 2 / 2, rel=1e-9)


def test_anchors_are_penalized_off_the_canvas():
    square = polygon((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))
    shifted = to_pixels(square + torch.tensor([0.8, -0.6]))
    # Two of four anchors are 0.3 beyond the right border, two 0.1 above the upper one.
    assert bezier_loss(shifted, *LARGE).item() == pytest.approx((2 * 0.3 + 2 * 0.1) / 8, rel=1e-6)


def test_handles_may_leave_the_canvas():
    ellipse = circles()[:1] - torch.tensor([49.999, 0.0])
    ellipse[0, 5:8, 0] = torch.tensor([-20.0, 0.5, -20.0])
    inside = ellipse.clone()
    inside[0, [5, 7], 0] = 0.5
    assert bezier_loss(ellipse, WIDTH, HEIGHT).item() == pytest.approx(bezier_loss(inside, WIDTH, HEIGHT).item())


# The sum


def test_regularization_is_the_weighted_sum():
    points, opacity = random_points(6, 4), torch.linspace(0, 1, 6, dtype=torch.float64)
    config = FitConfig(opacity_weight=0.5, xing_weight=0.25, bezier_weight=2.0)
    expected = (
        0.5 * opacity_loss(opacity) + 0.25 * XING_SCALE * xing_loss(points) + 2.0 * bezier_loss(points, WIDTH, HEIGHT)
    )
    assert regularization(points, opacity, WIDTH, HEIGHT, config).item() == pytest.approx(expected.item(), rel=1e-14)
