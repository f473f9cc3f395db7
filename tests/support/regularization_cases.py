"""Paths for the tests of the regularizers."""

from __future__ import annotations

import math

import torch

from warpvec.geometry.circles import circle_sides

WIDTH, HEIGHT = 300, 200

# A canvas so large that the pixel which the projection term adds to a squared chord does not matter in closed forms.
LARGE = (WIDTH * 1000, HEIGHT * 1000)


def random_points(path_count, segment_count, seed=0, dtype=torch.float64):
    """Return random control points on a canvas of 300x200 px and up to 60 px outside."""
    generator = torch.Generator().manual_seed(seed)
    low, size = torch.tensor([-60.0, -60.0], dtype=dtype), torch.tensor([420.0, 320.0], dtype=dtype)
    return low + size * torch.rand(path_count, 3 * segment_count, 2, generator=generator, dtype=dtype)


def polygon(*corners):
    """Return one closed path [1, 3 S, 2] of straight cubics, with inner control points at the thirds."""
    anchors = torch.tensor(corners, dtype=torch.float64)
    following = anchors.roll(-1, 0)
    return torch.stack([anchors, (2 * anchors + following) / 3, (anchors + 2 * following) / 3], 1).reshape(1, -1, 2)


def sine(u, v):
    """Return the sine of the angle from ``u`` to ``v``, two vectors in the plane."""
    return (u[0] * v[1] - u[1] * v[0]) / (math.hypot(*u) * math.hypot(*v))


def to_pixels(normalised, canvas=LARGE):
    """Convert coordinates in which the canvas is [-1, 1] to pixels [1, P, 2]."""
    return (torch.as_tensor(normalised, dtype=torch.float64).view(1, -1, 2) + 1) * torch.tensor(canvas) / 2


# Most are degenerate: zero-length legs, coincident anchors, all points in one place, straight and axis-parallel legs.
CUBIC_SCENES = {
    "random": random_points(40, 4),
    "two_segments": random_points(9, 2),
    "five_segments": random_points(11, 5),
    # 7 px away from the canvas's borders, where rounding would decide the gradient of the anchor term.
    "on_a_coarse_grid": (random_points(40, 4, seed=1) / 60).round() * 60 + 7,
    "all_points_equal": random_points(5, 4, seed=2)[:1, :1].expand(5, 12, 2).contiguous(),
    "coincident_anchors": random_points(6, 4, seed=3).index_fill(1, torch.tensor([0, 3, 6, 9]), 77.0),
    "short_legs": random_points(20, 4, seed=4).round() * 0.005 + 50.0,
    "straight": polygon((10.0, 20.0), (200.0, 20.0), (200.0, 150.0)),
    "no_paths": random_points(0, 4),
}


def scattered(path_count, degree=5, seed=0):
    """Return random control points of two sides, on the canvas and up to 60 px outside."""
    generator = torch.Generator().manual_seed(seed)
    size = torch.tensor([WIDTH + 120.0, HEIGHT + 120.0], dtype=torch.float64)
    return torch.rand(path_count, 2 * degree, 2, generator=generator, dtype=torch.float64) * size - 60


def wobbly(path_count, degree=5, wobble=0.1, seed=0):
    """Return circles of 20 to 40 px on the canvas, with control points moved by about ``wobble`` radii."""
    generator = torch.Generator().manual_seed(seed)
    center = torch.rand(path_count, 2, generator=generator, dtype=torch.float64) * torch.tensor([WIDTH, HEIGHT])
    radius = 20 + 20 * torch.rand(path_count, generator=generator, dtype=torch.float64)
    points = circle_sides(center, radius, degree)
    noise = torch.randn(points.shape, generator=generator, dtype=torch.float64)
    return points + wobble * radius[:, None, None] * noise


def with_points_at(points, indices, target):
    """Return ``points`` with those at ``indices`` moved to the point at index ``target``."""
    return points.index_copy(1, torch.tensor(indices), points[:, [target] * len(indices)])


SIDE_SCENES = {
    "wobbly": wobbly(8),
    "wild": wobbly(8, wobble=0.6),
    "scattered": scattered(20),
    "degree_1": wobbly(5, 1),
    "degree_2": wobbly(5, 2),
    "degree_4": wobbly(5, 4),
    "degree_7": wobbly(5, 7),
    "coincident_points": with_points_at(wobbly(4), [1, 9], 0),
    "doubled_points": with_points_at(with_points_at(wobbly(4), [3], 2), [6], 5),
    "zero_chord": with_points_at(wobbly(4), [5], 0),
    "all_points_equal": wobbly(3)[:, :1].expand(3, 10, 2).contiguous(),
    "one_side_in_a_point": with_points_at(wobbly(4), [1, 2, 3, 4, 5], 0),
    "short_legs": wobbly(4) * 1e-4 + 50.0,
    "no_paths": wobbly(0),
}
