#!/bin/sh
# resvg widens and narrows a blur by steps: the blur that is seen jumps where the one that is asked for hardly changes.
#
# Version: resvg_py 0.5.0 from PyPI, with numpy 2.4.6, scipy 1.17.1 and pillow 13.0.0. Needs Python 3.11 or later.
#
# From a deviation of two pixels on, a Gaussian blur is drawn as three boxes of whole pixels. So the drawn deviation is
# up to a sixth off the one that the file states, and drawings whose blurs differ by an eighth look the same. Who reads a
# shadow's blur from a picture of resvg finds the drawn one, and cannot tell which one its file states.
#
# Output seen, of a black square, fitted by a Gaussian:
#   stated 3.43: drawn 3.50
#   stated 3.89: drawn 4.55
#   stated 4.38: drawn 4.55
#   stated 5.02: drawn 5.12
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" -q install resvg_py==0.5.0 numpy==2.4.6 scipy==1.17.1 pillow==13.0.0
cat > "$folder/blur.py" <<'PY'
import io

import numpy as np
import resvg_py
from PIL import Image
from scipy.ndimage import gaussian_filter
from scipy.optimize import minimize_scalar

SVG = """<svg xmlns="http://www.w3.org/2000/svg" width="200" height="200"><filter id="f" filterUnits="userSpaceOnUse"
x="0" y="0" width="200" height="200"><feGaussianBlur stdDeviation="{sigma}"/></filter>
<rect x="60" y="60" width="80" height="80" filter="url(#f)"/></svg>"""


def cover(sigma):
    data = resvg_py.svg_to_bytes(svg_string=SVG.format(sigma=sigma), background="#fff")
    return 255.0 - np.asarray(Image.open(io.BytesIO(bytes(data))).convert("L"), float)


sharp = cover(0)
drawn = {}
for sigma in (3.43, 3.89, 4.38, 5.02):
    seen = cover(sigma)
    off = lambda found: ((gaussian_filter(sharp, found) - seen) ** 2).sum()  # noqa: E731
    drawn[sigma] = minimize_scalar(off, bounds=(0.5, 9.0), method="bounded").x
    print(f"stated {sigma:.2f}: drawn {drawn[sigma]:.2f}")
assert abs(drawn[3.89] - drawn[4.38]) < 0.05 and drawn[3.89] > 1.12 * 3.89, "the behaviour has changed"
PY
"$folder/venv/bin/python" "$folder/blur.py"
