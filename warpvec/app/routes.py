"""The requests of the page, below the token of the address; see `warpvec.app.guard`.

GET    /                        the page
GET    /events?page=            server-sent events: hello, ready, queue, status, mode, stage, frame, done, failed
POST   /rest?page=              the page is hidden and gives up its events
POST   /leave?page=             it is closed, or loaded again
POST   /pictures?page=&key=&name=   a picture's file in the body -> its facts; the key is the page's own name for it
GET    /pictures/ID/preview     the picture as PNG, for browsers that cannot read its format
POST   /pictures/ID/fit         {fit, settings, start, before, locked, erased, filled, keepsPaths, cuts}: fit it
POST   /pictures/ID/measure     SVG text in the body -> its closeness to the picture
POST   /pictures/ID/stop        end the fit with its best drawing so far
DELETE /pictures/ID             forget it
GET    /folder                  names of the pictures in the folder of the server
GET    /folder/NAME             one of them
POST   /reshape?to=             {shapes: SVG texts of one shape each} -> the same shapes in other words, or what is left
POST   /cut?machine=            SVG text in the body -> its size, and what will go wrong on the machine
POST   /open                    the file of an SVG in the body -> its drawing for the page, its text, size and figures
POST   /export?format=&width=&transparent=&name=&for=&to=   SVG text in the body -> a file, or its name in the folder
"""

from __future__ import annotations

import asyncio
import json
import math
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, PlainTextResponse, Response, StreamingResponse
from starlette.routing import Route

from warpvec.app.desk import Desk, PagePicture
from warpvec.app.export import MEDIA_TYPES, encode
from warpvec.app.folder import list_pictures, read_picture, save_drawing, usable_name
from warpvec.app.making import cut_facts
from warpvec.app.page import page_text
from warpvec.app.settings import FitSettings
from warpvec.errors import InputError
from warpvec.image.picture import reduce_image
from warpvec.image.read import read_image
from warpvec.image.write import png_bytes, to_8_bits
from warpvec.svg.document import read_text
from warpvec.svg.measure import file_quality
from warpvec.viewer.page import PAGE_PHOTO_SIDE, page_data
from warpvec.writers.png import drawing_size

MAX_PICTURE_BYTES = 2**28
"""Largest picture file: 256 MiB, those of 50 megapixels with room. The command reads larger ones, with less memory."""

MAX_TEXT_BYTES = 2**26
"""Largest SVG text or JSON of a request: 64 MiB, the limit of drawings that are read as paths."""

LOCKED_MAX = 2**15
"""Most paths of a drawing that is read."""


class Routes:
    """The answers of the server.

    Args:
        desk: pictures and fits.
        folder: where pictures are listed and drawings are saved; None for nowhere.
        formats: the formats in which a drawing can be saved.
        key: what pages know their server by; see `warpvec.app.identity`.
    """

    def __init__(self, desk: Desk, folder: Path | None, formats: list[str], key: str) -> None:
        self._desk, self._folder, self._formats = desk, folder, formats
        self._page, self._policy = page_text(key)

    def application(self) -> Starlette:
        """Return the ASGI application."""
        routes = [
            Route("/", self.page),
            Route("/events", self.events),
            Route("/rest", self.rest, methods=["POST"]),
            Route("/leave", self.leave, methods=["POST"]),
            Route("/pictures", self.add, methods=["POST"]),
            Route("/pictures/{id}/preview", self.preview),
            Route("/pictures/{id}/fit", self.fit, methods=["POST"]),
            Route("/pictures/{id}/measure", self.measure, methods=["POST"]),
            Route("/pictures/{id}/stop", self.stop, methods=["POST"]),
            Route("/pictures/{id}", self.remove, methods=["DELETE"]),
            Route("/folder", self.folder),
            Route("/folder/{name}", self.from_folder),
            Route("/reshape", self.reshape, methods=["POST"]),
            Route("/cut", self.cut, methods=["POST"]),
            Route("/open", self.open, methods=["POST"]),
            Route("/export", self.export, methods=["POST"]),
        ]
        handlers: dict[Any, Callable[[Request, Exception], Awaitable[Response]]] = {InputError: _wrong_input}
        return Starlette(routes=routes, exception_handlers=handlers)

    async def page(self, request: Request) -> Response:
        """Return the page."""
        headers = {"Content-Security-Policy": self._policy}
        return Response(self._page, media_type="text/html", headers=headers)

    async def events(self, request: Request) -> Response:
        """Return the stream of events of a page."""
        page = _page_of(request)

        async def texts() -> Any:
            stream = self._desk.watch(page)  # here, as the rest is never run for a page that has left before
            stream.put("server", {"formats": self._formats, "folder": self._folder and self._folder.name})
            try:
                async for text in stream.texts():
                    yield text
            finally:
                self._desk.pages.leave(page, stream)

        return StreamingResponse(texts(), media_type="text/event-stream")

    async def rest(self, request: Request) -> Response:
        """Note that nobody looks at a page."""
        self._desk.pages.rest(_page_of(request))
        return Response(status_code=204)

    async def leave(self, request: Request) -> Response:
        """Note that a page is closed."""
        self._desk.pages.close(_page_of(request))
        return Response(status_code=204)

    async def add(self, request: Request) -> Response:
        """Add the picture in the body."""
        page, key = _page_of(request), _identifier(request, "key")
        name = usable_name(request.query_params.get("name", "picture"))
        data = await _body(request, MAX_PICTURE_BYTES)
        if not self._desk.has_room(len(data)):
            raise HTTPException(413, "too many pictures are open: remove some from the list")
        size = await asyncio.to_thread(_size_of, data)
        return JSONResponse(self._desk.add(page, key, name, data, size).facts(), 201)

    async def preview(self, request: Request) -> Response:
        """Return a small PNG of a picture."""
        picture = self._picture(request)
        return Response(await asyncio.to_thread(_preview, picture.data), media_type="image/png")

    async def fit(self, request: Request) -> Response:
        """Queue a picture for a fit with the settings in the body."""
        self._picture(request)
        asked = _object(await _body(request, MAX_TEXT_BYTES))
        picture = self._picture(request)  # it may have been removed while the body arrived
        settings = FitSettings(asked.get("settings", {}))
        texts = {name: asked.get(name) for name in ("start", "before", "erased", "filled")}
        if not all(text is None or _is_text(text) for text in texts.values()):
            raise InputError("start", "must be SVG text", "something else", "reload the page")
        ways = {"keeps_paths": asked.get("keepsPaths") is True, "cuts": asked.get("cuts") is True}
        locked = _places(asked.get("locked", []))
        self._desk.fit(picture, _number(asked.get("fit", 0)), settings, locked=locked, **ways, **texts)
        return JSONResponse(picture.facts(), 202)

    async def measure(self, request: Request) -> Response:
        """Return the PSNR of the drawing in the body against a picture."""
        text = (await _body(request, MAX_TEXT_BYTES)).decode("utf-8", "replace")
        return JSONResponse({"psnr": await asyncio.to_thread(_psnr_of, text, self._picture(request).data)})

    async def stop(self, request: Request) -> Response:
        """End the fit of a picture with its best result."""
        self._desk.stop(self._picture(request))
        return Response(status_code=204)

    async def remove(self, request: Request) -> Response:
        """Remove a picture."""
        self._desk.remove(self._picture(request).identifier)
        return Response(status_code=204)

    async def folder(self, request: Request) -> Response:
        """Return the pictures in the folder of the server."""
        try:
            names = [] if self._folder is None else await asyncio.to_thread(list_pictures, self._folder)
        except OSError as error:
            raise _unreadable(error) from error
        return JSONResponse(names)

    async def from_folder(self, request: Request) -> Response:
        """Add a picture of the folder."""
        if self._folder is None:
            raise HTTPException(404, "the server was started without a folder")
        name = request.path_params["name"]
        try:
            data = await asyncio.to_thread(read_picture, self._folder, name, MAX_PICTURE_BYTES)
        except OSError as error:
            raise _unreadable(error) from error
        return Response(data, media_type="application/octet-stream")

    async def reshape(self, request: Request) -> Response:
        """Return the shapes in the body as strokes, outlines or forms."""
        texts = _object(await _body(request, MAX_TEXT_BYTES)).get("shapes")
        if not isinstance(texts, list) or not all(map(_is_text, texts)):
            raise InputError("shapes", "must be a list of SVG texts", "something else", "reload the page")
        found = await asyncio.to_thread(_reshaped, texts, request.query_params.get("to", ""))
        return JSONResponse({"shapes": found})

    async def cut(self, request: Request) -> Response:
        """Return the size of the drawing in the body, and what will go wrong on a machine."""
        text = (await _body(request, MAX_TEXT_BYTES)).decode("utf-8", "replace")
        return JSONResponse(await asyncio.to_thread(cut_facts, text, request.query_params.get("machine", "")))

    async def open(self, request: Request) -> Response:
        """Return the drawing of an SVG file of any program."""
        return JSONResponse(await asyncio.to_thread(_opened, await _body(request, MAX_TEXT_BYTES)))

    async def export(self, request: Request) -> Response:
        """Return the drawing in the body as a file of another kind."""
        kind, name = request.query_params.get("format", "svg"), request.query_params.get("name", "drawing")
        text = (await _body(request, MAX_TEXT_BYTES)).decode("utf-8", "replace")
        width, is_clear = request.query_params.get("width"), request.query_params.get("transparent") == "1"
        options: dict[str, Any] = {"name": name, "transparent": is_clear, "purpose": request.query_params.get("for")}
        data, losses = await asyncio.to_thread(encode, text, kind, _whole(width), **options)
        if request.query_params.get("to") != "folder" or self._folder is None:
            return Response(data, media_type=MEDIA_TYPES[kind], headers={"Warpvec-Losses": json.dumps(losses)})
        try:
            saved = await asyncio.to_thread(save_drawing, self._folder, name, f".{kind}", data)
        except OSError as error:
            raise HTTPException(507, f"the file could not be written ({error.strerror})") from error
        return JSONResponse({"saved": saved, "bytes": len(data), "losses": losses}, 201)

    def _picture(self, request: Request) -> PagePicture:
        picture = self._desk.pictures.get(request.path_params["id"])
        if picture is None:
            raise HTTPException(404, "the server does not have this picture any more")
        return picture


def _unreadable(error: OSError) -> HTTPException:
    return HTTPException(404, f"the folder of the server cannot be read ({error.strerror})")


async def _wrong_input(request: Request, error: Exception) -> Response:
    return PlainTextResponse(str(error), 422)


def _page_of(request: Request) -> str:
    """Return the identifier that a page has given itself."""
    return _identifier(request, "page")


def _identifier(request: Request, kind: str) -> str:
    """Return the identifier of a ``kind`` of thing that a page has made."""
    text = request.query_params.get(kind, "")
    if not (text.replace("-", "").isalnum() and len(text) <= 64):
        raise HTTPException(400, f"the {kind} must be an identifier: reload the page")
    return text


async def _body(request: Request, limit: int) -> bytes:
    """Return the body of a request of at most ``limit`` bytes; a larger one is refused before it has arrived."""
    stated = request.headers.get("content-length", "0")
    parts, count = [], 0
    if stated.isdecimal() and int(stated) <= limit:
        try:
            async for part in request.stream():
                count += len(part)
                if count > limit:
                    break
                parts.append(part)
            else:
                return b"".join(parts)
        except ClientDisconnect:
            raise HTTPException(400, "the request ended early") from None
    raise HTTPException(413, f"a file may have at most {limit >> 20} MiB")


def _is_text(found: object) -> bool:
    """Return whether a value of JSON is text that can be encoded: text of JSON may hold half a character."""
    if not isinstance(found, str):
        return False
    try:
        found.encode()
    except UnicodeEncodeError:
        return False
    return True


def _object(data: bytes) -> dict[str, Any]:
    try:
        found = json.loads(data)
    except (ValueError, RecursionError):
        found = None
    if not isinstance(found, dict):
        raise InputError("request", "must be a JSON object", repr(data[:40]), "reload the page")
    return found


def _places(found: object) -> tuple[int, ...]:
    if isinstance(found, list) and len(found) <= LOCKED_MAX:
        places = [place for place in found if type(place) is int and 0 <= place < LOCKED_MAX]
        if len(places) == len(found):
            return tuple(sorted(set(places)))
    raise InputError("locked", "must be a list of places of paths", str(found)[:40], "reload the page")


def _number(found: object) -> int:
    """Return a number that a page has given."""
    if type(found) is int and 0 <= found < 2**53:  # larger ones are not whole numbers on a page
        return found
    raise InputError("fit", "must be a whole number", str(found)[:40], "reload the page")


def _whole(text: str | None) -> int | None:
    if text is None or (text.isdecimal() and len(text) < 8):
        return None if text is None else int(text)
    raise InputError("width", "must be a whole number of pixels", repr(text), "give another")


def _reshaped(texts: list[str], words: str) -> list[dict[str, Any]]:
    """Return `reshape` of shapes. It brings the stages of flat art, which few pages need, and takes seconds to load."""
    from warpvec.app.reshaping import reshape

    return reshape(texts, words)


def _opened(data: bytes) -> dict[str, Any]:
    """Return what the page shows of an SVG file, its text as it is, and its size in pixels."""
    text = read_text(data)
    width, height = drawing_size(text)
    return {**page_data(data, None), "text": text, "width": width, "height": height}


def _psnr_of(text: str, data: bytes) -> float | None:
    """Return the PSNR in dB of a drawing against a picture file; None if they are equal."""
    psnr = file_quality(text.encode(), read_image(data, name="picture"))["psnr"]
    return psnr if math.isfinite(psnr) else None


def _size_of(data: bytes) -> tuple[int, int]:
    """Return width and height of a picture file, read whole, so that a broken one is refused at once."""
    pixels = read_image(data, name="picture")
    return pixels.shape[1], pixels.shape[0]


def _preview(data: bytes) -> bytes:
    pixels = reduce_image(read_image(data, name="picture"), PAGE_PHOTO_SIDE)
    return png_bytes(to_8_bits(pixels), compress_level=1)
