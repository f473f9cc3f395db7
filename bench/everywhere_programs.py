"""Programs that draw SVGs, each in a version of its own. A new version is one line to change.

The code of a program draws the file ``svg`` of ``w`` x ``h`` pixels as ``out``, a PNG or a PDF.
"""

# ruff: noqa: E501
# The programs' own code stands in few long lines.

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from base64 import b64decode
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

_SECONDS = 120
"""Longest time for a drawing."""


@dataclass(frozen=True)
class Program:
    """A program that draws SVGs.

    Attributes:
        kind: "command" of the system, "python", "node", or "page": JavaScript in Chromium.
        requirement: what pip or npm installs, with its version, words with spaces between.
        code: for "command" its words, with ``{svg}`` in braces; for "page" an expression of a promise of base64.
        purpose: the value of ``--for`` that suits the program best.
        suffix: of the file that it draws.
        times: how many times the size its picture has, which is reduced by means: its edges are not all smooth.
        margin: most pixels of the drawing by which its page is longer and wider, half on each side.
    """

    kind: str
    requirement: str
    code: str
    purpose: str = "web"
    suffix: str = ".svg"
    times: int = 1
    margin: float = 0.0


_CANVAS = "const c = document.createElement('canvas'); c.width = w; c.height = h; const base64 = () => c.toDataURL('image/png').split(',')[1];"
_ELEMENT = "const e = new DOMParser().parseFromString(text, 'image/svg+xml').documentElement;"
_GIMP = '(let* ((i (car (file-svg-load RUN-NONINTERACTIVE "{svg}" "{svg}" 96.0 {w} {h} 0)))) (gimp-image-flatten i) (file-png-save RUN-NONINTERACTIVE i (car (gimp-image-get-active-drawable i)) "{out}" "{out}" 0 9 0 0 0 0 0))'

_STUDIO = """import com.android.ide.common.vectordrawable.VdPreview;
import java.nio.file.*;
public class Studio { public static void main(String[] a) throws Exception {
    String text = new String(Files.readAllBytes(Paths.get(a[0])));
    VdPreview.TargetSize size = VdPreview.TargetSize.createFromMaxDimension(Integer.parseInt(a[2]));
    javax.imageio.ImageIO.write(VdPreview.getPreviewFromVectorXml(size, text, new StringBuilder()), "png", new java.io.File(a[1])); } }
"""

PROGRAMS = {
    "rsvg-convert": Program("command", "", "rsvg-convert -w {w} -h {h} -b white {svg} -o {out}"),
    "Inkscape": Program("command", "", "inkscape {svg} -w {w} -h {h} -b white --export-type=png -o {out}"),
    "Chromium": Program(
        "page", "",
        f"new Promise(done => {{ {_CANVAS} const i = new Image(); i.onload = () => {{ const x = c.getContext('2d'); x.drawImage(i, 0, 0, w, h); done(base64()); }}; i.src = 'data:image/svg+xml;base64,' + btoa(unescape(encodeURIComponent(text))); }})",
    ),
    "CairoSVG": Program(
        "python", "cairosvg==2.9.1",
        "import cairosvg; cairosvg.svg2png(url=svg, write_to=out, output_width=w, output_height=h, background_color='white')",
    ),
    "CairoSVG's PDF": Program(
        "python", "cairosvg==2.9.1 pymupdf==2.0", "import cairosvg; cairosvg.svg2pdf(url=svg, write_to=out)"
    ),
    "skia-python": Program(
        "python", "skia-python==144.0.post1",
        "import skia; b = open(svg, 'rb').read(); t = skia.Surface(w, h); c = t.getCanvas(); c.clear(skia.ColorWHITE)\n"
        "d = skia.SVGDOM.MakeFromStream(skia.MemoryStream(b)); z = d.containerSize(); "
        "c.scale(w / z.width(), h / z.height()); d.render(c); t.makeImageSnapshot().save(out, skia.kPNG)",
    ),
    "PySide6": Program(
        "python", "PySide6-Essentials==6.12.0",
        "import os; os.environ['QT_QPA_PLATFORM'] = 'offscreen'\n"
        "from PySide6.QtGui import QGuiApplication, QImage, QPainter; from PySide6.QtSvg import QSvgRenderer\n"
        "a = QGuiApplication([]); i = QImage(w, h, QImage.Format_ARGB32); i.fill('white'); p = QPainter(i); "
        "p.setRenderHint(QPainter.Antialiasing); QSvgRenderer(svg).render(p); p.end(); i.save(out)",
    ),
    "thorvg-python": Program(
        "python", "thorvg-python==1.1.3 pillow",
        "import thorvg_python as tvg; e = tvg.Engine(); c = tvg.SwCanvas(e); c.set_target(w, h)\n"
        "p = tvg.Picture(e); p.load_data(open(svg, 'rb').read(), 'svg', None, True); p.set_size(w, h); c.add(p); c.draw(True); c.sync(); c.get_pillow().save(out)",
    ),
    "svglib": Program(
        "python", "svglib==2.3.2 reportlab==5.1.0 pymupdf==2.0",
        "from svglib.svglib import svg2rlg; from reportlab.graphics import renderPDF; renderPDF.drawToFile(svg2rlg(svg), out)",
        purpose="plain",
    ),
    "PyMuPDF": Program(
        "python", "pymupdf==2.0",
        "import pymupdf; d = pymupdf.open(stream=open(svg, 'rb').read(), filetype='svg'); p = d[0]; m = pymupdf.Matrix(w / p.rect.width, h / p.rect.height); p.get_pixmap(matrix=m).save(out)",
        purpose="plain",
    ),
    "LibreOffice": Program(
        "command", "",
        'soffice -env:UserInstallation=file://{folder}/profile --headless --convert-to png:draw_png_Export:{{"PixelWidth":{{"type":"long","value":"{page_w}"}},"PixelHeight":{{"type":"long","value":"{page_h}"}}}} --outdir {folder} {svg}',
        purpose="plain", times=4, margin=1.0,
    ),
    "LibreOffice's PDF": Program(
        "command", "pymupdf==2.0",
        "soffice -env:UserInstallation=file://{folder}/profile --headless --convert-to pdf:draw_pdf_Export --outdir {folder} {svg}",
        purpose="plain", times=2, margin=1.0,
    ),
    "sharp": Program(
        "node", "sharp@0.35.5",
        "require('sharp')(svg, {density: 72 * scale}).resize(w, h).flatten({background: 'white'}).png().toFile(out)",
    ),
    "canvg": Program(
        "node", "canvg@4.0.3 @napi-rs/canvas@1.1.1 jsdom@29.1.1",
        "const {Canvg, presets} = require('canvg'); const canvas = require('@napi-rs/canvas'); const {JSDOM} = require('jsdom');\n"
        "const preset = presets.node({DOMParser: new JSDOM().window.DOMParser, canvas, fetch}); const c = preset.createCanvas(w, h); const x = c.getContext('2d');\n"
        "const v = Canvg.fromString(x, text, preset); v.resize(w, h, 'xMidYMid meet'); v.render().then(() => fs.writeFileSync(out, c.toBuffer('image/png')))",
    ),
    "svg-to-pdfkit": Program(
        "node", "svg-to-pdfkit@0.1.8 pdfkit@0.20.2",
        "const P = require('pdfkit'); const d = new P({size: [w / scale, h / scale], margin: 0}); d.pipe(fs.createWriteStream(out)); require('svg-to-pdfkit')(d, text, 0, 0, {assumePt: true}); d.end()",
    ),
    "svg2pdf.js": Program(
        "page", "svg2pdf.js@2.8.1 jspdf@4.2.1",
        f"(async () => {{ {_ELEMENT} document.body.appendChild(e); const d = new jspdf.jsPDF({{unit: 'pt', format: [w, h], orientation: w > h ? 'l' : 'p', compress: true}}); await svg2pdf.svg2pdf(e, d, {{x: 0, y: 0, width: w, height: h}}); e.remove(); return d.output('datauristring').split(',')[1]; }})()",
        purpose="plain",
    ),
    "pygame-ce": Program(
        "python", "pygame-ce==2.5.8",
        "import pygame; s = pygame.image.load_sized_svg(svg, (w, h)); t = pygame.Surface((w, h)); t.fill('white'); "
        "t.blit(s, (0, 0)); pygame.image.save(t, out)",
        purpose="plain",
    ),
    "WeasyPrint": Program(
        "python", "weasyprint==70.0 pymupdf==2.0",
        "import weasyprint\n"
        "html = f'<style>@page{{size:{w}px {h}px;margin:0}}body{{margin:0}}img{{display:block;width:{w}px;height:{h}px}}</style><img src=\"file://{svg}\">'\n"
        "weasyprint.HTML(string=html).write_pdf(out)",
        purpose="plain",
    ),
    "typst": Program(
        "python", "typst==0.15.2 pymupdf==2.0",
        "import typst, shutil, tempfile, os; d = tempfile.mkdtemp(); shutil.copy(svg, d + '/a.svg')\n"
        "open(d + '/a.typ', 'w').write(f'#set page(width: {w}pt, height: {h}pt, margin: 0pt)\\n#image(\"a.svg\", width: {w}pt)')\n"
        "open(out, 'wb').write(typst.compile(d + '/a.typ'))",
    ),
    "paper": Program(
        "page", "paper@0.12.20",
        f"(async () => {{ {_CANVAS} c.setAttribute('hidpi', 'off'); c.setAttribute('data-paper-hidpi', 'off'); paper.setup(c); paper.project.importSVG(text); paper.view.matrix = new paper.Matrix(scale, 0, 0, scale, 0, 0); paper.view.update(); return base64(); }})()",
        purpose="plain",
    ),
    "fabric": Program(
        "page", "fabric@7.4.0",
        f"(async () => {{ {_CANVAS} const f = new fabric.StaticCanvas(c, {{enableRetinaScaling: false, width: w, height: h, renderOnAddRemove: false}}); const r = await fabric.loadSVGFromString(text); f.add(...r.objects.filter(Boolean)); f.setZoom(scale); f.renderAll(); return base64(); }})()",
    ),
    "two.js": Program(
        "page", "two.js@0.8.24",
        f"(async () => {{ {_ELEMENT} document.body.appendChild(e); const t = new Two({{type: Two.Types.canvas, width: w, height: h, ratio: 1}}); const g = t.interpret(e); e.remove(); g.scale = scale; t.update(); return t.renderer.domElement.toDataURL('image/png').split(',')[1]; }})()",
        purpose="plain",
    ),
    "Android Studio": Program(
        "node", "vd-tool@4.0.2",
        f"fs.writeFileSync(folder + '/Studio.java', {json.dumps(_STUDIO)}); require('child_process').execFileSync('java', ['-cp', modules + '/vd-tool/lib/*', folder + '/Studio.java', svg, out, Math.max(w, h)])",
        purpose="android", suffix=".xml",
    ),
    "GIMP": Program("command", "", "gimp -i -d -f -b " + _GIMP.replace(" ", "\0") + " -b (gimp-quit\0000)"),
}  # fmt: skip

_SCRIPTS = {
    "svg2pdf.js": ("jspdf/dist/jspdf.umd.min.js", "svg2pdf.js/dist/svg2pdf.umd.js"),
    "paper": ("paper/dist/paper-full.js",),
    "fabric": ("fabric/dist/index.js",),
    "two.js": ("two.js/build/two.js",),
}
"""Program -> files in ``node_modules`` that its page loads."""


MOST_USED = (
    "rsvg-convert", "Inkscape", "Chromium", "CairoSVG", "PySide6", "skia-python", "PyMuPDF", "LibreOffice", "sharp", "pygame-ce",
)  # fmt: skip
"""Programs that stand for most others: web pages, desktops, office, PDF, servers and games."""

_PDF = "pymupdf==2.0"
"""What draws the PDFs of programs that make these."""


def is_there(name: str, environment: Path) -> bool:
    """Return whether a program is installed in the system, or in the folder ``environment``."""
    program = PROGRAMS[name]
    command = {"command": program.code.split()[0], "page": "chromium"}.get(program.kind)
    is_found = command is None or shutil.which(command) is not None
    return is_found and has_packages(program.kind, program.requirement, environment)


def has_packages(kind: str, requirement: str, environment: Path) -> bool:
    """Return whether the folder ``environment`` has the packages of a program of this ``kind``."""
    if kind in ("node", "page"):
        packages = [word.rpartition("@")[0] for word in requirement.split()]
        return shutil.which("node") is not None and all(
            (environment / "node_modules" / each).is_dir() for each in packages
        )
    code = "import sys; from importlib.metadata import version; [version(name) for name in sys.argv[1:]]"
    words, python = [word.partition("==")[0] for word in requirement.split()], environment / "bin" / "python"
    return python.exists() and subprocess.run([python, "-c", code, *words], capture_output=True).returncode == 0


def installed(environment: Path, names: list[str]) -> None:
    """Install what the programs need into the folder ``environment``: a virtual environment and ``node_modules``."""
    if not (environment / "bin" / "python").exists():
        subprocess.run([sys.executable, "-m", "venv", str(environment)], check=True)
    install = {"pip": [environment / "bin" / "pip", "install", "-q"], "npm": ["npm", "install", "--no-audit"]}
    for tool, kinds in {"pip": ("python", "command"), "npm": ("node", "page")}.items():
        wanted = {word for name in names if PROGRAMS[name].kind in kinds for word in PROGRAMS[name].requirement.split()}
        wanted |= {_PDF} if tool == "pip" else set()
        if wanted:
            subprocess.run([*install[tool], *sorted(wanted)], check=True, cwd=environment)


def picture_of(
    name: str, svg: Path, size: tuple[int, int], scale: float, environment: Path
) -> NDArray[np.uint8] | None:
    """Return what a program draws [h, w, 3] of the file ``svg`` in ``size``, ``scale`` times its own; None if it fails."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / (svg.stem + ".png")
        values = {"svg": str(svg), "out": str(out), "w": size[0], "h": size[1], "scale": scale, "folder": folder}
        program = PROGRAMS[name]
        page = [round(program.times * (side + scale * program.margin)) for side in size]
        values |= {"page_w": page[0], "page_h": page[1]}
        try:
            _draw(name, values, environment)
            if (printed := out.with_suffix(".pdf")).exists():
                printed.replace(out)
            if out.read_bytes().startswith(b"%PDF"):
                _draw_pdf(values, environment)
            with Image.open(out) as image:
                image = image.convert("RGBA")
                white = Image.new("RGBA", image.size, "white")
                drawn = Image.alpha_composite(white, image).convert("RGB")
            if program.margin:
                drawn = _without_margin(drawn, round(program.times * scale * program.margin) // 2)
            return np.asarray(drawn.resize(size, Image.Resampling.BOX if program.times > 1 else None))
        except (subprocess.SubprocessError, OSError):
            return None


def _without_margin(image: Image.Image, margin: int) -> Image.Image:
    """Return ``image`` without a white ``margin`` in pixels, which drawings that reach beyond their canvas have not."""
    ring = np.ones(image.size[::-1], bool)
    ring[margin:-margin, margin:-margin] = False
    is_white = (np.asarray(image)[ring] >= 250).all()
    return image.crop((margin, margin, image.width - margin, image.height - margin)) if is_white else image


def _run(words: list[str], **options: object) -> bytes:
    return subprocess.run(words, check=True, capture_output=True, timeout=_SECONDS, **options).stdout  # type: ignore[call-overload, no-any-return]


def _draw(name: str, values: dict[str, object], environment: Path) -> None:
    program = PROGRAMS[name]
    if program.kind == "command":
        _run([word.replace("\0", " ").format(**values) for word in program.code.split()])
    elif program.kind == "python":
        head = "".join(f"{key} = {value!r}\n" for key, value in values.items())
        _run([str(environment / "bin" / "python"), "-c", head + program.code])
    elif program.kind == "node":
        modules = str(environment / "node_modules")
        _run(
            ["node", "-e", _constants({**values, "modules": modules}) + "const fs = require('fs');" + program.code],
            env={**os.environ, "NODE_PATH": modules},
        )
    else:
        _draw_page(name, values, environment)


def _constants(values: dict[str, object]) -> str:
    text = Path(str(values["svg"])).read_text()
    return "".join(f"const {key} = {json.dumps(value)};\n" for key, value in {**values, "text": text}.items())


def _draw_page(name: str, values: dict[str, object], environment: Path) -> None:
    scripts = "".join(
        f'<script src="file://{environment}/node_modules/{each}"></script>' for each in _SCRIPTS.get(name, ())
    )
    code = f"{_constants(values)}({PROGRAMS[name].code}).then(found => {{ document.body.innerHTML = '<pre>FOUND:' + found + '</pre>'; }}, error => {{ document.body.innerHTML = '<pre>ERROR:' + error + '</pre>'; }})"
    page = Path(str(values["folder"])) / "page.html"
    page.write_text(
        f'<!DOCTYPE html><meta charset="utf-8"><body>{scripts}<script>{code.replace("</", "<" + chr(92) + "/")}</script></body>'
    )
    words = [
        "chromium",
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        "--allow-file-access-from-files",
        "--virtual-time-budget=20000",
        "--dump-dom",
        f"--user-data-dir={values['folder']}/chromium",
        f"file://{page}",
    ]
    found = re.search(r"FOUND:([A-Za-z0-9+/=]+)", (dom := _run(words).decode()))
    if found is None:
        raise OSError(re.sub(r"(?s).*ERROR:", "", dom)[:300])
    Path(str(values["out"])).write_bytes(b64decode(found[1]))


def _draw_pdf(values: dict[str, object], environment: Path) -> None:
    """Draw a PDF by MuPDF as a PNG of the size of its page, in its place."""
    code = "import sys, pymupdf; out, w, h = sys.argv[1], *map(float, sys.argv[2:]); p = pymupdf.open(stream=open(out, 'rb').read(), filetype='pdf')[0]; r = p.rect; p.get_pixmap(matrix=pymupdf.Matrix(w / r.width, h / r.height)).save(out)"
    _run([str(environment / "bin" / "python"), "-c", code, *(str(values[key]) for key in ("out", "page_w", "page_h"))])
