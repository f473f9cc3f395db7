"""A server of ``warpvec app`` that ends and comes back, signals, and requests from outside of the page."""

from __future__ import annotations

import http.client
import json
import os
import signal
import threading
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path

import numpy as np
import pytest
from browser import NEEDS_BROWSER, browser_fixture  # noqa: F401  (fixture)
from children import runs, wait_for
from desk_browser import DeskPage, DeskServer
from PIL import Image

from warpvec.svg.measure import file_facts

pytestmark = NEEDS_BROWSER


def write_photo(path: Path, side: int = 400) -> Path:
    rng = np.random.default_rng(0)
    coarse = rng.integers(0, 255, (12, 16, 3), np.uint8)
    Image.fromarray(coarse).resize((side, side * 3 // 4), Image.Resampling.BICUBIC).save(path)
    return path


class Impostor:
    """A program of another user that listens at the port of a server that has ended, and answers everything.

    Args:
        port: of the server.
    """

    def __init__(self, port: int) -> None:
        lines: list[str] = []

        class Handler(BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                lines.append(self.requestline)
                body = json.dumps({"start": "0" * 32, "proof": "0" * 64}).encode()
                self.send_response(200)
                self.send_header("Content-Length", str(len(body)))
                self.end_headers()
                self.wfile.write(body)

            def do_POST(self) -> None:
                self.do_GET()

            def log_message(self, *parts: object) -> None:
                pass

        self.lines = lines
        self._server = HTTPServer(("127.0.0.1", port), Handler)
        self._thread = threading.Thread(target=self._server.serve_forever)

    def __enter__(self) -> Impostor:
        self._thread.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._server.shutdown()
        self._thread.join()
        self._server.server_close()


@pytest.mark.skipif(not os.path.isdir("/proc"), reason="the processes are found in /proc")
def test_the_page_says_that_the_server_has_ended_and_goes_on_with_a_new_one(browser, tmp_path: Path) -> None:
    server = DeskServer(tmp_path)
    desk = DeskPage(browser, server, tmp_path)
    desk.slide("set-detail", 24)  # so that the fit does not end before it is stopped
    desk.page.locator("#set-mode label").nth(1).click()
    desk.drop(write_photo(tmp_path / "photo.png"))
    desk.wait_for_frame(12.0)
    worker = server.children()
    assert worker
    server.end(signal.SIGKILL)
    desk.page.wait_for_selector("#lost:not([hidden])")
    assert "Run warpvec app again" in desk.page.inner_text("#lost")
    wait_for(lambda: not any(map(runs, worker)))
    # What has been drawn so far can be saved.
    count = file_facts(desk.save().read_bytes())["paths"]
    assert count > 0
    address = server.url
    with Impostor(server.port) as impostor:
        wait_for(lambda: len(impostor.lines) > 2)
        desk.page.wait_for_function("() => document.getElementById('lost').textContent.includes('Another server')")
    assert all(line.startswith("GET /proof?nonce=") for line in impostor.lines), impostor.lines
    seen = desk.page.evaluate("() => window.statuses.length")
    server.start()
    assert server.url != address
    desk.page.wait_for_selector("#lost", state="hidden")
    # The last frame of the server that has ended stays until the new one sends its first.
    desk.begins_to_draw(seen)
    desk.wait_for_frame(12.0)
    desk.page.evaluate("() => document.getElementById('stop').click()")  # at once: the fit may be close to its end
    desk.wait_for_status("Stopped")
    assert file_facts(desk.save().read_bytes())["paths"] >= count
    desk.page.reload()
    desk.page.wait_for_selector("body[data-desk]")
    assert desk.page.url == server.url
    assert all("ERR_" in text or "reset" in text.lower() for text in desk.complaints)  # the browser's notes
    desk.page.close()
    assert server.end() == 130


def test_a_fit_that_is_stopped_before_a_new_server_has_it_does_not_begin_again(browser, tmp_path: Path) -> None:
    server = DeskServer(tmp_path)
    desk = DeskPage(browser, server, tmp_path)
    desk.slide("set-detail", 24)
    desk.page.locator("#set-mode label").nth(1).click()
    desk.drop(write_photo(tmp_path / "photo.png"))
    desk.wait_for_frame(12.0)
    server.end(signal.SIGKILL)
    desk.page.wait_for_selector("#lost:not([hidden])")
    # Press Stop as soon as it can be pressed: the page has not yet learned that the new server lacks the picture.
    desk.page.evaluate("""() => {
        const stop = document.getElementById("stop");
        const press = () => !stop.disabled && stop.click();
        new MutationObserver(press).observe(stop, { attributes: true, attributeFilter: ["disabled"] });
    }""")
    server.start()
    desk.wait_for_status("Stopped")
    assert file_facts(desk.save().read_bytes())["paths"] > 0
    desk.page.close()
    assert server.end() == 130


def test_requests_from_outside_are_refused_and_the_folder_is_used(browser, tmp_path: Path) -> None:
    folder = tmp_path / "pictures"
    folder.mkdir()
    write_photo(folder / "small.png", 64)
    server = DeskServer(tmp_path, folder)
    token = server.url.split("/")[3]
    own = f"127.0.0.1:{server.port}"
    for path, headers, status in [
        (f"/{token}/", {"Host": own}, 200),
        (f"/{token}/", {"Host": f"attacker.example:{server.port}"}, 421),
        (f"/{token}/folder", {"Host": own, "Origin": "http://attacker.example"}, 403),
        ("/", {"Host": own}, 403),
        (f"/{'x' * len(token)}/events?page=a", {"Host": own}, 403),
    ]:
        connection = http.client.HTTPConnection("127.0.0.1", server.port)
        connection.request("GET", path, headers=headers)
        assert connection.getresponse().status == status, (path, headers)
        connection.close()
    desk = DeskPage(browser, server, tmp_path)
    desk.slide("set-detail", 0)
    desk.page.locator("#folder").select_option(label="small.png")
    desk.wait_for_frame()
    desk.page.reload()  # the server still has it
    desk.page.wait_for_selector("body[data-desk]")
    desk.wait_for_status("done")
    desk.page.locator("[data-format=svg]").click()
    desk.page.wait_for_function("() => document.getElementById('message').textContent.includes('Saved')")
    assert desk.page.inner_text("#message").startswith("Saved small.svg in pictures")
    assert file_facts((folder / "small.svg").read_bytes())["paths"] > 0
    desk.close()
    worker = server.children()
    assert server.end() == 130
    wait_for(lambda: not any(map(runs, worker)))
