#!/bin/sh
# WeasyPrint draws circles, arcs and round corners of SVGs beside their place.
#
# Versions: WeasyPrint 70.0, Python 3.11. Needs Python 3.10 or later with venv, and Pango.
#
# A <circle> becomes four cubics whose handles are 0.5642 of the radius long, the inverse of the root of pi. A quarter of
# a circle needs 0.5523, so the circle bulges between its four points. A half circle of path data (the command "a")
# becomes a single cubic, which is further off. Of the corners of a <rect> with rx, the second handle is as long as the
# first one leaves over, 0.4477 of the radius.
#
# Output seen: the largest distance from the circle, in per cent of its radius
#   circle: 0.63
#   half circles of a path: 1.83
#   corners of a rectangle: 2.74
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" -q install weasyprint==70.0
cd "$folder"
cat > make.py <<'PY'
import base64
import math
import re

import weasyprint

SHAPES = {
    "circle": '<circle cx="100" cy="100" r="80"/>',
    "half circles of a path": '<path d="M20 100a80 80 0 0 1 160 0a80 80 0 0 1-160 0z"/>',
    "corners of a rectangle": '<rect x="20" y="20" width="160" height="160" rx="80"/>',
}
STYLE = "<style>@page { size: 200px; margin: 0 } body { margin: 0 } img { display: block }</style>"


def error(shape):
    svg = f'<svg xmlns="http://www.w3.org/2000/svg" width="200" height="200" viewBox="0 0 200 200">{shape}</svg>'
    image = f'<img src="data:image/svg+xml;base64,{base64.b64encode(svg.encode()).decode()}">'
    page = weasyprint.HTML(string=STYLE + image).write_pdf(uncompressed_pdf=True).decode("latin1")
    rows = [list(map(float, row.split())) for row in re.findall(r"^((?:-?[\d.]+ ){6})c$", page, re.M)]
    start, worst = rows[-1][4:], 0.0
    for row in rows:
        a, b, c, d = start, row[:2], row[2:4], row[4:]
        for step in range(101):
            t = step / 100
            weights = (1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t * t * (1 - t), t**3
            x, y = (sum(w * p[k] for w, p in zip(weights, (a, b, c, d))) for k in (0, 1))
            worst = max(worst, abs(math.hypot(x - 100, y - 100) - 80) / 80)
        start = d
    return f"{100 * worst:.2f}"


found = {name: error(shape) for name, shape in SHAPES.items()}
for name, each in found.items():
    print(f"{name}: {each}")
assert list(found.values()) == ["0.63", "1.83", "2.74"], "the distances have changed"
PY
venv/bin/python make.py
