#!/bin/sh
# MuPDF opens SVGs as documents, but paints what has a gradient black, and cuts round corners of rectangles off.
#
# Versions: PyMuPDF 2.0, Python 3.11. Needs Python 3.10 or later with venv.
#
# A fill of url(#...) is black, and so it is where a fallback colour stands behind the reference. A <rect> whose corners
# have radii of half its sides is a circle; here its corners lie up to a twentieth of the radius inside of it. The
# element <circle> is right.
#
# Output seen:
#   gradient from red to blue: (0, 0, 0) (0, 0, 0) (0, 0, 0)
#   with a fallback of green: (0, 0, 0) (0, 0, 0) (0, 0, 0)
#   nearest white to the centre of a circle of radius 80: 75.7 as a rect, 80.0 as a circle
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" -q install pymupdf==2.0
"$folder/venv/bin/python" - <<'PY'
import math

import pymupdf

RAMP = (
    '<defs><linearGradient id="a" gradientUnits="userSpaceOnUse" x1="0" y1="0" x2="200" y2="0">'
    '<stop offset="0" stop-color="#f00"/><stop offset="1" stop-color="#00f"/></linearGradient></defs>'
)


def drawn(body):
    text = f'<svg xmlns="http://www.w3.org/2000/svg" width="200" height="200" viewBox="0 0 200 200">{body}</svg>'
    return pymupdf.open(stream=text.encode(), filetype="svg")[0].get_pixmap()


def nearest_white(body):
    image = drawn(body)
    places = ((x, y) for x in range(200) for y in range(200) if image.pixel(x, y)[0] > 127)
    return min(math.hypot(x - 99.5, y - 99.5) for x, y in places)


for title, fill in (("gradient from red to blue", "url(#a)"), ("with a fallback of green", "url(#a) #0f0")):
    image = drawn(f'{RAMP}<rect width="200" height="200" fill="{fill}"/>')
    found = [image.pixel(x, 100) for x in (10, 100, 190)]
    print(f"{title}:", *found)
    assert found == [(0, 0, 0)] * 3, "gradients are drawn otherwise now"
rect = nearest_white('<rect x="20" y="20" width="160" height="160" rx="80"/>')
circle = nearest_white('<circle cx="100" cy="100" r="80"/>')
print(f"nearest white to the centre of a circle of radius 80: {rect:.1f} as a rect, {circle:.1f} as a circle")
assert rect < 77.0 and circle > 79.5, "round corners are drawn otherwise now"
PY
