"""What the judge of changes says of a black square on white, and which paths it lets go first."""

from __future__ import annotations

import gc
import weakref

import numpy as np
import pytest
import torch
from flat_drawings import BLACK, RED, drawing, picture

from warpvec.config.fit_config import FitConfig
from warpvec.flat.constants.simplification import SIMPLIFICATION
from warpvec.flat.simplification.critic import Critic
from warpvec.flat.simplification.fewer_paths import with_fewer_paths
from warpvec.geometry.scene import Scene


def _box(left: float, top: float, right: float, bottom: float) -> torch.Tensor:
    corners = torch.tensor([[left, top], [right, top], [right, bottom], [left, bottom]])
    share = torch.tensor([0.0, 1 / 3, 2 / 3])[None, :, None]
    return (corners[:, None] + share * (corners.roll(-1, 0) - corners)[:, None]).reshape(-1, 2)


def _scene() -> Scene:
    return drawing((BLACK, [_box(10, 10, 30, 30)]), (RED, [_box(40, 40, 44, 44)]))


def _critic(scene: Scene) -> Critic:
    return Critic(picture(scene), FitConfig(threads=1))


def test_the_memory_of_a_drawing_is_free_without_a_search_for_circles() -> None:
    """A folder is drawn by few processes, which would grow with each picture."""
    critic, was_enabled = _critic(_scene()), gc.isenabled()
    critic.error(_scene())
    critic.samples(_scene())
    buffers = weakref.ref(critic.target)
    gc.disable()
    try:
        del critic
        assert buffers() is None
    finally:
        if was_enabled:
            gc.enable()


def test_a_drawing_is_no_error_against_its_own_picture_and_a_lost_path_is_its_area() -> None:
    critic = _critic(_scene())
    assert critic.error(_scene()).max() < 1e-5
    without = critic.error(_scene().select(torch.tensor([1])))
    assert float(without.sum()) == pytest.approx(3 * 20 * 20, rel=1e-3)  # three channels from black to white
    costs = critic.removal_costs(_scene())
    contrast = sum((1 - value) ** 2 for value in RED)
    np.testing.assert_allclose(costs, [3 * 20 * 20, contrast * 16], rtol=0.01)


def test_an_outline_may_move_by_the_detail() -> None:
    """Moving an edge by d changes d pixels of each pixel of its length: d^2 times its contrast, as if blurred."""
    samples = _critic(_scene()).samples(_scene())
    np.testing.assert_allclose(samples.worth[:4], 3 * 20, rtol=0.02)
    allowed = Critic.allowed(samples.worth[:4], 0.1, SIMPLIFICATION.noise)
    np.testing.assert_allclose(allowed, 0.01 * 60 + SIMPLIFICATION.noise, rtol=0.02)


def test_the_paths_that_show_least_go_first() -> None:
    scene = _scene()
    assert with_fewer_paths(scene, _critic(scene), 1).color.tolist() == [list(BLACK)]
    assert with_fewer_paths(scene, _critic(scene), 2) is scene
