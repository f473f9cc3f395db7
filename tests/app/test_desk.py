"""The queue of fits: one at a time, the newest of each picture, stopped, replaced and resumed as the page asks."""

from __future__ import annotations

import os
import secrets
from collections.abc import AsyncIterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from app_server import TOKEN, Server, server_fixture  # noqa: F401  (fixture)
from PIL import Image

from warpvec.app import desk, folder, pages
from warpvec.app.messages import Report, Stop
from warpvec.errors import InputError


def add(server: Server, page: str = "a", side: int = 8) -> str:
    """Send a picture and return its identifier."""
    answer = server.post(f"pictures?page={page}&key={secrets.token_hex(4)}&name=red", picture(side))
    assert answer.status_code == 201, answer.text
    assert (answer.json()["width"], answer.json()["height"]) == (side, 4)
    return str(answer.json()["id"])


def picture(side: int) -> bytes:
    from io import BytesIO

    stream = BytesIO()
    Image.fromarray(np.full((4, side, 3), (200, 0, 0), np.uint8)).save(stream, "PNG")
    return stream.getvalue()


def fit(server: Server, identifier: str, **request: object) -> None:
    assert server.post(f"pictures/{identifier}/fit", request).status_code == 202


def statuses(server: Server) -> list[str]:
    return [found.status for found in server.desk.pictures.values()]


FRAME = {"svg": "<svg/>", "iteration": 50, "iterations": 200, "psnr": 20.0}
DONE = {"svg": "<svg/>", "stopped": False}


def test_fits_wait_for_the_worker_and_for_one_another(server: Server) -> None:
    first, second = add(server, "a"), add(server, "b")
    fit(server, first)
    fit(server, second)
    assert server.worker.sent == []
    server.report("ready")
    assert [job.number for job in server.worker.jobs] == [1]
    assert statuses(server) == ["fitting", "waiting"]
    server.report("done", 1, **DONE)
    assert [job.number for job in server.worker.jobs] == [1, 2]
    server.report("failed", 2, message="no")
    assert statuses(server) == ["done", "failed"]


def test_a_new_request_replaces_the_running_fit_and_goes_on_from_its_share(server: Server) -> None:
    server.report("ready")
    identifier = add(server)
    fit(server, identifier)
    server.report("frame", 1, **FRAME)
    fit(server, identifier, settings={"curves": 64}, start="<svg/>")
    fit(server, identifier, settings={"curves": 99}, start="<svg/>")
    assert server.worker.stops == [Stop(1, is_dropped=True)]
    assert len(server.worker.jobs) == 1  # the old fit has not ended yet
    server.report("frame", 1, **FRAME)  # too late
    server.report("dropped", 1)
    second = server.worker.jobs[-1]
    assert (second.settings.values["curves"], second.start) == (99, "<svg/>")
    assert second.done_share == 0.25
    server.report("frame", second.number, **FRAME)
    server.report("done", second.number, **{**DONE, "stopped": True})
    fit(server, identifier, start="<svg/>")
    assert server.worker.jobs[-1].done_share == pytest.approx(0.25 + 0.75 * 0.25)


def test_stop_keeps_the_best_drawing_and_frees_the_queue(server: Server) -> None:
    server.report("ready")
    first, second = add(server), add(server)
    fit(server, first)
    fit(server, second)
    assert server.post(f"pictures/{second}/stop").status_code == 204
    assert statuses(server) == ["fitting", "stopped"]
    server.post(f"pictures/{first}/stop")
    assert server.worker.stops == [Stop(1)]
    server.report("done", 1, **{**DONE, "stopped": True})
    assert statuses(server) == ["stopped", "stopped"]
    assert server.desk.pictures[first].last["done"]["svg"] == "<svg/>"


def test_a_fit_that_does_not_stop_is_ended_with_its_last_frame(server: Server, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(desk, "STOP_SECONDS", 0.0)
    server.report("ready")
    identifier = add(server)
    fit(server, identifier)
    server.report("frame", 1, **FRAME)
    server.post(f"pictures/{identifier}/stop")
    server.act(lambda: None)
    assert server.worker.restarts == 1
    assert statuses(server) == ["stopped"]
    assert server.desk.pictures[identifier].last["done"]["svg"] == "<svg/>"


def test_a_worker_that_dies_fails_one_fit_and_is_replaced(server: Server) -> None:
    server.report("ready")
    first, second = add(server), add(server)
    fit(server, first)
    fit(server, second)
    server.report("died", message="out of memory")
    assert statuses(server) == ["failed", "waiting"]
    assert server.worker.restarts == 1
    server.report("ready")
    assert statuses(server) == ["failed", "fitting"]
    server.report("died", message="again")
    third = add(server)
    fit(server, third)
    server.report("died", message="before it was ready")  # it would do so forever
    assert server.worker.restarts == 2
    assert statuses(server) == ["failed", "failed", "failed"]
    fit(server, third)  # the user tries again
    assert server.worker.restarts == 3
    server.report("ready")
    assert statuses(server)[2] == "fitting"


def test_a_worker_that_dies_after_a_fit_was_dropped_does_not_cost_the_next_one(
    server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(desk, "DROP_SECONDS", 0.0)
    server.report("ready")
    identifier = add(server)
    fit(server, identifier)

    def drop_and_die() -> None:
        server.desk.remove(identifier)
        server.desk.receive(Report("died", 0, {"message": "out of memory"}))
        server.desk.receive(Report("ready", 0, {}))

    server.act(drop_and_die)
    server.act(lambda: None)
    assert server.worker.restarts == 1


def test_pages_see_their_own_pictures_and_behind_ones_only_the_newest_frame(server: Server) -> None:
    server.report("ready")
    own, other = add(server, "a"), add(server, "b")
    stream = server.act(lambda: server.desk.watch("a"))
    name, facts = server.events(stream, 1)[0]
    assert (name, facts["ready"]) == ("hello", True)
    assert [found["id"] for found in facts["pictures"]] == [own]
    fit(server, own)
    fit(server, other)
    for iteration in (1, 2, 3):
        server.report("frame", 1, **{**FRAME, "iteration": iteration})
    events = server.events(stream, 3)
    assert [name for name, _ in events] == ["queue", "status", "frame"] or [name for name, _ in events] == [
        "status", "queue", "frame",
    ]  # fmt: skip
    assert events[-1][1]["iteration"] == 3
    again = server.act(lambda: server.desk.watch("a"))  # the page has been loaded again
    assert ("frame", 3) in [(name, facts.get("iteration")) for name, facts in server.events(again, 3)]


def test_news_of_a_fit_have_the_number_that_the_page_has_given_it(server: Server) -> None:
    server.report("ready")
    own = add(server)
    fit(server, own, fit=7)
    server.report("frame", 1, **FRAME)
    fit(server, own, fit=9)  # before the page has heard of the frame
    server.report("dropped", 1)
    server.report("frame", 2, **FRAME)
    told = server.events(server.act(lambda: server.desk.watch("a")), 3)
    assert [facts.get("fit") for _, facts in told] == [None, 9, 9]
    assert told[0][1]["pictures"][0]["fit"] == 9


def test_a_page_that_is_loaded_again_hears_what_the_running_fit_does(server: Server) -> None:
    server.report("ready")
    fit(server, add(server))
    for words in ("looking for shadows", "joining curves"):
        server.report("stage", 1, words=words)
    events = server.events(server.act(lambda: server.desk.watch("a")), 4)
    assert [facts["words"] for name, facts in events if name == "stage"] == ["joining curves"]
    server.report("done", 1, **DONE)
    events = server.events(server.act(lambda: server.desk.watch("a")), 4)
    assert "stage" not in [name for name, _ in events] and "done" in [name for name, _ in events]


def test_pictures_of_a_closed_page_are_forgotten(server: Server, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pages, "FORGET_SECONDS", 0.0)
    server.report("ready")
    stream = server.act(lambda: server.desk.watch("a"))
    server.act(lambda: server.desk.watch("b"))
    fit(server, add(server, "a"))
    add(server, "b")
    server.act(lambda: server.desk.pages.leave("a", stream))
    server.act(lambda: None)
    assert [found.page for found in server.desk.pictures.values()] == ["b"]
    assert server.worker.stops == [Stop(1, is_dropped=True)]


def test_a_hidden_page_without_a_stream_is_kept_until_it_is_closed(
    server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pages, "FORGET_SECONDS", 0.0)
    server.report("ready")
    stream = server.act(lambda: server.desk.watch("a"))
    fit(server, add(server, "a"))
    assert server.post("rest?page=a").status_code == 204
    server.act(lambda: server.desk.pages.leave("a", stream))
    server.act(lambda: None)
    server.report("done", 1, **DONE)
    assert statuses(server) == ["done"]
    again = server.act(lambda: server.desk.watch("a"))
    assert [name for name, _ in server.events(again, 4)] == ["hello", "done", "status", "queue"]
    server.act(lambda: server.desk.pages.leave("a", again))  # without a word before
    server.act(lambda: None)
    assert statuses(server) == []


def test_a_hidden_page_that_is_closed_is_forgotten(server: Server, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pages, "FORGET_SECONDS", 0.0)
    stream = server.act(lambda: server.desk.watch("a"))
    add(server, "a")
    server.post("rest?page=a")
    server.act(lambda: server.desk.pages.leave("a", stream))
    server.act(lambda: None)
    assert statuses(server) == ["idle"]
    assert server.post("leave?page=a").status_code == 204
    server.act(lambda: None)
    assert statuses(server) == []


@pytest.mark.parametrize(
    ("request_", "message"),
    [
        ({"settings": {"curves": 0}}, "curves must be a whole number from 1 to"),
        ({"settings": {"curves": 10**9}}, "curves"),
        ({"settings": {"device": "cuda"}}, "settings"),
        ({"settings": {"detail": "x"}}, "detail"),
        ({"start": 5}, "start"),
        ({"fit": 0.5}, "fit must be a whole number"),
        ({"locked": [-1]}, "locked"),
        ({"locked": [True]}, "locked"),
    ],
)
def test_wrong_requests_are_refused_in_one_line(server: Server, request_: dict[str, object], message: str) -> None:
    identifier = add(server)
    answer = server.post(f"pictures/{identifier}/fit", request_)
    assert answer.status_code == 422
    assert message in answer.text
    assert "\n" not in answer.text.strip()
    assert server.post(f"pictures/{identifier}/fit", b"{").status_code == 422
    assert server.post("pictures/none/fit", {}).status_code == 404


def test_a_broken_picture_is_refused_at_once(server: Server) -> None:
    answer = server.post("pictures?page=a&key=k&name=x", b"GIF89a broken")
    assert answer.status_code == 422
    assert "must be a complete image, such as PNG, JPEG" in answer.text
    assert server.desk.pictures == {}


def test_the_folder_lists_pictures_and_takes_drawings_without_replacing_any(server: Server, tmp_path: Path) -> None:
    (tmp_path / "b.png").write_bytes(picture(8))
    (tmp_path / "notes.txt").write_text("secret")
    (tmp_path / "c.png").mkdir()
    assert server.get("folder").json() == ["b.png"]
    assert server.get("folder/b.png").content == picture(8)
    for name in ("notes.txt", "..%2Fb.png", "%2Fetc%2Fpasswd"):
        assert server.get(f"folder/{name}").status_code in (404, 422)
    svg = b'<svg xmlns="http://www.w3.org/2000/svg" width="8" height="4"><path d="M0 0h8v4h-8z" fill="#f00"/></svg>'
    for expected in ("b.svg", "b-2.svg"):
        answer = server.post("export?format=svg&name=../b&to=folder", svg)
        assert answer.json() == {"saved": expected, "bytes": len(svg), "losses": []}
        assert (tmp_path / expected).read_bytes() == svg
    png = server.post("export?format=png&width=80", svg).content
    (tmp_path / "saved.png").write_bytes(png)
    with Image.open(tmp_path / "saved.png") as image:
        assert image.size == (80, 40)
        assert image.getpixel((40, 20)) == (255, 0, 0)
    assert server.post(f"export?format=svg&name={'漢' * 120}&to=folder", svg).status_code == 201
    assert server.post("export?format=exe", svg).status_code == 422
    for size in ("", 'width="1e400" height="4"'):
        sizeless = svg.replace(b'width="8" height="4"', size.encode())
        assert server.post("export?format=svgz", sizeless).status_code == 422
    assert server.post("export?format=png&width=99999", svg).status_code == 422
    assert server.post("export?format=png", b"<svg").status_code == 422


def test_pages_that_save_at_the_same_time_get_files_of_their_own(tmp_path: Path) -> None:
    with ThreadPoolExecutor(8) as pool:
        names = list(pool.map(lambda n: folder.save_drawing(tmp_path, "b", ".svg", b"%d" % n), range(64)))
    assert sorted(int((tmp_path / name).read_bytes()) for name in names) == list(range(64))


def test_a_folder_that_has_gone_is_named(server: Server, tmp_path: Path) -> None:
    tmp_path.rename(tmp_path.with_name("elsewhere"))
    answer = server.get("folder")
    assert answer.status_code == 404
    assert "the folder of the server cannot be read" in answer.text
    assert server.get("folder/b.png").status_code == 404


@pytest.mark.skipif(os.name != "posix", reason="other systems have no such names and links")
def test_names_and_links_that_no_page_can_use_are_not_in_the_folder(server: Server, tmp_path: Path) -> None:
    inner = tmp_path / "pictures"
    inner.mkdir()
    (inner / "a.png").write_bytes(picture(4))
    (tmp_path / "secret.png").write_bytes(picture(8))
    (inner / "out.png").symlink_to(tmp_path / "secret.png")
    (inner / "same.png").symlink_to("a.png")
    (inner / "loop.png").symlink_to("loop.png")
    (inner / "folder.png").mkdir()
    with open(os.fsencode(inner) + b"/\xff\xfebad.png", "wb") as file:
        file.write(picture(4))
    assert folder.list_pictures(inner) == ["a.png", "same.png"]
    assert folder.read_picture(inner, "same.png", 10**6) == picture(4)
    with pytest.raises(InputError, match="must be in the folder of the server"):
        folder.read_picture(inner, "out.png", 10**6)
    (tmp_path / "loop.png").symlink_to("loop.png")
    with open(os.fsencode(tmp_path) + b"/\xff\xfebad.png", "wb") as file:
        file.write(picture(4))
    answer = server.get("folder")
    assert (answer.status_code, answer.json()) == (200, ["secret.png"])


def test_a_picture_that_is_removed_before_its_request_has_arrived_blocks_no_other(server: Server) -> None:
    server.report("ready")
    gone, other = add(server), add(server)

    async def body() -> AsyncIterator[bytes]:
        yield b"{"
        server.desk.remove(gone)
        yield b"}"

    path = f"/{TOKEN}/pictures/{gone}/fit"
    assert server.ask("POST", path, content=body(), headers={"content-length": "2"}).status_code == 404
    fit(server, other)
    assert [job.name for job in server.worker.jobs] == ["red"]
    assert statuses(server) == ["fitting"]


def test_pictures_of_a_page_that_never_listens_are_forgotten(server: Server, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pages, "FORGET_SECONDS", 0.0)
    server.act(lambda: server.desk.watch("b"))
    add(server, "a")
    kept = add(server, "b")
    server.act(lambda: None)
    assert list(server.desk.pictures) == [kept]


@pytest.mark.parametrize("name", ["start", "erased", "filled"])
def test_text_with_half_a_character_is_refused(server: Server, name: str) -> None:
    identifier = add(server)
    for half in ("\\ud800", "\\udfff"):
        answer = server.post(f"pictures/{identifier}/fit", f'{{"{name}": "<svg>{half}</svg>"}}'.encode())
        assert (answer.status_code, "must be SVG text" in answer.text) == (422, True)
    answer = server.post("reshape?to=outline", b'{"shapes": ["\\ud800"]}')
    assert (answer.status_code, "must be a list of SVG texts" in answer.text) == (422, True)
    fit(server, identifier, **{name: "<svg>\U0001f600</svg>"})
