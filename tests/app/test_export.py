"""The page saves the files of `warpvec run`, with the same warnings."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from commands import invoke
from PIL import Image, ImageDraw, ImageFilter

from warpvec.app.export import encode
from warpvec.app.mailbox import Mailbox
from warpvec.app.messages import FitJob
from warpvec.app.settings import FitSettings
from warpvec.app.work import Worker


class IdleMailbox(Mailbox):
    """A mailbox without messages."""

    def __init__(self) -> None:
        self._stops, self._number = {}, 0


def write_shadow(path: Path) -> Path:
    """Write a disc with a soft shadow."""
    image = Image.new("RGBA", (240, 200), "white")
    shadow = Image.new("RGBA", image.size)
    ImageDraw.Draw(shadow).ellipse((60, 50, 180, 170), fill=(0, 0, 0, 130))
    image = Image.alpha_composite(image, shadow.filter(ImageFilter.GaussianBlur(6)))
    ImageDraw.Draw(image).ellipse((44, 30, 164, 150), fill=(200, 40, 40, 255))
    image.convert("RGB").save(path)
    return path


def write_discs(path: Path) -> Path:
    pixels = np.full((60, 90, 3), 255, np.uint8)
    y, x = np.mgrid[:60, :90]
    pixels[(x - 30) ** 2 + (y - 30) ** 2 < 400] = (30, 90, 200)
    pixels[(x - 60) ** 2 + (y - 30) ** 2 < 200] = (200, 40, 40)
    Image.fromarray(pixels).save(path)
    return path


def undated(data: bytes) -> bytes:
    """Return the bytes of a file without the time at which it was made."""
    return re.sub(rb"CreationDate[^\n]*", b"", data)


@pytest.fixture(scope="module", params=[write_shadow, write_discs])
def drawn(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, bool]:
    """Return a picture with its drawing beside it, and whether it has a shadow."""
    source = request.param(tmp_path_factory.mktemp("drawn") / "picture.png")
    invoke("run", str(source), str(source.with_name("drawing.svg")))
    return source, request.param is write_shadow


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["pdf", "eps", "dxf", "png", "svg", "xml", "jsx"])
def test_a_file_of_the_page_is_that_of_the_command_with_the_same_warnings(
    drawn: tuple[Path, bool], kind: str, tmp_path: Path
) -> None:
    pytest.importorskip("cairosvg")
    pytest.importorskip("ezdxf")
    source, has_shadow = drawn
    out = tmp_path / f"drawing.{kind}"
    said = invoke("run", str(source), str(out)).output
    made = encode(source.with_name("drawing.svg").read_text(), kind)
    assert undated(made.data) == undated(out.read_bytes())
    stated = [line for line in said.splitlines() if line.startswith(("for ", "not kept in "))]
    assert made.losses == stated
    assert bool(stated) == (has_shadow and kind in ("pdf", "eps", "dxf", "xml"))


@pytest.mark.slow
@pytest.mark.parametrize("write", [write_shadow, write_discs])
def test_the_worker_of_the_page_draws_what_the_command_does(write, tmp_path: Path) -> None:
    source = write(tmp_path / "picture.png")
    said = invoke("run", source).stdout
    found = Worker(IdleMailbox(), lambda report: None, None).do(
        FitJob(1, source.read_bytes(), "picture", FitSettings({}))
    )
    assert found["svg"] == (tmp_path / "picture.svg").read_text()
    assert [f"not kept: {words}" for words in found["not_kept"]] == re.findall("not kept: .*", said)


def test_a_purpose_that_there_is_not_is_refused() -> None:
    from warpvec.errors import InputError

    text = '<svg xmlns="http://www.w3.org/2000/svg" width="9" height="9"><path d="M0 0h9v9z"/></svg>'
    with pytest.raises(InputError, match="purpose"):
        encode(text, "svg", purpose="toaster")
    assert b"<path" in encode(text, "svg", purpose="plain").data
