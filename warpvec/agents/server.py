"""The MCP server of the tools, by the package "mcp" of the protocol's authors (MIT), the extra "mcp"."""

from __future__ import annotations

import json
from typing import Any

from mcp.server.mcpserver import MCPServer
from mcp.server.mcpserver.exceptions import ToolError
from mcp_types import CallToolResult, ImageContent, TextContent

from warpvec import __version__
from warpvec.agents.folders import Folders
from warpvec.agents.tools import Answer, Tools
from warpvec.errors import InputError

_INSTRUCTIONS = """Turn pictures into editable SVGs, and measure them. Files must be in: {folders}. A relative path
begins in the first of these. `out` may end in {suffixes}. `settings` are keyword arguments of warpvec.vectorize, such
as {{"mode": "flat", "colors": 4, "max_bytes": 20000, "size": "90mm"}}; a wrong one is refused with what is allowed."""

_REFINE = "Fit the paths of an SVG to a picture; the result is never worse. `settings` as in vectorize."

_EVALUATE = "Measure how well an SVG, drawn by resvg, matches a picture: PSNR in dB, SSIM, bytes, paths."


def make_server(folders: Folders, threads: int | None = None) -> MCPServer:
    """Return the server of the tools on the files of ``folders``; see `Tools`."""
    from warpvec.writers.registry import WRITERS

    listed = ", ".join(map(str, folders.roots))
    instructions = _INSTRUCTIONS.format(folders=listed, suffixes=", ".join(WRITERS))
    server = MCPServer("warpvec", version=__version__, instructions=instructions, log_level="WARNING")
    tools = Tools(folders, threads)

    @server.tool(description=f"Draw a picture as an SVG or another file. {instructions}")
    def vectorize(
        image: str, out: str, settings: dict[str, Any] | None = None, overwrite: bool = False
    ) -> CallToolResult:
        return _result(lambda: tools.vectorize(image, out, settings or {}, overwrite=overwrite))

    @server.tool(description=_REFINE)
    def refine(
        image: str, svg: str, out: str, settings: dict[str, Any] | None = None, overwrite: bool = False
    ) -> CallToolResult:
        return _result(lambda: tools.refine(image, svg, out, settings or {}, overwrite=overwrite))

    @server.tool(description=_EVALUATE)
    def evaluate(image: str, svg: str) -> CallToolResult:
        return _result(lambda: tools.evaluate(image, svg))

    return server


def _result(answer: Any) -> CallToolResult:
    """Return what a tool answers: its facts as JSON, and a picture.

    Raises:
        ToolError: the tool refuses its input.
    """
    try:
        found: Answer = answer()
        preview = found.preview()
    except InputError as error:
        raise ToolError(str(error)) from error
    content: list[Any] = [
        TextContent(type="text", text=json.dumps(found.facts)),
        ImageContent(type="image", data=preview, mime_type="image/png"),
    ]
    return CallToolResult(content=content, structured_content=found.facts)
