"""Import our files by programs that take their shapes, and compare these with the drawing.

    python bench/importers.py [--environment FOLDER] [--program NAME]

Each program gets the file that its purpose (`--for`) makes, and says where each shape lies, and in which colour. The
table says what is right: the number of shapes, their place within half a pixel, their colours, the size of the drawing,
and for plotters the pens. "-" is what a program does not read, by its nature.
"""

# ruff: noqa: E501
# The programs' own code stands in few long lines.

from __future__ import annotations

import json
import os
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click
import numpy as np
import torch
from everywhere_files import SIDE, by_color
from harness import markdown_table

from warpvec.geometry.bezier import path_boxes
from warpvec.geometry.loops import make_scene
from warpvec.making.packages import PACKAGES
from warpvec.purposes.loops import loops_of, outline_of
from warpvec.purposes.table import PURPOSES
from warpvec.purposes.texts import text_for
from warpvec.svg.read import read_svg
from warpvec.svg.write import hex_colors
from warpvec.writers.dxf import WRITER as DXF
from warpvec.writers.writer import DEFAULT_TARGET

_SECONDS = 120
_NEAR = 0.5
"""Largest distance of a side of a shape from its place, in pixels."""


@dataclass(frozen=True)
class Importer:
    """A program that imports shapes.

    Attributes:
        kind: "python" or "node".
        requirement: what pip or npm installs.
        code: prints a JSON object of the file ``svg``: ``shapes``, a list of a box and a colour or null each, and where
            the program knows them ``size`` and ``pens``. ``folder`` is a place for files.
        purpose: the value of ``--for``, or "dxf".
        is_scaled: whether it has units of its own, as fonts have, so that only proportions can be compared.
        is_one_shape: whether it has one shape of one colour, the black outline of a font.
        has_loops: whether each loop of a path is a shape, as for machines.
    """

    kind: str
    requirement: str
    code: str
    purpose: str = "plain"
    is_scaled: bool = False
    is_one_shape: bool = False
    has_loops: bool = False


_SVG = (
    "from svgelements import SVG, Shape, Path\n"
    "def facts(file):\n"
    "    s = SVG.parse(file, reify=True)\n"
    "    shapes = [e for e in s.elements() if isinstance(e, Shape) and len(Path(e)) and e.fill.value is not None]\n"
    "    return {'size': [float(s.width), float(s.height)], 'shapes': [[list(Path(e).bbox()), e.fill.hexrgb] for e in shapes]}\n"
)
_VECTOR = (
    "import xml.etree.ElementTree as E\nfrom svgelements import Path\n"
    "a = '{http://schemas.android.com/apk/res/android}'\n"
    "def facts(file):\n"
    "    r = E.parse(file).getroot()\n"
    "    color = lambda c: '#' + (''.join(2 * d for d in c[1:]) if len(c) == 4 else c[-6:]).lower()\n"
    "    return {'size': [float(r.get(a + side)[:-2]) for side in ('width', 'height')], 'shapes': [[list(Path(p.get(a + 'pathData')).bbox()), color(p.get(a + 'fillColor'))] for p in r.iter('path')]}\n"
)
_PRINT = "import json, subprocess, os\nprint(json.dumps(facts({file})))"

IMPORTERS = {
    "three": Importer(
        "node", "three@0.187.0 jsdom@29.1.1",
        "const {JSDOM} = require('jsdom'); const w = new JSDOM().window; global.DOMParser = w.DOMParser;\n"
        "import(modules + '/three/examples/jsm/loaders/SVGLoader.js').then(({SVGLoader}) => { const d = new SVGLoader().parse(text);\n"
        "console.log(JSON.stringify({shapes: d.paths.map(p => { const q = p.subPaths.flatMap(s => s.getPoints(64)); const x = q.map(v => v.x), y = q.map(v => v.y);\n"
        "return [[Math.min(...x), Math.min(...y), Math.max(...x), Math.max(...y)], '#' + p.color.getHexString()]; })})); })",
    ),
    "svg2vectordrawable": Importer(
        "node", "svg2vectordrawable@2.9.1",
        "require('svg2vectordrawable')(text).then(x => { fs.writeFileSync(folder + '/a.xml', x); const p = require('child_process');\n"
        "process.stdout.write(p.execFileSync(python, ['-c', " + repr(_VECTOR + _PRINT.format(file="os.environ['FILE']")) + "], {env: {...process.env, FILE: folder + '/a.xml'}})); })",
    ),
    "vd-tool": Importer(
        "node", "vd-tool@4.0.2",
        "const p = require('child_process'); fs.copyFileSync(svg, folder + '/b.svg');\n"
        "p.spawnSync(modules + '/vd-tool/bin/vd-tool', ['-c', '-in', folder + '/b.svg', '-out', folder]);\n"
        "process.stdout.write(p.execFileSync(python, ['-c', " + repr(_VECTOR + _PRINT.format(file="os.environ['FILE']")) + "], {env: {...process.env, FILE: folder + '/b.xml'}}))",
    ),
    "picosvg": Importer(
        "python", "picosvg==0.23.0 svgelements==1.9.6",
        _SVG + "from picosvg.svg import SVG as P; open(folder + '/a.svg', 'w').write(P.parse(svg).topicosvg().tostring())\n" + _PRINT.format(file="folder + '/a.svg'"),
    ),
    "nanoemoji": Importer(
        "python", "nanoemoji==0.16.0 fonttools==4.68.0",
        "import json, os, shutil, subprocess, sys; shutil.copy(svg, folder + '/emoji_u1f600.svg')\n"
        "env = {**os.environ, 'PATH': os.path.dirname(sys.executable) + ':' + os.environ['PATH']}\n"
        "subprocess.run([os.path.dirname(sys.executable) + '/nanoemoji', '--color_format', 'glyf_colr_1', 'emoji_u1f600.svg'], cwd=folder, check=True, capture_output=True, env=env)\n"
        "from fontTools.ttLib import TTFont; from fontTools.pens.boundsPen import BoundsPen\n"
        "f = TTFont(folder + '/build/Font.ttf'); g = f.getGlyphSet(); c = f['CPAL'].palettes[0]; l = f['COLR'].table.LayerList.Paint; found = []\n"
        "def walk(p, x=0, y=0, s=(1, 1)):\n"
        "    if p.Format in (14,): return walk(p.Paint, x + p.dx, y + p.dy, s)\n"
        "    b = BoundsPen(g); g[p.Glyph].draw(b); k = c[p.Paint.PaletteIndex]; q = b.bounds; return [[q[0] + x, -q[3] - y, q[2] + x, -q[1] - y], '#%02x%02x%02x' % (k.red, k.green, k.blue)]\n"
        "print(json.dumps({'shapes': [walk(p) for p in l]}))",
        is_scaled=True,
    ),
    "FontForge": Importer(
        "python", "",
        "import subprocess; code = '''import fontforge, json, sys\nf = fontforge.font(); g = f.createChar(65); g.importOutlines(sys.argv[1]); b = g.boundingBox()\n"
        "print(json.dumps({\"shapes\": [[[b[0], -b[3], b[2], -b[1]], None]], \"contours\": len(g.foreground)}))'''\n"
        "print(subprocess.run(['fontforge', '-quiet', '-lang=py', '-c', code, svg], capture_output=True, text=True, check=True).stdout.strip().splitlines()[-1])",
        purpose="font", is_scaled=True, is_one_shape=True,
    ),
    "vpype": Importer(
        "python", "vpype==1.15.0",
        "import json, vpype; d = vpype.read_multilayer_svg(svg, 0.05)\n"
        "print(json.dumps({'size': d.page_size, 'pens': [l.property('vp_color').as_hex()[:7] for l in d.layers.values()], 'shapes': [[[float(min(v.real)), float(min(v.imag)), float(max(v.real)), float(max(v.imag))], l.property('vp_color').as_hex()[:7]] for l in d.layers.values() for v in l]}))",
        purpose="pen", has_loops=True,
    ),
    "svgpathtools": Importer(
        "python", "svgpathtools==1.8.0",
        "import json; from svgpathtools import svg2paths; p, a = svg2paths(svg)\n"
        "def box(q): b = q.bbox(); return [b[0], b[2], b[1], b[3]]\n"
        "print(json.dumps({'shapes': [[box(q), '#' + (''.join(2 * d for d in e['fill'][1:]) if len(e['fill']) == 4 else e['fill'][1:])] for q, e in zip(p, a)]}))",
    ),
    "svgelements": Importer("python", "svgelements==1.9.6", _SVG + _PRINT.format(file="svg"), purpose="web"),
    "python-lottie": Importer(
        "python", "lottie==0.7.2 svgelements==1.9.6",
        _SVG + "from lottie.parsers.svg import parse_svg_file; from lottie.exporters.svg import export_svg; export_svg(parse_svg_file(svg), folder + '/a.svg')\n"
        + _PRINT.format(file="folder + '/a.svg'"),
    ),
    "svgpath2mpl": Importer(
        "python", "svgpath2mpl==1.0.0 matplotlib",
        "import json, re; from svgpath2mpl import parse_path; t = open(svg).read()\n"
        "def box(d): b = parse_path(d).get_extents(); return [b.x0, b.y0, b.x1, b.y1]\n"
        "print(json.dumps({'shapes': [[box(d), None] for d in re.findall(r' d=\"([^\"]*)\"', t)]}))",
    ),
    "svgo": Importer(
        "node", "svgo@4.1.0",
        "fs.writeFileSync(folder + '/a.svg', require('svgo').optimize(text).data); const p = require('child_process');\n"
        "process.stdout.write(p.execFileSync(python, ['-c', " + repr(_SVG + _PRINT.format(file="os.environ['FILE']")) + "], {env: {...process.env, FILE: folder + '/a.svg'}}))",
        purpose="web",
    ),
    "scour": Importer(
        "python", "scour==0.38.2 svgelements==1.9.6",
        _SVG + "from scour.scour import scourString; open(folder + '/a.svg', 'w').write(scourString(open(svg).read()))\n" + _PRINT.format(file="folder + '/a.svg'"),
        purpose="web",
    ),
    "ezdxf": Importer(
        "python", "ezdxf==1.4.5",
        "import json, ezdxf; from ezdxf import bbox; from ezdxf.colors import int2rgb\n"
        "d = ezdxf.readfile(svg); k = 96 / 25.4; assert d.units == 4 and not d.audit().errors; lo, hi = d.header['$EXTMIN'], d.header['$EXTMAX']; found = []\n"
        "for e in d.modelspace():\n"
        "    b = bbox.extents([e]); c = d.layers.get(e.dxf.layer).rgb; found.append([[k * b.extmin.x, -k * b.extmax.y, k * b.extmax.x, -k * b.extmin.y], '#%02x%02x%02x' % tuple(c)])\n"
        "print(json.dumps({'shapes': found}))",
        purpose="dxf", has_loops=True,
    ),
}  # fmt: skip


def file_for(importer: Importer, text: str, folder: Path) -> Path:
    """Return the file that an importer gets of the SVG ``text``."""
    if importer.purpose == "dxf":
        assert PACKAGES
        path = folder / "drawing.dxf"
        path.write_bytes(DXF.encode(text, DEFAULT_TARGET))
        return path
    path = folder / "drawing.svg"
    path.write_text(text_for(text, PURPOSES[importer.purpose]).text)
    return path


def imported(name: str, file: Path, folder: Path, environment: Path) -> dict[str, Any]:
    """Return what a program says of a file.

    Raises:
        OSError, subprocess.SubprocessError, ValueError: the program is missing or fails.
    """
    importer = IMPORTERS[name]
    python, modules = environment / "bin" / "python", environment / "node_modules"
    values = {"svg": str(file), "folder": str(folder), "python": str(python), "modules": str(modules)}
    if importer.kind == "node":
        values["text"] = file.read_text()
        head = "const fs = require('fs');" + "".join(
            f"const {key} = {json.dumps(each)};\n" for key, each in values.items()
        )
        words = ["node", "-e", head + importer.code]
    else:
        words = [str(python), "-c", "".join(f"{key} = {each!r}\n" for key, each in values.items()) + importer.code]
    env = {**os.environ, "NODE_PATH": str(modules)}
    done = subprocess.run(words, check=True, capture_output=True, timeout=_SECONDS, env=env)
    found: dict[str, Any] = json.loads(done.stdout.decode().strip().splitlines()[-1])
    return found


def wanted(text: str, has_loops: bool) -> dict[str, Any]:
    """Return where the shapes of a drawing lie, or their loops, their colours, and its pens."""
    scene, shapes = read_svg(text).scene, list[Any]()
    for path, color in enumerate(map(_long, hex_colors(scene.color))):
        one = scene.select(torch.tensor([path]))
        loops = [make_scene([outline_of([loop], (0.0, 0.0, 0.0), 1.0, 0)], None) for loop in loops_of(one)]
        shapes += [[path_boxes(each)[0].tolist(), color] for each in (loops if has_loops else [one])]
    return {"size": [SIDE, SIDE], "shapes": shapes, "pens": list(dict.fromkeys(color for _, color in shapes))}


def _long(color: str) -> str:
    return color if len(color) == 7 else "#" + "".join(2 * digit for digit in color[1:])


def verdict(found: dict[str, Any], want: dict[str, Any], importer: Importer) -> dict[str, str]:
    """Return "right", "wrong" or "-" for each thing that a program imports."""
    shapes = [shape for shape in found["shapes"] if shape[0] != [0, 0, SIDE, SIDE]]
    if importer.is_scaled and len(shapes) > len(want["shapes"]):
        shapes = shapes[1:]
    boxes = np.array([box for box, _ in want["shapes"]])
    if importer.is_one_shape:
        boxes = np.array([[*boxes[:, :2].min(0), *boxes[:, 2:].max(0)]])
    places = np.array([box for box, _ in shapes])
    is_count = len(places) == len(boxes)
    colors, pens = [color for _, color in shapes], found.get("pens")
    if importer.purpose == "dxf" and is_count:
        places, colors = _in_order(places, colors, boxes)
    if importer.is_scaled and is_count:
        scale = float((boxes[:, 2:] - boxes[:, :2]).sum() / (places[:, 2:] - places[:, :2]).sum())
        places = scale * places + (boxes - scale * places).mean(0)[[0, 1, 0, 1]]
    is_place = is_count and bool(np.abs(places - boxes).max() <= _NEAR)
    words = {True: "right", False: "wrong"}
    return {
        "count": words[is_count],
        "place": words[is_place],
        "colours": "-" if None in colors else words[colors == [color for _, color in want["shapes"]]],
        "size": words[bool(np.allclose(found["size"], want["size"], atol=0.1))] if "size" in found else "-",
        "pens": "-" if pens is None else words[pens == want["pens"]],
    }


def _in_order(places: Any, colors: list[str], boxes: Any) -> tuple[Any, list[str]]:
    """Return the shapes of a DXF in the order of ``boxes``: it may have others, and its lower left corner is at 0."""
    places = places - places[:, :2].min(0)[[0, 1, 0, 1]] + boxes[:, :2].min(0)[[0, 1, 0, 1]]
    order = [int(np.abs(places - box).max(1).argmin()) for box in boxes]
    return places[order], [colors[row] for row in order]


@click.command()
@click.option("--environment", type=click.Path(path_type=Path), required=True, help="Folder of the programs.")
@click.option("--program", "names", multiple=True, type=click.Choice(list(IMPORTERS)), help="Only this program.")
def main(environment: Path, names: tuple[str, ...]) -> None:
    """Import a drawing by other programs, and print the table."""
    text = by_color()
    rows = []
    for name in names or IMPORTERS:
        importer = IMPORTERS[name]
        want = wanted(text, importer.has_loops)
        with tempfile.TemporaryDirectory() as folder:
            file = file_for(importer, text, Path(folder))
            try:
                facts = imported(name, file, Path(folder), environment)
                found = list(verdict(facts, want, importer).values())
            except (OSError, ValueError, subprocess.SubprocessError) as error:
                found = ["-"] * 5
                click.echo(f"{name}: {error} {getattr(error, 'stderr', b'')[-600:]!r}", err=True)
        rows.append([name, importer.requirement.split(" ")[0], importer.purpose, *found])
    click.echo(markdown_table(["program", "version", "for", "count", "place", "colours", "size", "pens"], rows))


if __name__ == "__main__":
    main()
