"""Write footprints for KiCad: a drawing as silkscreen, in millimetres, of simple polygons about its middle.

Source: KiCad's "Footprint library file format" of version 6 on. White is not printed, and all other colours are.
"""

from __future__ import annotations

from warpvec.writers.writer import Target, Writer, check_package

STEP = 0.0001
"""Distance of coordinates in millimetres: a tenth of KiCad's usual one of a micrometre."""


def _check(path: str, name: str) -> None:
    check_package("shapely", path, name)


def _encode(svg: str, target: Target) -> bytes:
    _check("drawing.kicad_mod", "path")
    import shapely  # not above: it is not needed for other files

    from warpvec.making.parts import read_parts
    from warpvec.making.polygons import regions_by_color, without_holes

    sheet = read_parts(svg, target.per_inch)
    printed = [region for color, region in regions_by_color(sheet, STEP).items() if color != "#ffffff"]
    middle = (sheet.width / 2.0, sheet.height / 2.0)
    name = target.name.replace("\\", "").replace('"', "")
    lines = [
        f'(footprint "{name}" (version 20221018) (generator "warpvec") (layer "F.Cu")',
        "  (attr board_only exclude_from_pos_files exclude_from_bom)",
    ]
    for polygon in without_holes(shapely.union_all(printed, grid_size=STEP), STEP):
        points = polygon.exterior.coords[:-1]
        written = " ".join(f"(xy {_number(x - middle[0])} {_number(y - middle[1])})" for x, y in points)
        lines.append(f'  (fp_poly (pts {written}) (stroke (width 0) (type solid)) (fill solid) (layer "F.SilkS"))')
    return ("\n".join(lines) + "\n)\n").encode()


def _number(value: float) -> str:
    return f"{value:.4f}".rstrip("0").rstrip(".")


WRITER = Writer(".kicad_mod", "application/x-kicad-footprint", _encode, _check, draws_blur=False)
