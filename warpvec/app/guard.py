"""Refuse requests that do not come from the page of this server, and give every answer strict headers.

Programs on other machines cannot connect at all. Pages of other sites in the user's browser can, so each request must
have:

- the Host of this server, which a name that was made to point to this machine (DNS rebinding) does not have,
- an Origin of this server or none, and no other site as its source (Sec-Fetch-Site),
- the token, as the first part of its path. It is compared in a time that does not depend on it. Without the token
  there is only a proof that this is the server of a page (`warpvec.app.identity`).

The file that opens the browser (`warpvec.app.opening`) holds the address of a ticket, which leads to the page once and
soon, and not the token: a file may be left behind or copied.
"""

from __future__ import annotations

import hmac
import secrets
import time

from starlette.datastructures import MutableHeaders
from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from warpvec.app.identity import PROOF_PATH, Identity

HEADERS = {
    "Cache-Control": "no-store",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",  # the address holds the token
    "X-Content-Type-Options": "nosniff",
    "Content-Security-Policy": "default-src 'none'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'",
}
"""Headers of every answer that does not set them itself; the page has a policy of its own."""

TICKET_SECONDS = 120.0
"""Time in which a ticket can be used: a browser may start slowly."""

TICKET_PATH = "open"
"""First part of the path of a ticket."""

_SAME_SITE = ("same-origin", "none")


class Guard:
    """The application around the server's own, as ASGI.

    Args:
        app: serves the paths below the token.
        port: port of the server.
        identity: the secrets of the server.
    """

    def __init__(self, app: ASGIApp, port: int, identity: Identity) -> None:
        self._app, self._identity = app, identity
        self._hosts = {f"127.0.0.1:{port}", f"localhost:{port}"}
        self._ticket, self._ticket_end = "", 0.0

    def new_ticket(self) -> str:
        """Return the path of a new ticket without its first slash; the one before can no longer be used."""
        self._ticket = secrets.token_urlsafe(24)
        self._ticket_end = time.monotonic() + TICKET_SECONDS
        return f"{TICKET_PATH}/{self._ticket}"

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or refuse it."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)  # the start and the end of the server; there are no web sockets
            return

        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in HEADERS.items():
                    headers.setdefault(name, value)
            await send(message)

        answer = self._answer(Request(scope), scope["path"])
        if answer is not None:
            await answer(scope, receive, send_with_headers)
            return
        prefix = f"/{self._identity.token}"
        inner = {**scope, "root_path": scope.get("root_path", "") + prefix}
        await self._app(inner, receive, send_with_headers)

    def _answer(self, request: Request, path: str) -> Response | None:
        """Return a refusal, a proof, or the way to the page for a ticket; None for a request that may pass."""
        headers = request.headers
        host, origin = headers.get("host", ""), headers.get("origin")
        if host not in self._hosts or len(headers.getlist("host")) != 1:
            return PlainTextResponse("This server answers only to its own name.\n", 421)
        if origin is not None and origin != f"http://{host}":
            return PlainTextResponse("Requests of other sites are refused.\n", 403)
        if path == PROOF_PATH:
            proof = self._identity.proof(host, request.query_params.get("nonce", ""))
            return PlainTextResponse("The nonce must have 32 digits.\n", 400) if proof is None else JSONResponse(proof)
        if path.startswith(f"/{TICKET_PATH}/"):
            return self._exchange(path.removeprefix(f"/{TICKET_PATH}/"))
        given = path.split("/")[1] if path.startswith("/") else ""
        if not hmac.compare_digest(given.encode(), self._identity.token.encode()):
            return PlainTextResponse("Open the address that warpvec app has printed: its token is missing.\n", 403)
        # After the token: a browser that opens a link from another program may call it cross-site.
        is_page = path.count("/") <= 2 and path.endswith("/")
        if not is_page and headers.get("sec-fetch-site", "none") not in _SAME_SITE:
            return PlainTextResponse("Requests of other sites are refused.\n", 403)
        return None

    def _exchange(self, given: str) -> Response:
        """Return the way to the page for the ticket ``given``, which is used up."""
        is_good = bool(self._ticket) and hmac.compare_digest(given.encode(), self._ticket.encode())
        if not is_good or time.monotonic() > self._ticket_end:
            words = "This address has been used or is too old. Open the one that warpvec app has printed.\n"
            return PlainTextResponse(words, 403)
        self._ticket = ""
        return RedirectResponse(f"/{self._identity.token}/", 303)
