#!/bin/sh
# scour and SVGO write relative path data whose loops do not come back to their start; some cross themselves then.
#
# Versions: scour 0.38.2, SVGO 4.0.0, svgelements 1.9.6, shapely 2.1.2. Needs npm, and Python 3.10 or later with venv.
#
# Both write the curves of a loop as "c". In decimals their steps add up to the start of the loop. Readers add binary
# numbers, in which a tenth is rounded, so the last curve often ends some 1e-14 beside the start. scour keeps the "z",
# which draws a line of that length; where it lies on the wrong side, it crosses the first curve, and shapely calls the
# shape invalid. SVGO leaves the "z" out, so its loops are valid as areas, but open as lines.
#
# Output seen for 300 loops of six curves each, none of which crosses itself:
#   given: 300 end at their start, 300 are valid
#   scour: 101 end at their start, 270 are valid
#   SVGO: 101 end at their start, 300 are valid
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" -q install scour==0.38.2 svgelements==1.9.6 shapely==2.1.2
npm --prefix "$folder" install --silent svgo@4.0.0
cd "$folder"
cat > make.py <<'PY'
import math
import random

rng = random.Random(3)


def loop():
    """Return a loop of six curves, with a corner at each of six points around its middle."""
    x, y, points = rng.uniform(100, 900), rng.uniform(100, 900), []
    for k in range(6):
        radius, angle = rng.uniform(20, 60), (k + rng.uniform(0.1, 0.9)) * math.pi / 3
        points.append((x + radius * math.cos(angle), y + radius * math.sin(angle)))
    text = "M%.2f %.2f" % points[0]
    for start, end in zip(points, points[1:] + points[:1]):
        thirds = [a + share * (b - a) + rng.uniform(-2, 2) for share in (1 / 3, 2 / 3) for a, b in zip(start, end)]
        text += "C%.2f %.2f %.2f %.2f %.2f %.2f" % (*thirds, *end)
    return f'<path d="{text}z"/>'


loops = "".join(loop() for _ in range(300))
with open("given.svg", "w") as out:
    out.write(f'<svg xmlns="http://www.w3.org/2000/svg" width="1000" height="1000" viewBox="0 0 1000 1000">{loops}</svg>')
PY
cat > count.py <<'PY'
import re

from shapely.geometry import Polygon
from svgelements import Close, CubicBezier, Move, Path


def counts(name):
    """Return how many loops of a file there are, end at their start, and are valid as polygons of 24 chords a curve."""
    loops = [Path(loop) for data in re.findall(r' d="([^"]*)"', open(name).read()) for loop in Path(data).as_subpaths()]
    ends, valid = 0, 0
    for loop in loops:
        curves = [each for each in loop if not isinstance(each, (Move, Close))]
        ends += tuple(curves[-1].end) == tuple(loop[0].end)
        points = []
        for each in loop:
            chords = 24 if isinstance(each, CubicBezier) else 1
            points += [] if isinstance(each, Move) else [tuple(each.point(k / chords)) for k in range(chords)]
        valid += Polygon(points).is_valid
    return len(loops), ends, valid


found = [counts(name) for name in ("given.svg", "scour.svg", "svgo.svg")]
for name, (_, ends, valid) in zip(("given", "scour", "SVGO"), found):
    print(f"{name}: {ends} end at their start, {valid} are valid")
assert found == [(300, 300, 300), (300, 101, 270), (300, 101, 300)], "the counts have changed"
PY
venv/bin/python make.py
venv/bin/scour -q -i given.svg -o scour.svg
node_modules/.bin/svgo -q given.svg -o svgo.svg
venv/bin/python count.py
