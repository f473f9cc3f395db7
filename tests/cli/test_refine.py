"""`warpvec refine`: the paths it keeps and adds, and drawings it refuses."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
import torch
from commands import invoke
from PIL import Image

from warpvec.image.metrics import psnr
from warpvec.svg.measure import draw
from warpvec.svg.read import read_svg

FOREIGN = """<svg xmlns="http://www.w3.org/2000/svg" width="96" height="64">
<rect width="96" height="64" fill="#888"/>
<g><circle cx="30" cy="30" r="16" fill="#d33" stroke="#000"/></g>
<g transform="translate(50 0)"><polygon points="5,5 40,10 20,50" fill="#36c" fill-opacity=".5"/></g>
</svg>"""


@pytest.fixture
def photo(tmp_path: Path) -> Path:
    """A disc and a ramp, 96 x 64."""
    y, x = np.mgrid[:64, :96]
    image = np.stack([x * 2.6, y * 3.9, 0 * x + 120.0], -1)
    image[(x - 30) ** 2 + (y - 30) ** 2 < 300] = (220, 60, 40)
    path = tmp_path / "photo.png"
    Image.fromarray(image.astype(np.uint8)).save(path)
    return path


def refine(photo: Path, drawing: Path, out: Path, *options: object):
    return invoke("refine", photo, out, "--from", drawing, "--iterations", 40, "--threads", 1, *options)


def quality(photo: Path, svg: Path) -> float:
    return psnr(draw(svg.read_bytes(), 96, 64), np.asarray(Image.open(photo)))


@pytest.fixture
def drawing(photo: Path) -> Path:
    out = photo.with_name("drawing.svg")
    assert invoke("run", photo, out, "--curves", 20, "--iterations", 20, "--threads", 1, "-q").exit_code == 0
    return out


def test_an_own_file_gets_better_and_keeps_its_paths_and_layers(photo: Path, drawing: Path) -> None:
    out = photo.with_name("out.svg")
    result = refine(photo, drawing, out)
    assert result.exit_code == 0, result.stderr
    before, after = (read_svg(path.read_bytes()).scene for path in (drawing, out))
    assert after.generation.tolist() == before.generation.tolist()
    assert quality(photo, out) > quality(photo, drawing) + 0.5


def test_a_drawing_that_is_right_is_written_unchanged(photo: Path) -> None:
    given, out = photo.with_name("given.svg"), photo.with_name("out.svg")
    given.write_text(FOREIGN)
    Image.fromarray(draw(FOREIGN, 96, 64)).save(photo)
    result = refine(photo, given, out)
    assert "nothing better than the given drawing, which is written unchanged" in result.stdout
    assert out.read_bytes() == given.read_bytes()
    assert json.loads(refine(photo, given, out, "--json").stdout)["unchanged"]
    more = json.loads(refine(photo, given, out, "--curves", 9, "--for", "plain", "--json").stdout)
    assert more["unchanged"]
    assert len(read_svg(out.read_bytes()).scene) == len(read_svg(given.read_bytes()).scene)


def test_more_curves_come_on_top_in_new_layers(photo: Path, drawing: Path) -> None:
    out = photo.with_name("out.svg")
    assert refine(photo, drawing, out, "--curves", 40).exit_code == 0
    before, after = (read_svg(path.read_bytes()).scene for path in (drawing, out))
    assert len(after) == 40
    assert after.generation.max() > before.generation.max()


def test_fewer_curves_are_the_most_important_ones(photo: Path, drawing: Path) -> None:
    out = photo.with_name("out.svg")
    assert refine(photo, drawing, out, "--curves", 8).exit_code == 0
    assert len(read_svg(out.read_bytes()).scene) == 8


def test_a_goal_is_followed_from_the_drawing(photo: Path, drawing: Path) -> None:
    out = photo.with_name("out.svg")
    limit = drawing.stat().st_size + 1500
    result = refine(photo, drawing, out, "--max-bytes", limit)
    assert result.exit_code == 0, result.stderr
    assert out.stat().st_size <= limit
    assert len(read_svg(out.read_bytes()).scene) > 20


def test_a_foreign_drawing_is_refined_and_what_it_cannot_hold_is_reported(photo: Path) -> None:
    foreign, out = photo.with_name("foreign.svg"), photo.with_name("out.svg")
    foreign.write_text(FOREIGN.replace("</svg>", "<text>a</text></svg>"))
    result = refine(photo, foreign, out, "--curves", 12)
    assert result.exit_code == 0, result.stderr
    assert re.search(r"^warpvec: .*foreign\.svg: 1 text", result.stderr, re.MULTILINE)
    assert quality(photo, out) > quality(photo, foreign) + 1.0
    assert read_svg(out.read_bytes()).scene.generation.unique().tolist()[:2] == [0, 1]


def test_the_file_has_the_size_and_units_of_the_drawing(photo: Path) -> None:
    foreign, out = photo.with_name("foreign.svg"), photo.with_name("out.svg")
    foreign.write_text(FOREIGN.replace('width="96" height="64">', 'width="48" height="32" viewBox="0 0 96 64">', 1))
    assert refine(photo, foreign, out, "--iterations", 30).exit_code == 0
    loaded = read_svg(out.read_bytes())
    assert (loaded.width, loaded.height) == (48, 32)
    circle = loaded.scene.select(torch.tensor([0])).segments
    assert abs(float(circle[..., 0].mean()) - 15.0) < 3.0
    assert quality(photo, out) > quality(photo, foreign)


def test_without_iterations_an_own_file_keeps_its_bytes(photo: Path, drawing: Path) -> None:
    out = photo.with_name("out.svg")
    result = refine(photo, drawing, out, "--iterations", 0)
    assert result.exit_code == 0, result.stderr
    assert out.read_bytes() == drawing.read_bytes()
    assert re.search(r"PSNR (\d+\.\d+) dB.*, before \1 dB", result.stdout)


def test_without_iterations_lines_stay_lines_even_if_they_are_free(photo: Path) -> None:
    foreign = photo.with_name("foreign.svg")
    foreign.write_text(FOREIGN)
    files = [photo.with_name("kept.svg"), photo.with_name("free.svg")]
    for out, options in zip(files, ([], ["--free"]), strict=True):
        result = refine(photo, foreign, out, "--iterations", 0, *options)
        assert result.exit_code == 0, result.stderr
    kept, free = (read_svg(path.read_bytes()).scene.structure.is_line for path in files)
    assert kept is not None
    assert free is not None
    assert torch.equal(kept, free)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (FOREIGN.replace('height="64">', 'height="96">', 1), "--from must have the proportions of the photo, 96 x 64"),
        ('<svg xmlns="http://www.w3.org/2000/svg" width="96" height="64"/>', "--from must contain filled paths"),
        ("not an svg", "--from must be an SVG file"),
    ],
)
def test_other_drawings_are_refused_in_one_line(photo: Path, text: str, message: str) -> None:
    foreign, out = photo.with_name("foreign.svg"), photo.with_name("out.svg")
    foreign.write_text(text)
    result = refine(photo, foreign, out)
    assert result.exit_code == 2
    line = result.stderr.splitlines()[-1]
    assert line.startswith("warpvec: error: ")
    assert message in line
    assert not out.exists()
