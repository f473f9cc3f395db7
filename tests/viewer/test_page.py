"""The page of ``warpvec view`` as a file: content, safety, and the command."""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
import math
import re
from graphlib import TopologicalSorter
from html.parser import HTMLParser
from io import BytesIO
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
import pytest
from click.testing import CliRunner, Result
from PIL import Image

from warpvec.cli.commands import view as command_module
from warpvec.cli.commands.view import view
from warpvec.errors import InputError
from warpvec.svg.measure import draw, file_facts, file_quality
from warpvec.viewer import page as page_module
from warpvec.viewer.modules import module_texts
from warpvec.viewer.page import write_page

NS = 'xmlns="http://www.w3.org/2000/svg"'
SVG = f'<svg {NS} width="48" height="32"><title>Leaf</title><path fill="#070" d="M8 8h9v9z"/></svg>'.encode()
HISTORY = [{"iteration": 1, "curves": 16, "psnr": 12.5, "seconds": 0.25}]


class Parsed(HTMLParser):
    """A page's elements and the text of its scripts and styles, as a browser's tokenizer finds them."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.raw: list[tuple[str, str]] = []
        self.feed(html)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        if tag in ("script", "style"):
            self.raw.append((tag, ""))

    def handle_data(self, data: str) -> None:
        if self.elements and self.elements[-1][0] in ("script", "style") and self.raw:
            self.raw[-1] = (self.raw[-1][0], self.raw[-1][1] + data)

    def handle_endtag(self, tag: str) -> None:
        self.elements.append(("/" + tag, {}))

    @property
    def data(self) -> dict[str, Any]:
        return json.loads(self.raw[1][1])


def page_of(folder: Path, svg: bytes = SVG, **options: Any) -> Parsed:
    write_page(folder / "page.html", svg, **options)
    return Parsed((folder / "page.html").read_text(encoding="utf-8"))


def photo_file(width: int = 48, height: int = 32, **options: Any) -> tuple[np.ndarray, bytes]:
    """Return a noise image and its PNG file."""
    pixels = np.random.default_rng(1).integers(0, 256, (height, width, 3), dtype=np.uint8)
    stream = BytesIO()
    Image.fromarray(pixels).save(stream, "PNG", **options)
    return pixels, stream.getvalue()


def photo_in(page: Parsed) -> np.ndarray:
    kind, _, data = page.data["photo"].partition(",")
    assert kind == "data:image/png;base64"
    with Image.open(BytesIO(base64.b64decode(data))) as image:
        return np.array(image)


def test_the_page_refers_to_nothing_outside(tmp_path: Path) -> None:
    page = page_of(tmp_path, photo=photo_file()[1], history=HISTORY)
    text = (tmp_path / "page.html").read_text(encoding="utf-8")
    # These are names of namespaces, which nothing fetches.
    assert set(re.findall(r"https?://[^\s\"'\\<>]+", text)) <= {
        "http://www.w3.org/2000/svg",
        "http://www.inkscape.org/namespaces/inkscape",
    }
    names = {name for _, attributes in page.elements for name in attributes}
    assert not names & {"src", "href", "srcset", "action", "style"}
    assert not [name for name in names if name.startswith("on")]


def test_the_policy_allows_only_the_scripts_and_the_style_of_the_page(tmp_path: Path) -> None:
    page = page_of(tmp_path)
    (policy,) = (a["content"] for tag, a in page.elements if a.get("http-equiv") == "Content-Security-Policy")
    digest = base64.b64encode(hashlib.sha256(page.raw[0][1].encode()).digest()).decode()
    assert f"style-src 'sha256-{digest}'" in policy
    nonces = {a.get("nonce") for tag, a in page.elements if tag == "script" and a.get("id") != "data"}
    (nonce,) = nonces
    assert f"script-src 'nonce-{nonce}';" in policy
    assert "default-src 'none'" in policy
    assert "unsafe" not in policy


def test_no_drawing_can_state_the_nonce_of_its_page(tmp_path: Path) -> None:
    def nonce(svg: bytes) -> str:
        return str(next(a["nonce"] for _, a in page_of(tmp_path, svg).elements if "nonce" in a))

    first = nonce(SVG)
    assert len(first) == 64
    assert nonce(SVG) == first  # the same page is written for the same drawing
    assert nonce(SVG.replace(b"Leaf", first.encode())) != first


def test_every_module_of_the_package_is_in_the_page_and_small(tmp_path: Path) -> None:
    folder = Path(page_module.__file__).parent / "assets"
    urls = json.loads(page_of(tmp_path).raw[2][1])["imports"]
    texts = {name: unquote(url.removeprefix("data:text/javascript,")) for name, url in urls.items()}
    assert texts == {f"viewer/{path.name}": path.read_text(encoding="utf-8") for path in folder.glob("*.js")}
    assert len(texts) > 10
    for name, text in texts.items():
        assert text.count("\n") < 300, name


def test_modules_import_what_others_export_and_in_one_direction() -> None:
    texts = module_texts("viewer", "app")
    imports = {name: re.findall(r'^import \{([^}]*)\} from "([^"]+)";', text, re.M) for name, text in texts.items()}
    for name, found in imports.items():
        assert texts[name].count("\nimport ") == len(found), name
        for names, source in found:
            for each in filter(None, map(str.strip, names.split(","))):
                assert re.search(rf"^export [a-z* ]+ {each}\b", texts[source], re.M), (name, source, each)
        if name.startswith("viewer/"):
            assert all(source.startswith("viewer/") for _, source in found), name
    order = TopologicalSorter({name: {source for _, source in found} for name, found in imports.items()})
    assert len(list(order.static_order())) == len(texts)  # raises CycleError for a circle


def test_figures_are_those_of_resvg_and_the_photo_is_as_read(tmp_path: Path) -> None:
    pixels, photo = photo_file()
    page = page_of(tmp_path, photo=photo, history=[{**HISTORY[0], "other": 3}])
    assert np.array_equal(photo_in(page), pixels)
    quality = file_quality(SVG, pixels)
    figures = page.data["figures"]
    assert {key: figures[key] for key in file_facts(SVG)} == file_facts(SVG)
    assert abs(figures["psnr"] - quality["psnr"]) < 1e-6
    assert abs(figures["ssim"] - quality["ssim"]) < 1e-6
    assert page.data["history"] == HISTORY
    assert page.data["name"] == "page"


def test_without_photo_and_history_there_is_neither(tmp_path: Path) -> None:
    data = page_of(tmp_path, name="leaf").data
    assert "photo" not in data
    assert "psnr" not in data["figures"]
    assert data["history"] == []
    assert data["name"] == "leaf"


def test_an_infinite_psnr_is_null(tmp_path: Path) -> None:
    svg = f'<svg {NS} width="9" height="9"><rect width="9" height="9" fill="#f00"/></svg>'.encode()
    stream = BytesIO()
    Image.fromarray(draw(svg)).save(stream, "PNG")
    assert math.isinf(file_quality(svg, draw(svg))["psnr"])
    assert page_of(tmp_path, svg, photo=stream.getvalue()).data["figures"]["psnr"] is None


def test_the_photo_is_turned_upright_and_reduced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(page_module, "PAGE_PHOTO_SIDE", 24)
    exif = Image.Exif()
    exif[0x0112] = 6  # a quarter to the right
    _, photo = photo_file(32, 48, exif=exif)
    page = page_of(tmp_path, photo=photo)
    assert photo_in(page).shape == (16, 24, 3)
    assert b"eXIf" not in base64.b64decode(page.data["photo"].partition(",")[2])


def test_a_gzipped_file_and_a_byte_order_mark_are_read(tmp_path: Path) -> None:
    plain = page_of(tmp_path).data["svg"]
    for form in (gzip.compress(SVG), b"\xef\xbb\xbf" + SVG):
        assert page_of(tmp_path, form).data["svg"] == plain


def test_hostile_text_stays_inside_its_string(tmp_path: Path) -> None:
    title = "&lt;/title>&lt;/script>&lt;script>evil()&lt;/script>&lt;!--"
    svg = f'<svg {NS} width="9" height="9" onload="evil()"><title>{title}</title><script>evil()</script></svg>'.encode()
    name = "</title></script><script>evil()</script><!--"
    page, harmless = page_of(tmp_path, svg, name=name), page_of(tmp_path)
    tags = [[tag for tag, _ in parsed.elements] for parsed in (page, harmless)]
    assert tags[0] == tags[1]
    assert page.data["name"] == name
    assert "onload" not in page.data["svg"]
    assert "<script" not in page.data["svg"]


# Refusals.


def refusal(folder: Path, *arguments: Any, **options: Any) -> str:
    """Return the message of a refusal, after which an earlier page is unchanged and no other file exists."""
    target = folder / "page.html"
    target.write_text("earlier")
    with pytest.raises(InputError) as caught:
        write_page(target, *arguments, **options)
    assert [path.name for path in folder.iterdir()] == ["page.html"]
    assert target.read_text() == "earlier"
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize(
    ("svg", "word"),
    [
        (b"nonsense", "must be an SVG file"),
        (b'<!DOCTYPE svg [<!ENTITY a "a">]><svg/>', "entities"),
        (f'<svg {NS} width="9" height="9"><image href="http://e.org/x.png"/></svg>'.encode(), "other files"),
        (gzip.compress(SVG)[:-9], "gzipped"),
    ],
)
def test_an_unsafe_file_is_refused(tmp_path: Path, svg: bytes, word: str) -> None:
    assert word in refusal(tmp_path, svg)


def test_a_photo_that_does_not_fit_is_refused(tmp_path: Path) -> None:
    assert "proportions" in refusal(tmp_path, SVG, photo=photo_file(80, 20)[1])
    assert refusal(tmp_path, SVG, photo=b"nonsense").startswith("photo must")


@pytest.mark.parametrize(
    "history",
    [{"psnr": 3}, "text", [3], [{}], [{**HISTORY[0], "psnr": "<b>"}], [{**HISTORY[0], "psnr": math.nan}],
     [{**HISTORY[0], "seconds": True}]],
)  # fmt: skip
def test_a_history_of_another_form_is_refused(tmp_path: Path, history: Any) -> None:
    assert refusal(tmp_path, SVG, history=history).startswith("history must")


def test_a_path_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="existing folder"):
        write_page(tmp_path / "no" / "page.html", SVG)


# The command.


@pytest.fixture
def files(tmp_path: Path) -> Path:
    """A folder with a drawing, its photo and its history."""
    (tmp_path / "leaf.svg").write_bytes(SVG)
    (tmp_path / "photo.png").write_bytes(photo_file()[1])
    (tmp_path / "history.json").write_text(json.dumps(HISTORY))
    return tmp_path


def invoke(*arguments: object) -> Result:
    return CliRunner().invoke(view, [str(argument) for argument in arguments])


def test_with_report_the_page_is_written_and_nothing_opened(files: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(command_module.webbrowser, "open", lambda url: pytest.fail(f"opened {url}"))
    report = files / "report.html"
    result = invoke(
        files / "leaf.svg", "--image", files / "photo.png", "--history", files / "history.json", "--report", report
    )
    assert result.exit_code == 0, result.output
    data = Parsed(report.read_text(encoding="utf-8")).data
    assert data["name"] == "leaf"
    assert data["history"] == HISTORY
    assert "photo" in data


@pytest.mark.parametrize("started", [True, False])
def test_without_report_the_page_is_opened(files: Path, monkeypatch: pytest.MonkeyPatch, started: bool) -> None:
    opened: list[str] = []
    monkeypatch.setattr(command_module.tempfile, "mkdtemp", lambda prefix: str(files))
    monkeypatch.setattr(command_module.webbrowser, "open", lambda url: opened.append(url) or started)
    result = invoke(files / "leaf.svg")
    assert result.exit_code == 0, result.output
    assert opened == [(files / "leaf.html").as_uri()]
    assert ("open " + str(files / "leaf.html") in result.stderr) is not started


@pytest.mark.parametrize(
    ("arguments", "start"),
    [
        (["no.svg"], "SVG must be an SVG file"),
        (["leaf.svg", "--image", "no.png"], "--image must be an image file, got 'no.png'"),
        (["leaf.svg", "--image", "history.json"], "--image must be a complete image"),
        (["leaf.svg", "--history", "no.json"], "--history must be a file"),
        (["leaf.svg", "--history", "photo.png"], "--history must be a JSON file"),
        (["leaf.svg", "--report", "no/page.html"], "--report must be in an existing folder"),
    ],
)
def test_wrong_files_are_refused_in_one_line(
    files: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], start: str
) -> None:
    monkeypatch.chdir(files)
    result = invoke(*arguments)
    assert isinstance(result.exception, InputError)
    assert str(result.exception).startswith(start)
    assert repr(arguments[-1]) in str(result.exception)
