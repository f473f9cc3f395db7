#!/bin/sh
# CairoSVG draws two of the four round corners of a rectangle beside their place.
#
# Versions: CairoSVG 2.9.1, Python 3.11. Needs Python 3.10 or later with venv, and Cairo.
#
# A quarter of a circle is a cubic whose handles are 0.5523 of the radius long. Of two corners the second handle is as
# long as the first one leaves over, 0.4477 of the radius, so that the corner is flatter, by 2.7 per cent of the radius.
# WeasyPrint 70.0 does the same, as its code tells, and svg2pdf.js 2.8.1 with three corners.
#
# Output seen: the distance of the nearest white from the centre of a rectangle that is a circle of radius 80
#   right above 77.8 right below 80.0 left below 77.8 left above 80.0
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" -q install cairosvg==2.9.1 pillow
"$folder/venv/bin/python" - <<'PY'
import io
import math

import cairosvg
from PIL import Image

SVG = b"""<svg xmlns="http://www.w3.org/2000/svg" width="200" height="200" viewBox="0 0 200 200">
<rect x="20" y="20" width="160" height="160" rx="80"/></svg>"""
image = Image.open(io.BytesIO(cairosvg.svg2png(SVG, background_color="white"))).convert("L")


def nearest_white(columns, rows):
    places = ((x, y) for x in columns for y in rows if image.getpixel((x, y)) > 127)
    return round(min(math.hypot(x - 99.5, y - 99.5) for x, y in places), 1)


low, high = range(100), range(100, 200)
corners = {name: nearest_white(*each) for name, each in {
    "right above": (high, low), "right below": (high, high), "left below": (low, high), "left above": (low, low),
}.items()}
print(*(f"{name} {distance}" for name, distance in corners.items()))
assert list(corners.values()) == [77.8, 80.0, 77.8, 80.0], "corners are drawn otherwise now"
PY
