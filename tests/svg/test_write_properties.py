"""Properties of the SVG writer for any scene, checked with svgelements, warpvec's own reader and resvg."""

from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import svgelements
import torch
from compound import split_into_loops
from drawn import EIGHT_BIT, antialiasing_bound, exact_and_drawn
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray
from scenes import SceneTensors

from warpvec.geometry.circles import circle_points
from warpvec.geometry.gradients import Gradients
from warpvec.geometry.paints.registry import ELLIPTIC, FLAT, RADIAL
from warpvec.geometry.scene import Scene, straightened
from warpvec.geometry.stops import STOPS_MAX, Stops
from warpvec.geometry.structure import Structure
from warpvec.svg.quantize import quantize
from warpvec.svg.read import read_svg
from warpvec.svg.write import write_svg

SIZE = 48

# The same examples on every machine; no deadline, since the first example compiles kernels.
any_scene = settings(max_examples=100, derandomize=True, deadline=None, database=None)

# Half ticks, which must round the same way everywhere, points off the canvas, and any other values.
coordinates = st.one_of(
    st.sampled_from([0.0, 0.005, 0.05, 24.995, 47.45, -0.015, -30.0, 80.0]), st.floats(-30, 80, width=32)
)
# Ends of gradients: those that round to nothing, and those of which nothing can be drawn.
ends = st.sampled_from([0.0, -3.0, 0.04, 0.06, 1e-3, 7e13, float("nan"), float("inf"), 3e38])
shares = st.one_of(st.sampled_from([0.0, 1.0, 0.004, 0.005, 0.5, 0.99, 0.996]), st.floats(0, 1, width=32))
generations = st.sampled_from([0, 0, 1, 2, 11])


@st.composite
def scenes(draw: st.DrawFn) -> Scene:
    """Draw scenes of up to six paths with up to five cubics; points repeat often, so that some cubics degenerate."""
    count, segments = draw(st.integers(0, 6)), draw(st.integers(1, 5))
    transparent = draw(st.booleans())
    background = torch.zeros(3) if transparent else floats(draw, (3,), shares)
    return Scene.uniform(
        points=floats(draw, (count, 3 * segments, 2), coordinates),
        color=floats(draw, (count, 3), shares),
        opacity=floats(draw, (count,), shares),
        background=background,
        generation=torch.tensor([draw(generations) for _ in range(count)], dtype=torch.int64),
        transparent=transparent,
    )


def floats(draw: st.DrawFn, shape: tuple[int, ...], elements: st.SearchStrategy[float]) -> torch.Tensor:
    return torch.from_numpy(draw(arrays(np.float32, shape, elements=elements)))


def drawn_cubics(points: torch.Tensor) -> NDArray[np.float64]:
    """Return anchor, two handles and end of each cubic [k, 4, 2] of one path, without those of no length."""
    cubics = torch.cat([points, points[:1]]).double().unfold(0, 4, 3).transpose(1, 2)
    drawn = (cubics != cubics[:, :1]).any(1).any(1)
    return cubics[drawn].numpy()


def read_by_svgelements(text: str) -> list[svgelements.Path]:
    return [
        element for element in svgelements.SVG.parse(io.StringIO(text)).elements() if type(element).__name__ == "Path"
    ]


def parsed_cubics(path: svgelements.Path) -> NDArray[np.float64]:
    curves = [[segment[k] for k in range(4)] for segment in path if isinstance(segment, svgelements.CubicBezier)]
    assert {type(segment).__name__ for segment in path} == {"Move", "CubicBezier", "Close"}
    found = np.array([[(point.x, point.y) for point in curve] for curve in curves])
    return found[(found != found[:, :1]).any((1, 2))]


@any_scene
@given(scenes(), st.integers(0, 4))
def test_a_parser_that_is_not_ours_reads_the_quantized_scene(scene, precision):
    quantized = quantize(scene, precision)
    paths = read_by_svgelements(write_svg(scene, SIZE, SIZE, precision=precision))
    assert len(paths) == len(quantized)
    for row, path in enumerate(paths):
        # 1e-5 is the rounding of float32 at 80; svgelements adds in float64.
        np.testing.assert_allclose(parsed_cubics(path), drawn_cubics(quantized.points[row]), rtol=0, atol=1e-5)
        color = [path.fill.red, path.fill.green, path.fill.blue]
        assert color == (quantized.color[row].double() * 255).round().tolist()
        opacity = float(path.values.get("fill-opacity", 1))
        assert np.float32(opacity) == quantized.opacity[row].numpy()


@any_scene
@given(scenes(), st.integers(0, 4))
def test_our_reader_gives_back_the_quantized_scene(scene, precision):
    text = write_svg(scene, SIZE, SIZE, precision=precision)
    quantized, drawing = quantize(scene, precision), read_svg(text)
    read = drawing.scene
    assert read.transparent == quantized.transparent and drawing.omitted == []
    for name in ("color", "opacity", "background", "generation"):
        assert torch.equal(getattr(read, name), getattr(quantized, name)), name
    for (got,), want in zip(split_into_loops(read.segments, read.structure), quantized.points, strict=True):
        assert np.array_equal(drawn_cubics(got.flatten(0, 1)), drawn_cubics(want))
    assert write_svg(read, SIZE, SIZE, precision=precision) == text


@st.composite
def stops_of(draw: st.DrawFn, count: int) -> Stops:
    """Draw the stops of paths, with offsets out of order and beyond [0, 1], and any breadth."""
    number = torch.tensor(draw(st.lists(st.integers(2, STOPS_MAX), min_size=count, max_size=count)), dtype=torch.int32)
    offset, opacity = floats(draw, (count, STOPS_MAX), shares), floats(draw, (count, STOPS_MAX), shares)
    inner = floats(draw, (count, STOPS_MAX - 2, 3), shares)
    return Stops(number, offset, inner, opacity, floats(draw, (count,), st.one_of(coordinates, ends)))


@st.composite
def scenes_of_loops(draw: st.DrawFn) -> Scene:
    """Draw scenes of up to four paths with several loops, lines and paints; some rows, lines and gradients degenerate.

    A third of the scenes have paths of one loop without lines, as those of a fit.
    """
    is_simple = draw(st.sampled_from([True, False, False]))
    loop_counts = st.just(1) if is_simple else st.integers(1, 3)
    counts = [
        draw(st.lists(st.integers(1, 4), min_size=k, max_size=k)) for k in draw(st.lists(loop_counts, max_size=4))
    ]
    count, rows = len(counts), sum(map(sum, counts))
    is_line = None if is_simple else torch.tensor(draw(st.lists(st.booleans(), min_size=rows, max_size=rows))).bool()
    structure = Structure.of_loops(counts, is_line)
    has_stops = draw(st.booleans())
    kinds = st.lists(st.integers(FLAT, ELLIPTIC if has_stops else RADIAL), min_size=count, max_size=count)
    kind = torch.tensor(draw(kinds), dtype=torch.int32)
    geometry = floats(draw, (count, 4), st.one_of(coordinates, ends))
    stops = draw(stops_of(count)) if has_stops else None
    gradients = draw(st.sampled_from([None, Gradients(kind, geometry, floats(draw, (count, 3), shares), stops)]))
    return Scene(
        segments=straightened(floats(draw, (rows, 3, 2), coordinates), structure),
        structure=structure,
        color=floats(draw, (count, 3), shares),
        opacity=floats(draw, (count,), shares),
        background=floats(draw, (3,), shares),
        generation=torch.tensor([draw(generations) for _ in range(count)], dtype=torch.int64),
        gradients=gradients,
    )


def drawn_rows(scene: Scene) -> list[list[tuple[NDArray[np.float64], list[bool]]]]:
    """Return anchor, handles and end [k, 4, 2] of each row of each loop of each path, and whether it is a line.

    Rows of no length are left out.
    """
    structure = scene.structure
    ends = scene.segments[structure.segment_next.long(), :1]
    is_line = torch.zeros(len(ends), dtype=torch.bool) if structure.is_line is None else structure.is_line
    rows = torch.cat([scene.segments, ends, is_line[:, None, None].expand(-1, 1, 2)], 1).double()
    drawn = [
        [loop[(loop[:, :4] != loop[:, :1]).any(2).any(1)] for loop in p] for p in split_into_loops(rows, structure)
    ]
    return [[(loop[:, :4].numpy(), loop[:, 4, 0].bool().tolist()) for loop in path] for path in drawn]


def paints_of(scene: Scene) -> dict[str, torch.Tensor]:
    """Return the tensors of the gradients by name; those of flat paths are 0."""
    values = scene.gradients.to_dict()
    values |= values.pop("stops", {})
    is_flat = scene.gradients.kind == FLAT
    shapes = {name: (-1, *[1] * (value.ndim - 1)) for name, value in values.items()}
    return {name: torch.where(is_flat.view(shapes[name]), 0, value) for name, value in values.items()}


@any_scene
@given(scenes_of_loops(), st.integers(0, 4))
def test_loops_lines_and_gradients_are_read_back_and_written_to_the_same_bytes(scene, precision):
    text = write_svg(scene, SIZE, SIZE, precision=precision)
    quantized, drawing = quantize(scene, precision), read_svg(text)
    read = drawing.scene
    assert drawing.omitted == [] and drawing.precision is not None
    for name in ("color", "opacity", "background", "generation"):
        assert torch.equal(getattr(read, name), getattr(quantized, name)), name
    for got_path, want_path in zip(drawn_rows(read), drawn_rows(quantized), strict=True):
        for (got, got_lines), (want, want_lines) in zip(got_path, want_path, strict=True):
            assert np.array_equal(got, want) and got_lines == want_lines
    assert (read.gradients is None) == (quantized.gradients is None)
    if read.gradients is not None and quantized.gradients is not None:
        got_paints, want_paints = (paints_of(scene) for scene in (read, quantized))
        for name, value in want_paints.items():
            assert torch.equal(got_paints[name], value), name
        assert not quantized.gradients.is_degenerate().any()
    assert write_svg(read, SIZE, SIZE, precision=precision) == text
    again = quantize(quantized, precision)
    assert torch.equal(again.segments, quantized.segments)
    assert write_svg(quantized, SIZE, SIZE, precision=precision) == text


@any_scene
@given(scenes())
def test_away_from_edges_resvg_draws_what_we_render(scene):
    exact, drawn = exact_and_drawn(tensors(replace(scene, transparent=False)))
    error = (exact - drawn).abs().amax(-1).numpy()
    # Each path is blended in 8 bits, which may round its colour, its alpha and their sum.
    allowed = 2 * EIGHT_BIT * (len(scene) + 1)
    assert (error[~near_edges(quantize(scene, 2))] <= allowed).all()


@st.composite
def smooth_scenes(draw: st.DrawFn) -> Scene:
    """Draw up to six round paths that do not cross themselves or the border, where resvg would split curves."""
    count = draw(st.integers(1, 6))
    radius = floats(draw, (count,), st.floats(4, 16, width=32))
    place = floats(draw, (count, 2), st.floats(0, 1, width=32))
    reach = 1.25 * radius[:, None] + 1
    bend = floats(draw, (count, 12, 2), st.floats(-0.125, 0.125, width=32))
    return Scene.uniform(
        points=circle_points(reach + place * (SIZE - 2 * reach), radius, 4) + radius[:, None, None] * bend,
        color=floats(draw, (count, 3), shares),
        opacity=floats(draw, (count,), shares),
        background=floats(draw, (3,), shares),
        generation=torch.zeros(count, dtype=torch.int64),
    )


@any_scene
@given(smooth_scenes())
def test_no_pixel_is_farther_off_than_antialiasing_explains(scene):
    scene = tensors(scene)
    exact, drawn = exact_and_drawn(scene)
    excess = (exact - drawn).abs() - antialiasing_bound(scene)
    assert excess.max() <= 1e-9, f"beyond the bound by {excess.max():.4f}"


def tensors(scene: Scene) -> SceneTensors:
    fields = (scene.points, scene.color, scene.opacity, scene.background)
    return SceneTensors(*(field.double() for field in fields), SIZE, SIZE)


def near_edges(scene: Scene) -> NDArray[np.bool_]:
    """Return the pixels [h, w] that an outline passes, and their neighbours."""
    t = np.linspace(0, 1, 2000)[:, None]
    near = np.zeros((SIZE + 2, SIZE + 2), bool)
    for points in scene.points:
        for p in drawn_cubics(points):
            curve = (1 - t) ** 3 * p[0] + 3 * t * (1 - t) ** 2 * p[1] + 3 * t**2 * (1 - t) * p[2] + t**3 * p[3]
            x, y = (np.floor(curve).astype(int) + 1).clip(0, SIZE + 1).T
            near[y, x] = True
    grown = torch.nn.functional.max_pool2d(torch.from_numpy(near).double()[None, None], 3, 1, 1)[0, 0]
    return grown.bool().numpy()[1:-1, 1:-1]
