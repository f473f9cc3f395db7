"""Fits with the splat renderer, paths of two sides, the policy "replacement" and the presets of the papers."""

import pytest
import torch
from finished_fits import final_psnr, rendered_psnr, run
from pictures import picture

from warpvec.config.presets import make_config
from warpvec.fit.loop import fit
from warpvec.geometry.bezier import path_boxes
from warpvec.watch.watch import Watch

SPLAT = {"renderer": "splat", "samples": 16, "lines": 6}


@pytest.mark.parametrize(("path_model", "degree", "point_count"), [("segments", 3, 12), ("sides", 5, 10)])
@pytest.mark.parametrize("policy", ["scaffolding", "replacement"])
def test_splat_fits_with_every_policy(policy, path_model, degree, point_count):
    result = run(**SPLAT, policy=policy, path_model=path_model)
    scene = result.scene
    assert scene.points.shape == (48, point_count, 2)
    assert scene.degree == degree
    assert scene.points.isfinite().all()
    assert final_psnr(result) > result.history[0]["psnr"] + 0.5
    assert final_psnr(result) == pytest.approx(rendered_psnr(scene, **SPLAT), abs=0.5)


def test_the_baseline_fits():
    result = fit(
        picture(),
        make_config("bezier-splatting", curves=32, iterations=40, threads=1, lr_scale=20.0, shorten_gap=False),
    )
    assert len(result.scene) == 32
    assert result.scene.segments.isfinite().all()
    assert final_psnr(result) > result.history[0]["psnr"] + 0.5


@pytest.mark.parametrize("switch", [{"interior_gradient": False}, {"covariance_gradient": True}, {"lines": 7}])
def test_settings_of_splat_reach_the_renderer(switch):
    settings = {**SPLAT, "iterations": 5}
    assert not torch.equal(run(**settings).scene.segments, run(**{**settings, **switch}).scene.segments)


@pytest.mark.parametrize("preset", ["paper", "paper-released"])
def test_the_presets_of_the_paper_fit(preset):
    result = fit(picture(), make_config(preset, curves=32, iterations=40, threads=1))
    assert final_psnr(result) > 15.0
    assert result.scene.segments.isfinite().all()


def test_the_order_by_area_holds_from_the_first_step_to_the_last_frame():
    config = make_config("bezier-splatting", curves=20, iterations=3, threads=1, lr_scale=50.0)
    seen = []
    result = fit(picture(), config, Watch(lambda progress: seen.append(progress.scene())).part())
    box = path_boxes(result.scene)
    assert ((box[:, 2:] - box[:, :2]).prod(-1).diff() <= 0).all()
    assert torch.equal(seen[-1].segments, result.scene.segments)
