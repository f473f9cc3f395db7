"""Run the extension for Inkscape: its scripts alone, by Inkscape's Python, or in Inkscape without a screen."""

from __future__ import annotations

import base64
import json
import os
import re
import shutil
import signal
import subprocess
import sys
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from children import limit, start
from numpy.typing import NDArray
from PIL import Image

import warpvec

EXTENSION = Path(warpvec.__file__).parent / "inkscape" / "extension"
sys.path.append(str(EXTENSION))  # its scripts import each other by their file names

SECONDS = 120
"""Longest time of a run. A message of Inkscape waits for a click, which never comes."""

_SYSTEM_PATH = "/usr/local/bin:/usr/bin:/bin"
"""Where Inkscape must look for Python. That of a virtual environment does not have what extensions need."""


@cache
def why_no_scripts() -> str:
    """Return why the extension's scripts cannot run alone, "" if they can."""
    if shutil.which("inkscape") is None:
        return "Inkscape is not installed"
    done = subprocess.run(
        [_python(), "-c", "import inkex"], env=_environment(), capture_output=True, text=True, check=False
    )
    return "" if done.returncode == 0 else f"inkex does not work: {done.stderr.strip().splitlines()[-1]}"


@cache
def why_no_screen() -> str:
    """Return why Inkscape cannot run the extension, "" if it can."""
    return why_no_scripts() or ("" if shutil.which("xvfb-run") else "xvfb-run is not installed")


def _python() -> str:
    return shutil.which("python3", path=_SYSTEM_PATH) or "python3"


def _environment(**more: str) -> dict[str, str]:
    kept = {name: value for name, value in os.environ.items() if name in ("HOME", "LANG", "TMPDIR", "WARP_CACHE_PATH")}
    return {**kept, "PATH": _SYSTEM_PATH, "PYTHONPATH": _extensions(), "PYTHONDONTWRITEBYTECODE": "1", **more}


@cache
def _extensions() -> str:
    """Return the folder of the extensions that come with Inkscape, which has inkex."""
    command = ["inkscape", "--system-data-directory"]
    data = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    return str(Path(data.strip()) / "extensions")


def start_script(folder: Path, name: str, document: Path, *arguments: str) -> subprocess.Popen[str]:
    """Start the script ``name`` of the extension installed in ``folder`` on ``document``, as Inkscape does."""
    command = [_python(), str(folder / name), *arguments, str(document)]
    environment = _environment(DOCUMENT_PATH=str(document))
    return start(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=folder)


def run_script(folder: Path, name: str, document: Path, *arguments: str) -> tuple[str, str]:
    """Run a script as `start_script` does; return what it wrote to stdout, the new document, and to stderr."""
    with start_script(folder, name, document, *arguments) as process:
        return process.communicate(timeout=limit(SECONDS))


def run_inkscape(document: Path, actions: str, out: Path, profile: Path) -> None:
    """Let Inkscape, with the user's folder ``profile``, do ``actions`` on ``document`` and write it to ``out``."""
    wanted = f"{actions};export-filename:{out};export-do"
    command = ["xvfb-run", "-a", "inkscape", "--batch-process", f"--actions={wanted}", str(document)]
    environment = _environment(INKSCAPE_PROFILE_DIR=str(profile), GTK_A11Y="none", NO_AT_BRIDGE="1")
    del environment["PYTHONPATH"]
    options = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "start_new_session": True}
    with start(command, env=environment, **options) as process:
        try:
            assert process.wait(limit(SECONDS)) == 0
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)  # Inkscape and its screen, not only the script that starts them
            raise


def opened_dxf(path: Path, out: Path) -> str:
    """Return what Inkscape makes of a DXF file, as the text of an SVG that Inkscape wrote to ``out``.

    Its reader of DXF files runs alone, since Inkscape asks for its settings in a window, also with --batch-process.
    """
    reader = [_python(), str(Path(_extensions()) / "dxf_input.py"), str(path)]
    options: dict[str, Any] = {"env": _environment(), "capture_output": True, "text": True, "check": True}
    read = path.with_suffix(".read.svg")
    read.write_text(subprocess.run(reader, timeout=limit(SECONDS), **options).stdout)
    command = ["inkscape", "--export-plain-svg", f"--export-filename={out}", str(read)]
    subprocess.run(command, timeout=limit(SECONDS), **options)
    return out.read_text()


def fake_command(folder: Path, code: str) -> Path:
    """Let the extension in ``folder`` call the Python ``code`` instead of warpvec; return the file with the code."""
    script = folder / "stand_in.py"
    script.write_text(code)
    (folder / "command.json").write_text(json.dumps({"command": [sys.executable, str(script)]}))
    return script


def png_link(pixels: NDArray[np.uint8]) -> str:
    """Return a data: link with ``pixels`` as PNG."""
    buffer = BytesIO()
    Image.fromarray(pixels).save(buffer, "PNG")
    return "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode()


def document(content: str, head: str = 'width="120mm" height="90mm" viewBox="-10 -5 120 90"') -> str:
    """Return an SVG with ``content``; the default one has millimetres as its units, and an origin elsewhere."""
    names = 'xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink"'
    return f"<svg {names} {head}>{content}</svg>"


def without_images(text: str) -> str:
    """Return the SVG without its images."""
    return re.sub(r"<image\b[^>]*/>|<image\b.*?</image>", "", text, flags=re.DOTALL)
