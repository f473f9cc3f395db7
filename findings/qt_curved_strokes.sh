#!/bin/bash
# Qt's SVG renderer draws curved strokes by chords that are as long as the units of the file, whatever the scale.
#
# The same curve is written in units 16 times as large, with a view box for it, and drawn in the same 1024 pixels. Both
# pictures should be equal. With PySide6-Essentials 6.12.0 the coarser units give a stroke of visible corners.
# Seen: rows of which more than a pixel is covered otherwise: none with fine units, 778 of 1024 with coarse ones.
# Needs Python 3 with venv.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q PySide6-Essentials==6.12.0 numpy
QT_QPA_PLATFORM=offscreen "$folder/venv/bin/python" - <<'PYTHON'
import numpy as np
from PySide6.QtCore import QByteArray
from PySide6.QtGui import QGuiApplication, QImage, QPainter
from PySide6.QtSvg import QSvgRenderer

app = QGuiApplication([])
SIDE = 1024


def right_half(units: float) -> np.ndarray:
    """Draw a stroked circle in a view box of so many units; return what the right half of each row covers."""
    r, c, w = 0.4 * units, 0.5 * units, 0.1 * units
    k = 0.5522847498 * r
    d = (
        f"M{c + r} {c}C{c + r} {c + k} {c + k} {c + r} {c} {c + r}C{c - k} {c + r} {c - r} {c + k} {c - r} {c}"
        f"C{c - r} {c - k} {c - k} {c - r} {c} {c - r}C{c + k} {c - r} {c + r} {c - k} {c + r} {c}z"
    )
    text = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{SIDE}" height="{SIDE}" viewBox="0 0 {units} {units}">'
        f'<path fill="none" stroke="#000" stroke-width="{w}" d="{d}"/></svg>'
    )
    image = QImage(SIDE, SIDE, QImage.Format.Format_Grayscale8)
    image.fill("white")
    painter = QPainter(image)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    QSvgRenderer(QByteArray(text.encode())).render(painter)
    painter.end()
    pixels = np.frombuffer(image.constBits(), np.uint8).reshape(SIDE, -1)[:, :SIDE]
    return 1.0 - pixels[:, SIDE // 2 :].astype(float) / 255.0


reference = right_half(SIDE)
rows = {units: int((np.abs(right_half(units) - reference).sum(1) > 1.0).sum()) for units in (SIDE, SIDE // 16)}
print(rows)
assert rows[SIDE] == 0 and rows[SIDE // 16] > 50
PYTHON
