"""Fits of a small picture."""

import math

from pictures import HEIGHT, WIDTH, picture

from warpvec.config.presets import make_config
from warpvec.fit.loop import fit
from warpvec.watch.watch import Watch


def run(on_progress=None, **settings):
    config = make_config("default", **{"curves": 48, "iterations": 60, "inflation_gap": 8, "threads": 1} | settings)
    return fit(picture(), config, Watch(on_progress, config.time_budget).part())


def final_psnr(result):
    return result.history[-1]["psnr"]


def rendered_psnr(scene, **settings):
    from warpvec.rendering.operator import render

    error = render(scene, HEIGHT, WIDTH, **settings) - picture()
    return -10 * math.log10(error.square().mean().item())
