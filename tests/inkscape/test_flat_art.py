"""Drawings of flat art, as Inkscape reads them."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path

import flat_counts
import pytest
from commands import invoke
from inkscape_runs import why_no_scripts
from logo import logo
from PIL import Image

SVG = "http://www.w3.org/2000/svg"

pytestmark = pytest.mark.skipif("Inkscape" in why_no_scripts(), reason=why_no_scripts())


def _inkscape(*arguments: str) -> str:
    done = subprocess.run(["inkscape", *arguments], capture_output=True, text=True, timeout=120, check=True)
    return done.stdout


def _segment_counts(svg: str) -> list[int]:
    """Return the number of segments of each path, counted by a parser that is not ours."""
    data = re.findall(r'<path\b[^>]*?\sd="([^"]*)"', svg, re.DOTALL)
    return [
        flat_counts.count(f'<svg width="9" height="9" xmlns="{SVG}"><path d="{each}"/></svg>').segments for each in data
    ]


def test_inkscape_reads_the_paths_layers_and_nodes_that_we_write(tmp_path: Path) -> None:
    source, out, rewritten = (tmp_path / name for name in ("logo.png", "logo.svg", "rewritten.svg"))
    Image.fromarray(logo()).convert("RGBA").save(source)
    report = json.loads(invoke("run", source, out, "--mode", "flat", "--plain-paths", "--json").stdout)
    # Inkscape writes the data of what it moves from its own nodes.
    moves = "select-all:no-layers;transform-translate:8,8"
    _inkscape(str(out), f"--actions={moves};export-filename:{rewritten};export-do")
    text = rewritten.read_text()
    ours, found = (_segment_counts(each) for each in (out.read_text(), text))
    assert len(found) == report["curves"] > 3
    assert found == ours and sum(found) > 20
    layers = re.findall(r'<g id="([^"]+)" inkscape:groupmode="layer"', out.read_text())
    assert text.count('inkscape:groupmode="layer"') == len(layers) > 2
    listed = [line.partition(",")[0] for line in _inkscape("--query-all", str(out)).splitlines()]
    assert [name for name in listed if name in layers] == layers
