#!/bin/sh
# ImageMagick 6.9.11 writes TGA files upside down for every other program.
#
# Versions: ImageMagick 6.9.11-60 Q16 of Debian 12 (package imagemagick), Pillow 12.0.0 from PyPI as the other reader.
# Needs convert, and Python 3.10 or later with venv.
#
# The rows are stored from the top, while bit 5 of the image descriptor (0: the first row is the lowest one) says that
# they are stored from the bottom. ImageMagick reads its own file back right, as it overlooks the bit in the same way.
# With "-orient top-left" the bit is set, and all programs agree.
#
# Output seen:
#   plain: descriptor 0x00, Pillow sees blue on top, ImageMagick red
#   -orient top-left: descriptor 0x20, Pillow sees red on top, ImageMagick red
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" -q install pillow==12.0.0
cd "$folder"
cat > look.py <<'PY'
import subprocess

from PIL import Image

CONVERT = "/usr/bin/convert"
image = Image.new("RGB", (4, 4), "blue")
image.paste("red", (0, 0, 4, 2))
image.save("in.png")
NAMES = {(255, 0, 0): "red", (0, 0, 255): "blue"}
found = []
for options in ([], ["-orient", "top-left"]):
    subprocess.run([CONVERT, "in.png", *options, "tga:out.tga"], check=True)
    subprocess.run([CONVERT, "tga:out.tga", "back.png"], check=True)
    descriptor = open("out.tga", "rb").read()[17]
    tops = [NAMES[Image.open(name).convert("RGB").getpixel((1, 0))] for name in ("out.tga", "back.png")]
    found.append((descriptor & 0x20, *tops))
    print(f"{' '.join(options) or 'plain'}: descriptor {descriptor:#04x}, Pillow sees {tops[0]} on top, ImageMagick {tops[1]}")
assert found == [(0, "blue", "red"), (0x20, "red", "red")], "the behaviour has changed"
PY
/usr/bin/convert --version | head -n 1
venv/bin/python look.py
