"""Output beside the SVG: the page, the history, and the settings of a resumed fit."""

from __future__ import annotations

import json
import math
import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import QUICK, assert_refused, invoke, write_photo
from PIL import Image
from stubs import stub_fit

from warpvec.modes import photo as photo_mode

pytestmark = pytest.mark.usefixtures("quick_fit")


@pytest.fixture
def photo(tmp_path: Path) -> Path:
    return write_photo(tmp_path)


@pytest.fixture
def logo(tmp_path: Path) -> Path:
    """A transparent image with a red disc."""
    y, x = np.mgrid[:32, :48]
    pixels = np.zeros((32, 48, 4), np.uint8)
    pixels[(x - 24) ** 2 + (y - 16) ** 2 < 120] = (220, 30, 30, 255)
    Image.fromarray(pixels).save(tmp_path / "logo.png")
    return tmp_path / "logo.png"


def _data(page: Path) -> dict[str, Any]:
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', page.read_text(), re.DOTALL)
    assert found is not None
    return json.loads(found[1])


def _report(image: Path, *options: object, out: str = "out.svg") -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the JSON report of `warpvec run` and the data in its page."""
    page = image.with_name("page.html")
    result = invoke("run", image, image.with_name(out), "--report", page, "--json", *QUICK, *options)
    assert result.exit_code == 0, result.output
    return json.loads(result.stdout), _data(page)


def test_the_page_compares_with_what_was_fitted(logo: Path) -> None:
    found, page = _report(logo, "--background", "#00f", "--mode", "flat", out="my drawing.svg")
    assert abs(page["figures"]["psnr"] - found["psnr"]) < 1e-6
    assert page["name"] == "my drawing"
    page_file = logo.with_name("again.html")
    options = ["--image", logo, "--background", "#00f", "--report", page_file]
    assert invoke("view", logo.with_name("my drawing.svg"), *options).exit_code == 0
    assert _data(page_file)["figures"] == page["figures"]
    assert _data(page_file)["photo"] == page["photo"]


def test_a_background_needs_an_image(photo: Path) -> None:
    out = photo.with_name("out.svg")
    assert invoke("run", photo, out, *QUICK).exit_code == 0
    for command in ("view", "lod"):
        result = invoke(command, out, "--background", "#00f")
        assert_refused(result, "--background must come with --image, got '#00f' alone; add the image")


def test_a_perfect_fit_has_a_page(photo: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def perfect(*arguments: Any, **options: Any) -> Any:
        fitted = stub_fit(*arguments, **options)
        fitted.history[-1]["psnr"] = math.inf
        return fitted

    monkeypatch.setattr(photo_mode, "fit", perfect)
    found, page = _report(photo)
    assert [record["psnr"] for record in found["history"]] == [pytest.approx(20.0), pytest.approx(20.0), None]
    # The plot cannot show infinity.
    assert [record["iteration"] for record in page["history"]] == [1, 2]


def test_the_output_of_json_is_a_history(photo: Path) -> None:
    out, report, page = (photo.with_name(name) for name in ("out.svg", "report.json", "page.html"))
    result = invoke("run", photo, out, "--json", "-q", *QUICK)
    report.write_text(result.stdout)
    assert invoke("view", out, "--history", report, "--report", page).exit_code == 0
    history = json.loads(result.stdout)["history"]
    assert [(record["iteration"], record["curves"]) for record in history] == [(k, 8) for k in (1, 2, 3)]
    assert _data(page)["history"] == history


def test_the_levels_of_an_empty_drawing_are_none(photo: Path) -> None:
    result = invoke("run", photo, photo.with_name("out.svg"), "--lod", "--min-area", "1e9", "--json", *QUICK)
    assert result.exit_code == 0, result.output
    assert json.loads(result.stdout)["curves"] == 0
    assert json.loads(result.stdout)["levels"] == []
    assert invoke("run", photo, photo.with_name("out.svg"), "--lod", "--min-area", "1e9", *QUICK).exit_code == 0


def test_messages_name_the_options(photo: Path) -> None:
    out = photo.with_name("out.svg")
    assert invoke("run", photo, out, *QUICK).exit_code == 0
    none = photo.with_name("none")
    assert_refused(invoke("lod", out, "--levels", "9", "-o", "-"), "error: --levels must")
    assert_refused(invoke("lod", out, "--levels", "0", "-o", none), "error: -o must end in .svg")
    assert_refused(invoke("run", photo, out, "--resume", none), "error: --resume must be a file", "none")
    assert_refused(
        invoke("run", photo, out, "--resume", none, "--max-bytes", 9), "error: --resume cannot be combined with"
    )
    for command in (["run", photo, out], ["view", out]):
        assert_refused(
            invoke(*command, "--report", photo.with_name("p.png")), "--report must end in .html or .htm, got"
        )
    assert not photo.with_name("p.png").exists()
    assert_refused(invoke("run", photo, out, "--curves", "abc"), "--curves", "'abc'", "auto")
    none.write_text("[3]")
    assert_refused(invoke("view", out, "--image", none, "--report", photo.with_name("p.html")), "error: --image must")
    for text in ("[3]", '{"psnr": 3}'):
        none.write_text(text)
        result = invoke("view", out, "--history", none, "--report", photo.with_name("p.html"))
        assert_refused(result, "error: --history must be a list of records")


def test_the_settings_of_the_checkpoint_are_written(photo: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.undo()  # a checkpoint needs a real fit
    out, state, first_settings, again = (photo.with_name(name) for name in ("out.svg", "state", "a.toml", "b.toml"))
    options = ["--initial-curves", 4, "--seed", 5, "--preset", "draft", *QUICK, "-q", "--device", "cpu", "--every", 2]
    assert invoke("run", photo, out, *options, "--checkpoint", state, "--write-config", first_settings).exit_code == 0
    first = out.read_bytes()
    result = invoke("run", photo, out, "-q", "--resume", state, "--threads", 1, "--write-config", again)
    assert result.exit_code == 0, result.output
    expected = tomllib.loads(first_settings.read_text()) | {"threads": 1, "preset": "default"}
    assert tomllib.loads(again.read_text()) == expected
    assert invoke("run", photo, out, "-q", "--config", again).exit_code == 0
    assert out.read_bytes() == first


def test_the_decisions_of_a_drawing_are_lines_of_json(logo: Path) -> None:
    why = logo.with_name("why.jsonl")
    assert invoke("run", logo, logo.with_name("out.svg"), "--why", why).exit_code == 0
    found = [json.loads(line) for line in why.read_text().splitlines()]
    assert {"two colours", "mode"} == {each["stage"] for each in found}
    assert_refused(invoke("run", logo, logo.with_name("out.svg"), "--why", logo.parent), "--why")


def test_a_file_for_word_has_a_picture_beside_that_is_never_the_input(photo: Path) -> None:
    pytest.importorskip("pathops")
    before, out = photo.read_bytes(), photo.with_suffix(".svg")
    result = invoke("run", photo, out, "--for", "word", *QUICK)
    assert result.exit_code == 0, result.output
    assert out.with_name(f"{out.name}.png").read_bytes().startswith(b"\x89PNG")
    assert photo.read_bytes() == before
    named_alike = photo.rename(photo.with_name("logo.svg.png"))
    refused = invoke("run", named_alike, photo.with_name("logo.svg"), "--for", "word", *QUICK)
    assert refused.exit_code == 2 and "must be another file than IN" in refused.output
    assert named_alike.read_bytes() == before
