"""The kernels that place new paths: against the reference, and to the last bit what a fit without them draws."""

from __future__ import annotations

import pytest
import torch
from reference import places as reference
from scenes import seeded

from warpvec.fit import places
from warpvec.fit.placement import BLOCK, BLUR_REACH, BLUR_SIGMA, sample_positions
from warpvec.fit.places import Places, _numbers


def errors(shape: tuple[int, int], dtype: torch.dtype, device: str) -> torch.Tensor:
    """Return errors of very different sizes, some of which are none."""
    error = torch.rand(shape, generator=seeded(), dtype=torch.float64) ** 6
    error.view(-1)[3], error.view(-1)[17], error.view(-1)[29] = -2.0, torch.nan, torch.inf
    return error.to(device, dtype)


@pytest.mark.parametrize("shape", [(37, 61), (1, 3000), (40, 1), (90, 128)])
def test_pixels_are_those_of_the_reference(shape: tuple[int, int], device: str) -> None:
    error = errors(shape, torch.float64, device)
    numbers = _numbers(20, seeded(5))
    center, redraw = Places(device)._drawn(error, numbers.to(device))
    weights = reference.blurred(error.cpu().numpy(), BLUR_SIGMA, int(BLUR_REACH * BLUR_SIGMA)).flatten()
    pixels = sorted(reference.drawn(weights, numbers.numpy(), BLOCK))
    assert bool(redraw.numpy()[0]) == (len(set(pixels)) < len(pixels)) == (shape == (40, 1))
    if shape == (40, 1):  # a pixel is drawn twice
        return
    x, y = center.cpu().floor().long().unbind(1)
    assert (shape[1] * y + x).tolist() == [pixels[rank] for rank in numbers[:, 2].argsort().tolist()]
    assert torch.equal(center.cpu() - center.cpu().floor(), (numbers[:, 3:] + center.cpu().floor()) % 1.0)


@pytest.mark.parametrize(("shape", "count"), [((128, 192), 5), ((50, 70), 300), ((3, 4), 12), ((2, 2), 9), ((6, 6), 0)])
def test_the_last_bit_is_that_of_a_fit_without_kernels(shape: tuple[int, int], count: int, device: str) -> None:
    error, own = errors(shape, torch.float32, device) if min(shape) > 4 else torch.zeros(shape), Places(device)
    got, want = seeded(2), seeded(2)
    for _ in range(3):
        found = own.draw(error.to(device), count, got)
        assert torch.equal(found, sample_positions(error.to(device), count, want))
        assert torch.equal(got.get_state(), want.get_state())


def test_hardly_any_draw_is_repeated(device: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(places, "sample_positions", lambda *args: pytest.fail("drawn by torch"))
    assert len(Places(device).draw(errors((128, 192), torch.float32, device), 5, seeded(1))) == 5
