#!/bin/sh
# svglib ignores the opacity of stops, does not turn a gradient with its shape, and loses strokes with a gradient.
#
# Versions: svglib 2.3.2, reportlab 5.1.0, PyMuPDF 2.0 (which shows the PDF), Python 3.11. Needs Python 3.10 or later.
#
# Output seen: pixels at the left, in the middle and at the right
#   red to clear: (243, 0, 12) (127, 0, 127) (12, 0, 242), where the last is nearly white
#   turned by 90 degrees: (179, 0, 76) (127, 0, 127) (76, 0, 178), where all three are equal
#   a level stroke: (255, 255, 255) (255, 255, 255) (255, 255, 255), where it goes from red to blue
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" -q install svglib==2.3.2 reportlab==5.1.0 pymupdf==2.0
cd "$folder"
venv/bin/python - <<'PY'
import pymupdf
from reportlab.graphics import renderPDF
from svglib.svglib import svg2rlg


def pixels(body, last="", places=(10, 100, 190)):
    ramp = (
        '<defs><linearGradient id="a" gradientUnits="userSpaceOnUse" x1="0" y1="0" x2="200" y2="0">'
        f'<stop offset="0" stop-color="#f00"/><stop offset="1" stop-color="#00f"{last}/></linearGradient></defs>'
    )
    with open("a.svg", "w") as file:
        file.write(f'<svg xmlns="http://www.w3.org/2000/svg" width="200" height="200">{ramp}{body}</svg>')
    renderPDF.drawToFile(svg2rlg("a.svg"), "a.pdf")
    page = pymupdf.open("a.pdf")[0]
    image = page.get_pixmap(matrix=pymupdf.Matrix(200 / page.rect.width, 200 / page.rect.height))
    return [image.pixel(x, 100) for x in places]


clear = pixels('<rect width="200" height="200" fill="url(#a)"/>', ' stop-opacity="0"')
turn = 'transform="rotate(90 100 100)"'
turned = pixels(f'<rect x="50" y="50" width="100" height="100" fill="url(#a)" {turn}/>', places=(60, 100, 140))
stroke = pixels('<path d="M0 100h200" stroke-width="60" fill="none" stroke="url(#a)"/>')
print("red to clear:", *clear)
print("turned by 90 degrees:", *turned)
print("a level stroke:", *stroke)
assert clear[2][0] < 60, "the opacity of stops is drawn now"
assert turned[0][0] - turned[2][0] > 60, "gradients turn now"
assert stroke == [(255, 255, 255)] * 3, "strokes have gradients now"
PY
