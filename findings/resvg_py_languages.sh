#!/bin/sh
# resvg_py draws no element with systemLanguage unless it is told the reader's languages.
#
# Version: resvg_py 0.5.0 from PyPI. Needs Python 3.10 or later with venv.
#
# The command line program resvg reads English by default. The Python package has no default: it skips every element
# that states languages, whichever they are, in a <switch> and outside of one, so that a <switch> draws its last child.
# With languages=["en"] it draws "en", "en-GB" and "de, en" as browsers in English do.
#
# Output seen:
#   by default: en (0, 0, 0), outside (255, 255, 255)
#   languages=["en"]: en (255, 0, 0), outside (255, 0, 0)
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" -q install resvg_py==0.5.0 pillow
cat > "$folder/draw.py" <<'PY'
import io

import resvg_py
from PIL import Image

HEAD = '<svg xmlns="http://www.w3.org/2000/svg" width="8" height="8">'
RED, BLACK = '<rect systemLanguage="en" width="8" height="8" fill="red"/>', '<rect width="8" height="8"/>'


def middle(content, **options):
    data = resvg_py.svg_to_bytes(svg_string=f"{HEAD}{content}</svg>", background="#fff", **options)
    return Image.open(io.BytesIO(bytes(data))).convert("RGB").getpixel((4, 4))


found = {}
for name, options in {"by default": {}, 'languages=["en"]': {"languages": ["en"]}}.items():
    found[name] = middle(f"<switch>{RED}{BLACK}</switch>", **options), middle(RED, **options)
    print(f"{name}: en {found[name][0]}, outside {found[name][1]}")
red, black, white = (255, 0, 0), (0, 0, 0), (255, 255, 255)
assert list(found.values()) == [(black, white), (red, red)], "the behaviour has changed"
PY
"$folder/venv/bin/python" "$folder/draw.py"
