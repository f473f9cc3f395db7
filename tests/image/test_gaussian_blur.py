"""The blur of a picture is SciPy's, with a mirror at its border, and its own adjoint."""

from __future__ import annotations

import torch
from scipy.ndimage import gaussian_filter
from sweep import sweep

from warpvec.image.gaussian_blur import REACH, GaussianBlur

SIZES = [(20, 31), (3, 50), (1, 1)]


def random_image(size: tuple[int, int], seed: int) -> torch.Tensor:
    return torch.randn(*size, 3, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)


@sweep(("size", "deviation"), [(size, deviation) for size in SIZES for deviation in (0.4, 1.0, 2.7)])
def test_it_blurs_as_scipy_does(size: tuple[int, int], deviation: float) -> None:
    image = random_image(size, 1)
    reach = int(torch.tensor(REACH * deviation).ceil())
    expected = gaussian_filter(image.numpy(), (deviation, deviation, 0.0), mode="reflect", radius=(reach, reach, 0))
    torch.testing.assert_close(GaussianBlur(deviation)(image), torch.from_numpy(expected))


@sweep(("size", "deviation"), [(size, deviation) for size in SIZES for deviation in (0.4, 2.7)])
def test_it_is_its_own_adjoint(size: tuple[int, int], deviation: float) -> None:
    blur, one, other = GaussianBlur(deviation), random_image(size, 1), random_image(size, 2)
    torch.testing.assert_close((blur(one) * other).sum(), (one * blur(other)).sum())


def test_the_share_of_an_edge_is_what_a_small_move_of_it_costs() -> None:
    for deviation in (1.0, 2.0):
        rise = []
        for move in (0.0, 0.1):
            row = (torch.arange(80, dtype=torch.float64) + 0.5 - 40.3 - move).clamp(-0.5, 0.5) + 0.5
            rise.append(GaussianBlur(deviation)(row[None, :, None]))
        share = float((rise[1] - rise[0]).square().sum()) / 0.1**2
        assert abs(share / GaussianBlur(deviation).edge_share - 1.0) < 0.05
