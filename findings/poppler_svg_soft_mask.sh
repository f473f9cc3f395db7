#!/bin/sh
# poppler's "pdftocairo -svg" places a soft mask without the matrix of the page.
#
# Versions: pdftocairo 22.12.0 of Debian 12 (package poppler-utils), CairoSVG 2.9.0 with cairo 1.16 as the writer of the
# PDF. Needs pdftocairo, Python 3.10 or later with venv, and libcairo2.
#
# A gradient with stop-opacity becomes a soft mask in a PDF. If the units of the drawing are points, the SVG that
# pdftocairo makes is right. If they are CSS pixels (a matrix of 0.75 before the mask), the mask in the SVG is 4/3 times
# too large and too far from the corner, while "pdftocairo -png" of the same file is right.
#
# Output seen:
#   in points: mask at 15..135 of 15..135
#   in pixels: mask at 20..180 of 15..135
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" -q install cairosvg==2.9.0
cd "$folder"
cat > make.py <<'PY'
import re
import subprocess

import cairosvg

STOPS = '<stop offset="0" stop-color="red"/><stop offset="1" stop-color="blue" stop-opacity=".1"/>'


def mask_of(name, size, box, x, y, width, height):
    svg = (
        f'<svg xmlns="http://www.w3.org/2000/svg" {size} viewBox="{box}"><linearGradient id="g" x1="{x}" y1="0" '
        f'x2="{x + width}" y2="0" gradientUnits="userSpaceOnUse">{STOPS}</linearGradient>'
        f'<rect x="{x}" y="{y}" width="{width}" height="{height}" fill="url(#g)"/></svg>'
    )
    cairosvg.svg2pdf(bytestring=svg.encode(), write_to=f"{name}.pdf")
    subprocess.run(["pdftocairo", "-svg", f"{name}.pdf", f"{name}.svg"], check=True)
    text = open(f"{name}.svg").read()
    image = int(re.search(r'<image id="image\d+" width="(\d+)"', text)[1])
    scale, _, _, _, left, _ = map(float, re.search(r'href="#image\d+" transform="matrix\(([^)]*)\)', text)[1].split(","))
    return round(left), round(left + scale * image)


points = mask_of("points", 'width="150pt" height="75pt"', "0 0 150 75", 15, 15, 120, 45)
pixels = mask_of("pixels", 'width="200" height="100"', "0 0 200 100", 20, 20, 160, 60)
print(f"in points: mask at {points[0]}..{points[1]} of 15..135")
print(f"in pixels: mask at {pixels[0]}..{pixels[1]} of 15..135")
assert points == (15, 135), "the SVG in points has changed"
assert pixels == (20, 180), "the SVG in pixels has changed"
PY
pdftocairo -v 2>&1 | head -n 1
venv/bin/python make.py
