"""``warpvec run --placeholder``: where it goes, and what it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from commands import assert_refused, invoke, write_photo
from PIL import Image

from warpvec.placeholders.text import data_uri

OPTIONS = ("--placeholder", "--max-bytes", "300")


@pytest.fixture
def photo(tmp_path: Path) -> Path:
    return write_photo(tmp_path)


@pytest.mark.slow
def test_the_uri_goes_to_stdout_and_the_svg_to_a_file(photo: Path) -> None:
    out = photo.with_name("out.svg")
    printed = invoke("run", photo, *OPTIONS)
    assert printed.exit_code == 0, printed.output
    uri = printed.stdout.removesuffix("\n")
    assert uri.startswith("data:image/svg+xml,<svg ") and len(uri) <= 300
    assert f"data URI of {len(uri)} bytes" in printed.stderr
    written = invoke("run", photo, out, *OPTIONS, "--json")
    assert data_uri(out.read_text()) == uri
    facts = json.loads(written.stdout)
    assert (facts["uri_bytes"], facts["bytes"]) == (len(uri), out.stat().st_size)
    assert not photo.with_name("photo.svg").exists()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--max-bytes", "200"), "--max-bytes with --placeholder must be a whole number from 300 to 5000"),
        (("--curves", "20"), "--curves must not be given with --placeholder"),
        (("--opaque",), "--opaque must not be given with --placeholder"),
        (("out.svgz",), "OUT must end in .svg with --placeholder"),
    ],
)
def test_what_a_placeholder_does_not_obey_is_refused(photo: Path, options: tuple[str, ...], words: str) -> None:
    assert_refused(invoke("run", photo, "--placeholder", *options), words)


def test_transparent_parts_become_white_or_a_named_colour(tmp_path: Path) -> None:
    clear = tmp_path / "clear.png"
    Image.new("RGBA", (24, 16), (0, 0, 200, 0)).save(clear)
    said = invoke("run", clear, *OPTIONS)
    assert "transparent parts are white in the placeholder" in said.stderr and "%23fff" in said.stdout
    silent = invoke("run", clear, *OPTIONS, "--background", "#f00")
    assert "transparent" not in silent.stderr and "%23f00" in silent.stdout
