"""The tools of ``warpvec mcp``, called by the client of the package "mcp"."""

from __future__ import annotations

import asyncio
import base64
import io
import os
import subprocess
import sys
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest
from children import runs, start, wait_for
from commands import assert_refused, invoke, write_photo
from PIL import Image, ImageDraw

import warpvec
from warpvec.agents.folders import Folders
from warpvec.errors import InputError

pytest.importorskip("mcp")

from mcp import Client
from mcp.client.stdio import StdioServerParameters

from warpvec.agents.server import make_server
from warpvec.agents.tools import Tools

Call = Callable[..., Awaitable[Any]]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with a flag, a photo and a link to a file outside."""
    inside = tmp_path / "pictures"
    inside.mkdir()
    flag = Image.new("RGB", (1600, 1200), "white")
    ImageDraw.Draw(flag).polygon([(200, 200), (1400, 500), (700, 1100)], fill=(200, 0, 0))
    flag.resize((400, 300), Image.Resampling.BOX).save(inside / "flag.png")
    write_photo(inside)
    write_photo(tmp_path, "secret.png")
    (inside / "link.png").symlink_to(tmp_path / "secret.png")
    return inside


def ask(server: Any, work: Callable[[Call], Awaitable[None]]) -> None:
    """Run ``work`` with a function that calls a tool by name and gives the result."""

    async def run() -> None:
        async with Client(server) as client:
            await work(lambda name, **arguments: client.call_tool(name, arguments))

    asyncio.run(run())


def check_whole_way(server: Any, folder: Path) -> None:
    async def work(call: Call) -> None:
        made = await call("vectorize", image="flag.png", out="flag.svg", settings={"palette": ["white", "#c80000"]})
        facts = made.structured_content
        assert facts["path"] == str(folder / "flag.svg") and facts["psnr"] > 40 and facts["mode"] == "flat"
        assert facts["bytes"] == (folder / "flag.svg").stat().st_size
        picture = Image.open(io.BytesIO(base64.b64decode(made.content[1].data)))
        assert picture.size == (256, 192) and picture.getpixel((120, 100)) == (200, 0, 0)
        better = await call(
            "refine", image="photo.png", svg=str(folder / "flag.svg"), out="b.svg", settings={"iterations": 2}
        )
        assert better.is_error and "proportions" in better.content[0].text
        better = await call("refine", image="flag.png", svg="flag.svg", out="b.svg", settings={"iterations": 2})
        measured = await call("evaluate", image="flag.png", svg="b.svg")
        assert measured.structured_content["psnr"] == better.structured_content["psnr"] >= facts["psnr"]

    ask(server, work)


def test_a_client_vectorizes_refines_and_evaluates(folder: Path) -> None:
    check_whole_way(make_server(Folders([str(folder)]), threads=1), folder)


@pytest.mark.slow
def test_the_command_serves_over_stdin_and_stdout(folder: Path) -> None:
    environment = {**os.environ, "PYTHONPATH": str(Path(warpvec.__file__).parents[1])}
    command = ["-m", "warpvec", "mcp", str(folder), "--threads", "1"]
    check_whole_way(StdioServerParameters(command=sys.executable, args=command, env=environment), folder)


_CLIENT = """
import asyncio, sys
from mcp import Client
from mcp.client.stdio import StdioServerParameters

async def run():
    command = StdioServerParameters(command=sys.executable, args=["-m", "warpvec", "mcp", sys.argv[1]])
    async with Client(command) as client:
        print("ready", flush=True)
        await client.call_tool("vectorize", {"image": "photo.png", "out": "a.svg", "settings": SETTINGS})

asyncio.run(run())
""".replace("SETTINGS", str({"mode": "photo", "iterations": 1_000_000, "time_budget": 600.0}))


@pytest.mark.slow
@pytest.mark.longest_wait(90)
def test_the_server_ends_in_a_fit_whose_client_was_killed(folder: Path) -> None:
    environment = {**os.environ, "PYTHONPATH": str(Path(warpvec.__file__).parents[1])}
    client = start([sys.executable, "-c", _CLIENT, folder], stdout=subprocess.PIPE, env=environment)
    assert client.stdout is not None and client.stdout.readline() == b"ready\n"
    (server,) = Path(f"/proc/{client.pid}/task/{client.pid}/children").read_text().split()
    used = Path(f"/proc/{server}/stat")
    before = int(used.read_text().split()[13])
    wait_for(lambda: int(used.read_text().split()[13]) > before + 200)  # it works
    client.kill()
    client.wait()
    wait_for(lambda: not runs(int(server)))
    assert {path.name for path in folder.iterdir()} == {"flag.png", "photo.png", "link.png"}


@pytest.mark.parametrize(
    "arguments",
    [
        {"image": "../secret.png", "out": "a.svg"}, {"image": "/etc/passwd", "out": "a.svg"},
        {"image": "link.png", "out": "a.svg"}, {"image": "photo.png", "out": "../a.svg"},
        {"image": "photo.png", "out": "sub/../../a.svg"}, {"image": "\0", "out": "a.svg"},
    ],
)  # fmt: skip
def test_a_path_outside_of_the_folders_is_refused(folder: Path, arguments: dict[str, str]) -> None:
    async def work(call: Call) -> None:
        refused = await call("vectorize", **arguments)
        assert refused.is_error and f"must be a file in {folder}" in refused.content[0].text

    ask(make_server(Folders([str(folder)])), work)
    assert {path.name for path in folder.parent.iterdir()} == {"pictures", "secret.png"}


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"out": "flag.png"}, "out must not exist"),
        ({"out": "a.exe"}, "out must end in .svg"),
        ({"out": "a.svg", "settings": {"curve": 3}}, "curve is not a setting; did you mean curves?"),
        ({"out": "a.svg", "settings": {"on_progress": 3}}, "on_progress is not a setting"),
        ({"out": "a.svg", "settings": {"mode": "drawing"}}, "mode must be one of auto, photo, flat, mono, lines"),
        ({"out": "a.svg", "image": "no.png"}, "image must be an image file"),
        ({"out": "a" * 5000 + ".svg"}, "out must be a valid file name"),
        ({"out": "a.svg", "image": "a" * 5000}, "image must be a valid file name"),
    ],
)
def test_wrong_input_is_answered_with_what_is_allowed(folder: Path, arguments: dict[str, Any], words: str) -> None:
    async def work(call: Call) -> None:
        refused = await call("vectorize", **{"image": "photo.png", **arguments})
        assert refused.is_error and words in refused.content[0].text

    ask(make_server(Folders([str(folder)])), work)
    assert {path.name for path in folder.iterdir()} == {"flag.png", "photo.png", "link.png"}


def test_the_command_wants_folders_that_are_there(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="FOLDER must be an existing folder"):
        Folders([str(tmp_path / "none")])
    assert_refused(invoke("mcp", tmp_path / "none"), "FOLDER must be an existing folder", "create it first")


def test_what_cannot_be_read_or_written_is_refused_before_a_fit(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    tools = Tools(Folders([str(folder)]))
    os.mkfifo(folder / "pipe.png")
    Image.new("RGB", (4, 4)).save(folder / "in.png")

    def call_again(*_: Any, **__: Any) -> None:
        with pytest.raises(InputError, match="in use"):
            tools.vectorize("in.png", "new.svg", {}, overwrite=True)
        (folder / "new.svg").write_text("of another program")

    monkeypatch.setattr("warpvec.agents.tools.vectorize", call_again)
    for image, out, words in [("pipe.png", "new.svg", "pipe"), ("in.png", "no/new.svg", "folder")]:
        with pytest.raises(InputError, match=words):
            tools.vectorize(image, out, {}, overwrite=False)
    with pytest.raises(InputError, match="must not exist"):  # found after the fit, and left as it is
        tools.vectorize("in.png", "new.svg", {}, overwrite=False)
    assert (folder / "new.svg").read_text() == "of another program"
