#!/bin/sh
# LibreOffice Draw opens every DXF 10 cm long: it reads neither the units nor the sizes.
#
# Versions: LibreOffice 7.4.7.2 of Debian 12 (package libreoffice-draw), ezdxf 1.4.3 as the writer, in the versions R12,
# R2000 and R2010 of the format. Needs soffice, and Python 3.10 or later with venv.
#
# A drawing of 90 x 60 mm states $INSUNITS 4 (millimetres), $MEASUREMENT 1 and $EXTMIN, $EXTMAX. The longer side of
# these extents becomes 10 cm, whatever the units are: millimetres, inches or metres. Only extents of exactly 100 units
# would give the true size, which would be untrue for any other drawing.
#
# Output seen:
#   R12: 10cm x 6.667cm
#   R2000 mm: 10cm x 6.667cm
#   R2000 inch: 10cm x 6.667cm
#   R2010 mm: 10cm x 6.667cm
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" -q install ezdxf==1.4.3
cd "$folder"
cat > make.py <<'PY'
import io
import re
import subprocess
import zipfile

import ezdxf


def size(version, units):
    document = ezdxf.new(version, units=units)
    space = document.modelspace()
    space.add_lwpolyline([(0, 0), (90, 0), (90, 60), (0, 60)], close=True) if version != "R12" else space.add_polyline2d(
        [(0, 0), (90, 0), (90, 60), (0, 60)], close=True
    )
    space.reset_extents((0, 0, 0), (90, 60, 0))
    document.header["$MEASUREMENT"] = 1
    document.header["$EXTMIN"], document.header["$EXTMAX"] = (0, 0, 0), (90, 60, 0)
    text = io.StringIO()
    document.write(text)
    with open("a.dxf", "w") as file:
        file.write(text.getvalue())
    soffice = ["soffice", "-env:UserInstallation=file://" + FOLDER + "/profile", "--headless"]
    subprocess.run([*soffice, "--convert-to", "odg", "a.dxf"], check=True, capture_output=True)
    content = zipfile.ZipFile("a.odg").read("content.xml").decode()
    return " x ".join(re.search(r'svg:width="([^"]+)" svg:height="([^"]+)"', content).groups())


import os

FOLDER = os.getcwd()
found = {
    "R12": size("R12", 4), "R2000 mm": size("R2000", 4), "R2000 inch": size("R2000", 1), "R2010 mm": size("R2010", 4),
}
for name, each in found.items():
    print(f"{name}: {each}")
assert set(found.values()) == {"10cm x 6.667cm"}, "the size has changed"
PY
soffice --version
venv/bin/python make.py 2>/dev/null
