"""``warpvec app`` on the command line: its mistakes are named before anything starts."""

from __future__ import annotations

import http.client
import queue
import stat
import threading
import time
import webbrowser
from contextlib import suppress
from pathlib import Path
from typing import Any
from urllib.request import urlopen

import pytest
from children import limit
from commands import invoke
from desk_browser import DeskServer

from warpvec.cli.commands import app as command


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["no-such-folder"], "FOLDER must be an existing folder"),
        ([""], "FOLDER must be an existing folder"),
        (["--port", "70000"], "'--port': 70000 is not in the range 1024<=x<=65535"),
        (["--port", "80"], "--port"),
    ],
)
def test_mistakes_are_one_line(tmp_path: Path, arguments: list[str], message: str) -> None:
    result = invoke("app", "--no-browser", *arguments)
    assert result.exit_code == 2
    assert message in result.stderr
    assert result.stderr.count("\n") == 1


def test_the_extra_is_named_if_it_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(command, "find_spec", lambda name: None)
    result = invoke("app", "--no-browser")
    assert result.exit_code == 2
    assert "pip install 'warpvec[app]'" in result.stderr


class Browser:
    """What the module webbrowser knows of a browser."""

    def __init__(self, name: str) -> None:
        self.name = name


@pytest.mark.parametrize(
    ("browser", "options", "opens"),
    [("firefox", (), True), ("firefox", ("--no-browser",), False), ("/usr/bin/lynx", (), False), (None, (), False)],
)
def test_the_address_is_printed_and_the_browser_gets_a_private_file(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, browser: str | None, options: tuple[str, ...], opens: bool
) -> None:
    from warpvec.app import server

    opened: queue.SimpleQueue[tuple[str, str, int]] = queue.SimpleQueue()
    found: list[tuple[str, str, int]] = []

    def run_server(listener: Any, identity: Any, **options: Any) -> None:
        root = f"http://127.0.0.1:{listener.getsockname()[1]}"
        options["on_start"](f"{root}/{identity.token}/", f"{root}/ticket")
        if opens:
            found.append(opened.get(timeout=limit(10)))

    def get() -> Browser:
        if browser is None:
            raise webbrowser.Error
        return Browser(browser)

    def open_file(url: str) -> None:
        path = Path(url.removeprefix("file://"))
        opened.put((url, path.read_text(), stat.S_IMODE(path.stat().st_mode)))

    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setattr(server, "run_server", run_server)
    monkeypatch.setattr(webbrowser, "get", get)
    monkeypatch.setattr(webbrowser, "open", open_file)
    result = invoke("app", *options)
    assert result.exit_code == 0, result.stderr
    address = result.stderr.split()[4]
    assert address.startswith("http://127.0.0.1:")
    if opens:
        ((url, text, mode),) = found
        ticket = "/".join([*address.split("/")[:3], "ticket"])
        assert f'content="0; url={ticket}"' in text
        # All users of the machine see the arguments of a browser.
        assert url.startswith("file://") and "ticket" not in url and address.split("/")[3] not in url
        assert mode == 0o600
        assert not Path(url.removeprefix("file://")).exists()
    assert opened.empty()


def test_a_signal_ends_a_busy_server(tmp_path: Path) -> None:
    # An exception that a handler raises in the middle of a request is lost there.
    server = DeskServer(tmp_path)
    stop = threading.Event()
    drawing = b'<svg xmlns="http://www.w3.org/2000/svg" width="9" height="9"><path d="M0 0H9" stroke="red"/></svg>'

    def ask(path: str, body: bytes | None) -> None:
        while not stop.is_set():
            with suppress(OSError, http.client.HTTPException):
                urlopen(server.url + path, body, timeout=1).close()

    tasks = [("", None), ("export?format=png", drawing), ("events?page=a", None)]
    threads = [threading.Thread(target=ask, args=task) for task in tasks]
    for thread in threads:
        thread.start()
    try:
        time.sleep(0.5)
        assert server.end() == 130
    finally:
        stop.set()
        for thread in threads:
            thread.join()
