"""Only the page of the server may use it: the token, Host, Origin and sizes are checked on every request."""

from __future__ import annotations

import hmac
import os
import re
import stat
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
from app_server import IDENTITY, PORT, TOKEN, Server, server_fixture  # noqa: F401  (fixture)

from warpvec.app import address, guard, identity
from warpvec.app.identity import Identity
from warpvec.errors import InputError

OWN = {"Host": f"127.0.0.1:{PORT}", "Origin": f"http://127.0.0.1:{PORT}"}


@pytest.mark.parametrize(
    ("path", "headers", "status"),
    [
        ("/TOKEN/", OWN, 200),
        ("/TOKEN/", {"Host": f"localhost:{PORT}"}, 200),
        ("/TOKEN/folder", {**OWN, "Sec-Fetch-Site": "same-origin"}, 200),
        ("/", OWN, 403),
        ("/SHORT/", OWN, 403),
        ("/TOKENx/folder", OWN, 403),
        ("/folder", OWN, 403),
        ("//TOKEN/folder", OWN, 403),
        ("/TOKEN/folder", {"Host": "attacker.example"}, 421),
        ("/TOKEN/folder", {"Host": f"attacker.example:{PORT}"}, 421),
        ("/TOKEN/folder", {"Host": f"127.0.0.1:{PORT + 1}"}, 421),
        ("/TOKEN/folder", {"Origin": "http://attacker.example"}, 403),
        ("/TOKEN/folder", {"Origin": "null"}, 403),
        ("/TOKEN/folder", {"Origin": f"https://127.0.0.1:{PORT}"}, 403),
        ("/TOKEN/folder", {"Sec-Fetch-Site": "cross-site"}, 403),
        ("/TOKEN/folder", {"Sec-Fetch-Site": "same-site"}, 403),
    ],
)
def test_a_request_needs_the_token_and_comes_from_the_page(
    server: Server, path: str, headers: dict[str, str], status: int
) -> None:
    # The token is another one in each process of the tests, so it is no part of their names.
    answer = server.ask("GET", path.replace("TOKEN", TOKEN).replace("SHORT", TOKEN[:-1]), headers=headers)
    assert answer.status_code == status
    assert answer.headers["referrer-policy"] == "no-referrer"
    assert "default-src 'none'" in answer.headers["content-security-policy"]


def test_a_ticket_leads_to_the_page_once_and_soon(server: Server, monkeypatch: pytest.MonkeyPatch) -> None:
    path = f"/{server.guard.new_ticket()}"
    assert TOKEN not in path
    assert server.ask("GET", path, headers={"Host": "attacker.example"}).status_code == 421
    assert server.ask("GET", f"{path}x").status_code == 403
    answer = server.ask("GET", path)
    assert (answer.status_code, answer.headers["location"]) == (303, f"/{TOKEN}/")
    assert server.ask("GET", path).status_code == 403
    assert server.ask("GET", "/open/").status_code == 403  # as empty as the used one
    monkeypatch.setattr(guard, "TICKET_SECONDS", -1.0)
    assert server.ask("GET", f"/{server.guard.new_ticket()}").status_code == 403


def test_a_foreign_page_changes_nothing(server: Server) -> None:
    url = f"/{TOKEN}/pictures?page=a&key=k&name=x"
    assert server.ask("POST", url, headers={"Origin": "http://attacker.example"}).status_code == 403
    assert server.ask("POST", "/pictures?page=a&key=k").status_code == 403
    assert server.desk.pictures == {}


def test_the_policy_of_the_page_allows_only_its_own_scripts_and_server(server: Server) -> None:
    policy = server.get("").headers["content-security-policy"]
    assert "unsafe" not in policy
    assert "connect-src 'self'" in policy
    assert policy.count("sha256-") == 1
    (nonce,) = re.findall(r"script-src 'nonce-([\w-]{24})';", policy)
    assert server.get("").text.count(f'nonce="{nonce}"') == 2


def test_too_large_bodies_are_refused(server: Server, monkeypatch: pytest.MonkeyPatch) -> None:
    from warpvec.app import desk, routes

    monkeypatch.setattr(routes, "MAX_PICTURE_BYTES", 1000)
    assert server.post("pictures?page=a&key=k", bytes(1001)).status_code == 413
    assert server.ask("POST", f"/{TOKEN}/pictures?page=a&key=k", content=_without_length()).status_code == 413
    monkeypatch.setattr(desk, "KEPT_BYTES", 500)
    assert server.post("pictures?page=a&key=k", bytes(501)).status_code == 413
    assert server.desk.pictures == {}


async def _without_length() -> AsyncIterator[bytes]:
    for _ in range(2):
        yield bytes(600)


@pytest.mark.skipif(os.name != "posix", reason="the modes of files are POSIX's")
def test_the_key_stays_for_a_restart_but_no_other_user_can_set_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    key = identity.read_key(PORT)
    assert identity.read_key(PORT) == key
    assert identity.read_key(PORT + 1) != key
    path = tmp_path / "warpvec" / f"key-{PORT}"
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    path.chmod(0o644)
    second = identity.read_key(PORT)
    assert second != key
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    monkeypatch.setattr(identity, "KEY_SECONDS", 0.0)
    assert identity.read_key(PORT) != second


def test_each_start_has_a_token_of_its_own_that_only_the_key_gives(server: Server) -> None:
    key = bytes.fromhex(IDENTITY.key)
    nonce = "0f" * 16
    answer = server.ask("GET", f"/proof?nonce={nonce}")
    start, proof = answer.json()["start"], answer.json()["proof"]
    assert TOKEN not in answer.text and IDENTITY.key not in answer.text
    # As the page checks it, in app/assets/proof.js.
    signed = hmac.new(key, f"proof 127.0.0.1:{PORT} {nonce} {start}".encode(), "sha256").hexdigest()
    assert proof == signed
    assert hmac.new(key, f"token {start}".encode(), "sha256").hexdigest()[:32] == TOKEN
    assert server.ask("GET", f"/proof?nonce={nonce[:-1]}0").json()["proof"] != proof
    assert Identity(IDENTITY.key).token != TOKEN
    for query in ("", "?nonce=", "?nonce=0f", f"?nonce={nonce}%20"):
        assert server.ask("GET", f"/proof{query}").status_code == 400
    assert server.ask("GET", f"/proof?nonce={nonce}", headers={"Host": "attacker.example"}).status_code == 421


def test_a_given_port_that_is_taken_is_refused_and_else_another_is_used() -> None:
    with address.open_socket(None) as first:
        port = first.getsockname()[1]
        assert first.getsockname()[0] == "127.0.0.1"
        first.listen()
        with pytest.raises(InputError, match="--port must be a free port"):
            address.open_socket(port)
        if port == address.DEFAULT_PORT:
            with address.open_socket(None) as second:
                assert second.getsockname()[1] != port
