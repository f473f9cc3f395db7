"""Lines of pictures become strokes along their middle, each once, with the widths of the picture."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from line_pictures import picture

from warpvec.config.fit_config import FitConfig
from warpvec.flat.lines.line import DrawnLine
from warpvec.flat.lines.tracing import trace_lines
from warpvec.geometry.forms.registry import CIRCLE
from warpvec.watch.watch import Watch

CONFIG = FitConfig(threads=1, device="cpu", mode="lines")


def lines_of(shapes: str) -> list[DrawnLine]:
    with torch.no_grad():
        return trace_lines(picture(shapes), CONFIG, None, Watch()).lines


def test_lines_of_two_widths_that_cross_are_two_lines() -> None:
    thin, bold = sorted(
        lines_of('<path d="M16 40L112 88" stroke-width="3"/><path d="M64 16V112" stroke-width="8"/>'),
        key=lambda line: line.width,
    )
    assert (thin.width, bold.width) == (pytest.approx(3.0, abs=0.15), pytest.approx(8.0, abs=0.15))
    ends = np.array(sorted(map(tuple, thin.ends())))
    assert np.abs(ends - [[16.0, 40.0], [112.0, 88.0]]).max() < 0.3


def test_a_diagonal_line_and_a_ring_stay_whole() -> None:
    ring, line = sorted(
        lines_of('<circle cx="40" cy="90" r="24" stroke-width="5"/><path d="M50 10L110 70" stroke-width="5"/>'),
        key=lambda line: line.rows.is_open,
    )
    assert not ring.rows.is_open and line.rows.is_open
    assert np.abs(np.linalg.norm(ring.rows.control[:, 0] - [40.0, 90.0], axis=1) - 24.0).max() < 0.1
    assert ring.width == line.width == pytest.approx(5.0, abs=0.1)


def test_a_circle_that_lines_cross_is_a_circle() -> None:
    shapes = '<circle cx="60" cy="64" r="30"/><path d="M10 64H118M60 20V64"/>'
    (ring,) = [line for line in lines_of(f'<g stroke-width="3">{shapes}</g>') if not line.rows.is_open]
    assert ring.form is not None and ring.form.kind == CIRCLE
    assert np.abs(ring.form.parameters[:3] - [60.0, 64.0, 30.0]).max() < 0.15


def test_a_dot_is_a_line_of_no_length() -> None:
    dot, line = sorted(lines_of('<path d="M20 64H100M64 30v.01" stroke-width="7"/>'), key=lambda line: line.length)
    assert dot.length < 0.1 and np.abs(dot.ends()[0] - [64.0, 30.0]).max() < 0.1
    assert dot.width == line.width


def nodes_of(line: DrawnLine) -> set[tuple[float, float]]:
    return set(map(tuple, line.rows.control[:, 0].tolist()))


def test_lines_that_meet_share_a_node() -> None:
    shapes = '<g stroke-width="6"><path d="M14 30H114M64 30V110"/><path d="M30 60L100 90"/></g>'
    bar, stem, slash = sorted(lines_of(shapes), key=lambda line: float(line.rows.control[:, 0, 1].max()), reverse=False)
    if len(nodes_of(slash) & nodes_of(bar)):  # sorted by their lowest points: bar, slash, stem
        stem, slash = slash, stem
    shared = nodes_of(bar) & nodes_of(stem)
    assert len(shared) == 1 and np.abs(np.array([*shared]) - [64.0, 30.0]).max() < 0.1
    shared = nodes_of(slash) & nodes_of(stem)
    assert len(shared) == 1 and np.abs(np.array([*shared]) - [64.0, 60.0 + 30.0 * 34.0 / 70.0]).max() < 0.1


def test_a_disc_on_a_line_is_a_wide_area_with_an_outline() -> None:
    shapes = '<path d="M10 64H118" stroke-width="4"/><circle cx="64" cy="64" r="20" fill="#000" stroke="none"/>'
    with torch.no_grad():
        found = trace_lines(picture(shapes), CONFIG, None, Watch())
    assert found.wide_count == 1
    (ring,) = [line for line in found.lines if not line.rows.is_open]
    radii = np.linalg.norm(ring.rows.control[:, 0] - [64.0, 64.0], axis=1)
    assert np.abs(radii - 18.0).max() < 0.6
    assert ring.width == pytest.approx(4.0, abs=0.3)


def test_paper_without_ink_has_no_lines() -> None:
    assert lines_of("") == []


@pytest.mark.parametrize(
    "levels",
    [
        [[[61, 56, 52], [97, 92, 79], [65, 59, 50]], [[111, 112, 108], [104, 96, 85], [98, 86, 71]]],
        [[[76, 120, 168]]],
    ],
    ids=["of six pixels", "of one pixel"],
)
def test_ink_of_a_few_pixels_is_a_dot_at_most(levels: list[list[list[int]]]) -> None:
    picture = np.array(levels, np.float32) / 255.0
    with torch.no_grad():
        lines = trace_lines(picture, CONFIG, None, Watch()).lines
    assert len(lines) <= 1
    for line in lines:
        assert (line.rows.control > -1.0).all()
        assert (line.rows.control < np.array(picture.shape[1::-1]) + 1.0).all()
