"""The extension's scripts as Inkscape calls them, with a stand-in for warpvec."""

from __future__ import annotations

import json
import re
import time
from pathlib import Path

import numpy as np
import pytest
from commands import invoke
from inkscape_runs import (
    document,
    fake_command,
    png_link,
    run_script,
    start_script,
    why_no_scripts,
    without_images,
)
from PIL import Image

from warpvec.svg.resvg import rasterize

pytestmark = pytest.mark.skipif(bool(why_no_scripts()), reason=why_no_scripts())

PIXELS = np.random.default_rng(1).integers(0, 256, (20, 30, 3), np.uint8)

DRAWING = """<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"
 width="30" height="20" viewBox="0 0 30 20">
<defs><linearGradient id="g1" gradientUnits="userSpaceOnUse" x1="0" y1="0" x2="30" y2="0">
<stop stop-color="#f00"/><stop offset="1" stop-color="#00f"/></linearGradient></defs>
<rect id="background" width="30" height="20" fill="#ddd"/>
<g id="red" inkscape:groupmode="layer" inkscape:label="red"><path fill="url(#g1)" d="M3 3h14v9z"/></g>
<g id="green" inkscape:groupmode="layer" inkscape:label="green"><path fill="#0a0" fill-opacity=".5" d="M9 5h14v12h-9z"/>
</g></svg>"""

STAND_IN = """
import json, pathlib, sys
log = pathlib.Path(__file__).with_name("log.json")
calls = json.loads(log.read_text()) if log.exists() else []
log.write_text(json.dumps(calls + [sys.argv[1:]]))
print("iteration 1 of 2, 2 curves, 20.00 dB", file=sys.stderr)
if sys.argv[1] == "run":
    calls and pathlib.Path(sys.argv[2]).read_bytes()
    pathlib.Path(sys.argv[3]).write_text(pathlib.Path(__file__).with_name("drawing.svg").read_text())
    print(json.dumps({"curves": 2, "psnr": 31.25}))
"""

IMAGE = '<image id="img" x="5" y="3mm" width="60" height="70" {} transform="rotate(15)" xlink:href="{}"/>'
GROUP = '<g style="stroke:#00f;stroke-width:4;fill-opacity:.3;fill-rule:evenodd" transform="skewX(9)">{}</g>'


@pytest.fixture
def extension(tmp_path: Path) -> Path:
    """The folder of the installed extension; its warpvec writes `DRAWING` and records how it was called."""
    invoke("inkscape", "install", "--folder", tmp_path / "extensions")
    folder = tmp_path / "extensions" / "warpvec"
    fake_command(folder, STAND_IN)
    (folder / "drawing.svg").write_text(DRAWING)
    return folder


def calls(extension: Path) -> list[list[str]]:
    """Return the arguments of each call of the stand-in."""
    return json.loads((extension / "log.json").read_text())


def saved(folder: Path, text: str) -> Path:
    """Write an SVG and return its path."""
    path = folder / "document.svg"
    path.write_text(text)
    return path


def drawn(text: str) -> np.ndarray:
    """Return the picture of an SVG, with colours multiplied by alpha."""
    image = rasterize(text, 480, 360, transparent=True, sandboxed=False).astype(float)
    image[..., :3] *= image[..., 3:] / 255.0
    return image


@pytest.mark.parametrize("aspect", ["", 'preserveAspectRatio="xMaxYMid"', 'preserveAspectRatio="none"'])
def test_the_drawing_has_the_place_of_its_image(extension: Path, tmp_path: Path, aspect: str) -> None:
    content = GROUP.format(IMAGE.format(aspect, png_link(PIXELS)))
    traced, messages = run_script(extension, "warpvec_trace.py", saved(tmp_path, document(content)), "--id=img")
    assert messages == ""
    body = DRAWING.partition(">")[2].rpartition("</svg>")[0]
    nested = f'<svg x="5" y="3mm" width="60" height="70" {aspect} viewBox="0 0 30 20" overflow="visible">{body}</svg>'
    expected = f'<g transform="skewX(9)"><g transform="rotate(15)">{nested}</g></g>'
    names = 'xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"'
    difference = drawn(without_images(traced)) - drawn(document(expected).replace("<svg ", f"<svg {names} ", 1))
    assert np.abs(difference).max() <= 2
    assert "Trace of img: 2 paths, 31.2 dB" in traced


NATIVE = """<defs><linearGradient id="g1" gradientUnits="userSpaceOnUse" x1="0" y1="0" x2="30" y2="0">
<stop stop-color="#c22"/><stop offset="1" stop-color="#27c"/></linearGradient></defs>
{}<circle fill="#182" cx="6" cy="6" r="4"/>
<rect fill="#fa0" x="14" y="3" width="8" height="5" rx="2" transform="rotate(20 18 5.5)"/>
<path fill="none" stroke="url(#g1)" stroke-width="2" d="M2 16h12l8-4 5 5"/>{}"""


@pytest.mark.parametrize(
    ("group", "end"), [('<g id="layer-1">', "</g>"), ("", ""), ('<rect width="30" height="20" fill="#eee"/>', "")]
)
def test_strokes_and_forms_come_as_native_objects(extension: Path, tmp_path: Path, group: str, end: str) -> None:
    body = NATIVE.format(group, end)
    frame = '<svg xmlns="http://www.w3.org/2000/svg" width="30" height="20" viewBox="0 0 30 20">'
    (extension / "drawing.svg").write_text(f"{frame}{body}</svg>")
    style = "stroke-linecap:round;stroke-dasharray:3;stroke-miterlimit:1;stroke-opacity:.3"
    content = f'<g style="{style}">{IMAGE.format("", png_link(PIXELS))}</g>'
    traced, messages = run_script(extension, "warpvec_trace.py", saved(tmp_path, document(content)), "--id=img")
    assert messages == ""
    for element in ("<circle", "<rect ", "stroke-width=", "rx="):
        assert traced.count(element) == body.count(element), element
    nested = f'<svg x="5" y="3mm" width="60" height="70" viewBox="0 0 30 20" overflow="visible">{body}</svg>'
    expected = document(f'<g transform="rotate(15)">{nested}</g>')
    assert np.abs(drawn(without_images(traced)) - drawn(expected)).max() <= 2


def test_a_cropped_image_gives_a_cropped_drawing(extension: Path, tmp_path: Path) -> None:
    clip = '<clipPath id="c"><circle cx="40" cy="40" r="30"/></clipPath>'
    look = 'preserveAspectRatio="xMinYMid slice" clip-path="url(#c)" style="opacity:.5"'
    grey = png_link(np.full((20, 30, 3), 0xDD, np.uint8))
    (extension / "drawing.svg").write_text(re.sub(r"<g .*</g>", "", DRAWING, flags=re.DOTALL))
    path = saved(tmp_path, document(clip + GROUP.format(IMAGE.format(look, grey))))
    traced, _ = run_script(extension, "warpvec_trace.py", path, "--id=img")
    assert (
        np.abs(drawn(without_images(traced)) - drawn(path.read_text())).max() <= 64
    )  # at edges that are clipped twice
    assert np.abs(drawn(without_images(traced)) - drawn(path.read_text())).mean() < 0.1


def test_two_traces_of_one_image_share_no_ids(extension: Path, tmp_path: Path) -> None:
    path = saved(tmp_path, document(IMAGE.format("", png_link(PIXELS))))
    once, _ = run_script(extension, "warpvec_trace.py", path, "--id=img")
    twice, _ = run_script(extension, "warpvec_trace.py", saved(tmp_path, once), "--id=img")
    identifiers = re.findall(r' id="([^"]+)"', twice)
    assert len(identifiers) == len(set(identifiers)) == 11
    assert {f"url(#{name})" for name in identifiers} >= set(re.findall(r"url\(#[^)]+\)", twice))


def test_the_dialog_becomes_options_of_the_command(extension: Path, tmp_path: Path) -> None:
    path = saved(tmp_path, document(IMAGE.format("", png_link(PIXELS))))
    limits = ["--mode=flat", "--limit=bytes", "--kilobytes=50", "--paths=9", "--detail=0.3", "--colors=8"]
    run_script(extension, "warpvec_trace.py", path, "--id=img", *limits, "--opaque=true", "--cutout=true")
    run_script(extension, "warpvec_trace.py", path, "--id=img", "--limit=paths", "--paths=9", "--gradients=25")
    first, second = ([*call[3:], ""] for call in calls(extension))
    assert " ".join(first).startswith("--mode flat --max-bytes 50000 --detail 0.3 --colors 8 --opaque --cutout ")
    assert " ".join(second).startswith("--mode auto --curves 9 --gradients 0.25 --trim ")


def test_linked_images_in_selected_groups_are_traced_in_turn(extension: Path, tmp_path: Path) -> None:
    (tmp_path / "my pictures").mkdir()
    Image.fromarray(PIXELS).save(tmp_path / "my pictures" / "a.png")
    links = ["my%20pictures/a.png", (tmp_path / "my pictures" / "a.png").as_uri()]
    images = "".join(f'<image id="i{number}" width="9" xlink:href="{link}"/>' for number, link in enumerate(links))
    path = saved(tmp_path, document(f'<defs><image id="no"/></defs><g id="both"><g>{images}</g></g>'))
    traced, messages = run_script(extension, "warpvec_trace.py", path, "--id=both", "--id=no")
    assert messages == ""
    assert [call[1] for call in calls(extension)] == 2 * [str(tmp_path / "my pictures" / "a.png")]
    assert re.findall(r'id="(i\d|trace-of-i\d)"', traced) == ["i0", "trace-of-i0", "i1", "trace-of-i1"]


@pytest.mark.parametrize(
    ("link", "words"),
    [
        ("https://example.org/a.png", "a link to https://example.org/a.png. Save that file, and import it."),
        ("gone.png", "The linked image gone.png is missing."),
        ("", "The linked image (without a name) is missing."),
        ("data:image/png;base64,A", "The embedded image is damaged."),
    ],
)
def test_an_image_without_a_file_is_refused(extension: Path, tmp_path: Path, link: str, words: str) -> None:
    path = saved(tmp_path, document(IMAGE.format("", link)))
    traced, message = run_script(extension, "warpvec_trace.py", path, "--id=img")
    assert traced == ""
    assert words in message
    assert len(message.splitlines()) == 1


def test_without_an_image_there_is_one_message(extension: Path, tmp_path: Path) -> None:
    path = saved(tmp_path, document('<rect id="r" width="9" height="9"/>'))
    for arguments in ([], ["--id=r"]):
        assert run_script(extension, "warpvec_trace.py", path, *arguments) == (
            "",
            "Select an image to trace, then try again.\n",
        )
    assert run_script(extension, "warpvec_refine.py", path, "--id=r")[1].startswith("There is no image beneath")


@pytest.mark.parametrize(
    ("code", "words"),
    [
        (
            "import sys; sys.exit('warpvec: error: IN must be an image, got rubbish; check it')",
            "warpvec: IN must be an",
        ),
        ("raise RuntimeError('torn')", "ended with the code 1: RuntimeError: torn. Open a terminal"),
        ("import sys; sys.exit(130)", "warpvec was stopped before it had a result."),
    ],
)
def test_the_line_of_warpvec_is_shown(extension: Path, tmp_path: Path, code: str, words: str) -> None:
    fake_command(extension, code)
    path = saved(tmp_path, document(IMAGE.format("", png_link(PIXELS))))
    traced, message = run_script(extension, "warpvec_trace.py", path, "--id=img")
    assert traced == ""
    assert words in message
    assert len(message.splitlines()) == 1


@pytest.mark.parametrize(("answer", "is_kept"), [("stop", True), ("cancel", False)])
def test_the_buttons_of_the_window_end_the_fit(extension: Path, tmp_path: Path, answer: str, is_kept: bool) -> None:
    (extension / "warpvec_progress.py").write_text(f"import sys\nsys.stdin.readline()\nprint({answer!r}, flush=True)")
    wait = "import time\ntry:\n    time.sleep(100)\nexcept KeyboardInterrupt:\n    sys.exit(130)\n"
    fake_command(extension, STAND_IN.replace("file=sys.stderr", "file=sys.stderr, flush=True") + wait)
    path = saved(tmp_path, document(IMAGE.format("", png_link(PIXELS))))
    traced, message = run_script(extension, "warpvec_trace.py", path, "--id=img")
    assert message == ""
    assert ("Trace of img: 2 paths" in traced) == is_kept == (traced != "")


def test_a_command_that_has_gone_is_named(extension: Path, tmp_path: Path) -> None:
    gone = str(tmp_path / "bin" / "python")
    (extension / "command.json").write_text(json.dumps({"command": [gone]}))
    path = saved(tmp_path, document(IMAGE.format("", png_link(PIXELS))))
    message = run_script(extension, "warpvec_trace.py", path, "--id=img")[1]
    assert f"warpvec is not at {gone} any more" in message
    assert "run: warpvec inkscape install" in message


def test_warpvec_ends_when_inkscape_stops_waiting(extension: Path, tmp_path: Path) -> None:
    note = tmp_path / "note"
    forever = f"import pathlib, os, time\npathlib.Path({str(note)!r}).write_text(str(os.getpid()))\ntime.sleep(100)"
    fake_command(extension, forever)
    path = saved(tmp_path, document(IMAGE.format("", png_link(PIXELS))))
    with start_script(extension, "warpvec_trace.py", path, "--id=img") as process:
        while not (note.exists() and note.read_text()):
            assert process.poll() is None
            time.sleep(0.05)
        assert process.stdout is not None
        process.stdout.close()
        assert process.wait(20) == 0
    assert not Path(f"/proc/{note.read_text()}").exists()
