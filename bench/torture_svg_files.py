"""SVGs to damage, and SVGs that ask for much in few bytes or point at other files."""

from __future__ import annotations

import base64
import gzip
import io
import zlib
from collections.abc import Callable
from functools import cache
from random import Random

from PIL import Image

NS = 'xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" width="32" height="24"'

_CONTENTS = [
    '<rect id="background" width="32" height="24" fill="#abc"/><g id="layer-1-generation-0">'
    '<path fill="#12f" d="M4 5c1 .5 3-1 4 1-1 2-3 2-4-1z"/><path fill="#345678" fill-opacity=".5" '
    'd="M9 9c3-1 5 3 5 5-2 3-5-1-5-5z"/></g><g id="layer-2-generation-3"><path fill="#fff" d="M1 1c5 0 5 5 5 5z"/></g>',
    '<style>.a,rect.b{fill:#f0f;stroke:red} #c{opacity:50%}</style><g transform="matrix(1 .2 0 1 3 4) rotate(30)">'
    '<rect class="a" x="5%" y="1mm" width="9" height="8" rx="2"/><circle id="c" cx="9" cy="9" r="5"/></g>'
    '<ellipse rx="5" ry="20%"/><polygon points="1,2 9,8 3 9"/><polyline points="1 2 3,4"/><line x2="9"/>',
    '<defs><symbol id="s" viewBox="0 0 9 9"><path d="M1 1A4 5 20 0 1 8 8Q1 9 2 3T4 4S9 1 3 3z"/></symbol></defs>'
    '<use href="#s" x="3" width="9" height="9"/><svg viewBox="0 0 9 9" preserveAspectRatio="xMinYMax slice">'
    '<use xlink:href="#s" transform="scale(2)"/></svg><switch><g><path d="M0 0h9v9H0zm2 2v5h5V2z"/></g></switch>',
    '<linearGradient id="g"><stop offset="20%" stop-color="red"/><stop offset="1" stop-color="#00f8"/></linearGradient>'
    '<radialGradient id="h" href="#g"/><pattern id="p" width="4" height="4" patternUnits="userSpaceOnUse"><rect '
    'width="2" height="2"/></pattern><rect width="9" height="9" fill="url(#h)"/><path fill="url(#p) rgb(9,9,9)" '
    'd="M9 9h9v9z" stroke="hsl(9,9%,9%)" stroke-width="2" stroke-dasharray="1 2"/>',
    '<mask id="m"><rect width="9" height="9" fill="#fff"/></mask><clipPath id="c"><circle r="9"/></clipPath>'
    '<filter id="f"><feGaussianBlur stdDeviation="1"/></filter><g mask="url(#m)" opacity=".5"><path '
    'd="M1 1l9 0 0 9z" clip-path="url(#c)"/><path filter="url(#f)" d="M1 1L9 1 0 9z" style="mix-blend-mode:multiply"/>'
    '</g><text x="3" y="9">a&amp;b</text><image width="4" height="4" href="data:image/png;base64,iVBORw0KGgo="/>',
]


_SHAPE = '<rect width="32" height="24" {}/>'

PLANTED = "p.png"
"""Name of the file beside the drawing that no reader may open; `torture_svgs` watches it."""

_PNG = "data:image/png;base64,iVBORw0KGgo="


@cache
def seeds() -> list[bytes]:
    """Return valid files that together use most features that a reader may meet."""
    texts = [_file(content).decode() for content in _CONTENTS]
    return [*(text.encode() for text in texts), gzip.compress(texts[0].encode(), mtime=0)]


def bomb(chance: Random) -> tuple[str, bytes]:
    """Return a name and a file that asks for much time or memory, or breaks a rule on purpose."""
    make = chance.choice(_BOMBS)
    made = make(chance)
    return make.__name__.strip("_").replace("_", " "), made if isinstance(made, bytes) else _file(made)


def link(chance: Random) -> bytes:
    """Return a file that points at the file `PLANTED` in one of many ways."""
    inner = gzip.compress(_file(f'<image href="{PLANTED}" width="9" height="9"/>'), mtime=0)
    nested = "data:image/svg+xml;base64," + base64.b64encode(chance.choice([inner, gzip.decompress(inner)])).decode()
    prefixes = ["", "#", "#/../", "#../", " data:/../", "data:/../", "data:", "file:", "file://", "./", "\t#"]
    path = chance.choice(prefixes) + PLANTED
    target = chance.choice([path, path, path.upper(), path + "#a", nested])
    content = chance.choice(_LINKS).replace("TARGET", target)
    before = chance.choice([
        "", "", "", f'<?xml-stylesheet href="{target}" type="text/css"?>', f'<!DOCTYPE svg SYSTEM "{target}">',
        f'<!DOCTYPE svg [<!ENTITY % p SYSTEM "{target}"> %p;]>', f'<!DOCTYPE svg [<!ENTITY p SYSTEM "{target}">]>',
    ])  # fmt: skip
    return (before + _file(content, head="").decode()).encode()


_LINKS = [
    '<image href="TARGET" width="32" height="24"/>', '<image xlink:href="TARGET" width="32" height="24"/>',
    f'<image href="{_PNG}" xlink:href="TARGET" width="32" height="24"/>', '<use href="TARGET"/>',
    '<filter id="f"><feImage href="TARGET"/></filter><rect width="9" height="9" filter="url(#f)"/>',
    '<filter id="f"><feImage xlink:href="TARGET"/></filter><rect width="9" height="9" filter="url(#f)"/>',
    '<rect width="9" height="9" fill="url(TARGET)"/>', '<rect width="9" height="9" mask="url(TARGET)"/>',
    '<style>@import url(TARGET);rect{fill:url("TARGET")}</style><rect width="9" height="9"/>',
    '<style>@font-face{font-family:a;src:url(TARGET)}</style><text y="9" font-family="a">x</text>',
    '<g xml:base="file:///"><image href="TARGET" width="9" height="9"/></g>',
    '<linearGradient id="g" href="TARGET"/><rect width="9" height="9" fill="url(#g)"/>',
    '<pattern id="p" width="9" height="9"><image href="TARGET" width="9" height="9"/></pattern>'
    '<rect width="9" height="9" fill="url(#p)"/>',
    '<s:image xmlns:s="http://www.w3.org/2000/svg" href="TARGET" width="9" height="9"/>',
    '<text y="9"><tspan><image href="TARGET" width="9" height="9"/></tspan></text>',
    '<foreignObject width="9" height="9"><image href="TARGET"/></foreignObject><script href="TARGET"/>',
]  # fmt: skip


def _file(content: str, attributes: str = 'viewBox="0 0 32 24"', head: str = '<?xml version="1.0"?>\n') -> bytes:
    return f"{head}<svg {NS} {attributes}>{content}</svg>".encode()


def _uses(chance: Random) -> str:
    """Uses of uses: the tenth power of what is written."""
    depth, width = chance.choice([2, 4, 6, 9, 50]), chance.choice([2, 5, 10])
    parts = ['<g id="a0"><path d="M0 0h9v9z"/></g>']
    parts += [f'<g id="a{k}">' + f'<use href="#a{k - 1}"/>' * width + "</g>" for k in range(1, depth)]
    if chance.random() < 0.3:  # and round again
        back = chance.choice("bc")
        parts.append(f'<g id="b"><use href="#c"/></g><g id="c"><use href="#{back}"/></g>')
    return f"<defs>{''.join(parts)}</defs>" * chance.choice([0, 1]) + "".join(parts)


def _patterns(chance: Random) -> str:
    side, depth = chance.choice(["1e-6", ".001", "1", "1e9", "0", "-1"]), chance.choice([1, 2, 4, 8, 40])
    units = chance.choice(["userSpaceOnUse", "objectBoundingBox"])
    parts = []
    for k in range(depth):
        inner = _SHAPE.format(f'fill="url(#p{(k + 1) % depth})"')
        parts.append(f'<pattern id="p{k}" width="{side}" height="{side}" patternUnits="{units}">{inner}</pattern>')
    return "".join(parts) + _SHAPE.format('fill="url(#p0)"')


def _filters(chance: Random) -> str:
    big = chance.choice(["1", "99", "1e5", "1e9", "1e38", "-1", "nan"])
    ones = "1 " * chance.choice([1, 9, 10**4])
    primitive = chance.choice([
        f'<feGaussianBlur stdDeviation="{big}"/>', f'<feMorphology operator="dilate" radius="{big}"/>',
        f'<feTurbulence baseFrequency="{big}" numOctaves="{big}"/>', f'<feOffset dx="{big}" dy="{big}"/><feTile/>',
        f'<feConvolveMatrix order="{big}" kernelMatrix="{ones}"/>',
        f'<feFlood x="-{big}" width="{big}" height="{big}"/>',
        f'<feDisplacementMap scale="{big}" in2="SourceGraphic"/>',
        f'<feSpecularLighting surfaceScale="{big}"><fePointLight x="{big}"/></feSpecularLighting>',
        f'<feComponentTransfer><feFuncR type="table" tableValues="{ones}"/></feComponentTransfer>',
    ])  # fmt: skip
    region = chance.choice(["", f'x="-{big}" y="-{big}" width="{big}" height="{big}" filterUnits="userSpaceOnUse"'])
    shapes = _SHAPE.format('filter="url(#f)"') * chance.choice([1, 100])
    return f'<filter id="f" {region}>{primitive * chance.choice([1, 1, 20, 1000])}</filter>{shapes}'


def _dashes(chance: Random) -> str:
    dash, length = chance.choice(["1e-9", ".0001", "0", "1e38", "1 -1", "nan"]), chance.choice(["9", "1e6", "1e9"])
    width, join = chance.choice(["1", "1e38", "1e-38", "0"]), chance.choice(["round", "miter", "bevel"])
    return (
        f'<path d="M0 0H{length}A{length} {length} 0 1 0 9 9" fill="none" stroke="red" stroke-dasharray="{dash}" '
        f'stroke-dashoffset="{length}" stroke-width="{width}" stroke-linejoin="{join}" stroke-linecap="round"/>'
    )


def _style_sheets(chance: Random) -> str:
    count = chance.choice([10, 300, 3000])
    rule = chance.choice([
        "g g g g rect{fill:red}", "*{fill:red!important}", ".a,.b,.c{stroke:url(#p)}", "rect:not(:not(.a)){opacity:.5}",
        "rect + rect ~ rect > a{fill:#123}", '[d*="9"]{fill:red}', "@media all{rect{fill:red}}", "}{", "/*",
        "@import 'x';", "rect{fill:" + "rgb(" * 50 + "}", "a" * 1000 + "{}", "rect{" + "fill:red;" * 100 + "}", "\\",
        "rect{fill:var(--a)}",
    ])  # fmt: skip
    nested = chance.choice([0, 20])
    shapes = '<rect class="a b c" width="9" height="9"/>' * chance.choice([1, 100, 1000])
    return f"<style>{rule * count}</style>" + "<g>" * nested + shapes + "</g>" * nested


def _gzips(chance: Random) -> bytes:
    """Gzip of much text: of spaces, of elements, of gzip, or cut short."""
    size = chance.choice([10**4, 10**5, 10**5, 10**7, 2**28 + 1])
    unit = chance.choice([" ", "<g/>", '<path d="M0 0h9v9z"/>', "<!-- -->", "a"])
    packer = zlib.compressobj(9, zlib.DEFLATED, 31)
    unit = " " if size > 10**5 else unit
    block = (unit * (10**5 // len(unit))).encode()
    parts = [packer.compress(_file("")[:-6])]
    parts += [packer.compress(block) for _ in range(size // len(block))]
    data = b"".join([*parts, packer.compress(b"</svg>"), packer.flush()])
    return chance.choice([data, data, data[:-9], gzip.compress(data, mtime=0), data + b"\x1f\x8b", data * 2])


def _entities(chance: Random) -> bytes:
    depth = chance.choice([1, 5, 20])
    parts = [f'<!ENTITY a{k} "{f"&a{k - 1};" * 10 if k else "x"}">' for k in range(depth)]
    return f"<!DOCTYPE svg [{''.join(parts)}]>".encode() + _file(f"<desc>&a{depth - 1};</desc>", head="")


def _deep(chance: Random) -> str:
    depth = chance.choice([90, 98, 99, 101, 1000, 10**5])
    name = chance.choice(["g", "svg", "a", "switch", "defs", "mask", "x", "text", "style", "title"])
    return f"<{name}>" * depth + '<rect width="9" height="9"/>' + f"</{name}>" * depth


def _many(chance: Random) -> str:
    count = chance.choice([10**2, 10**3, 10**4])
    unit = chance.choice([
        "<g/>", '<rect width="9" height="9"/>', '<path d="M0 0h9v9z" fill="#123"/>', '<path d="M0 0C"/>', "<a><b/></a>",
        '<g id="layer-1-generation-0"/>', '<g id="layer-1-generation-999999999"><path d="M0 0h9v9z"/></g>', "&#97;",
    ])  # fmt: skip
    return unit * count


def _long_path(chance: Random) -> str:
    count = chance.choice([10**3, 10**4, 30_000])
    unit = chance.choice([
        "l1 1", "c1 2 3 4 5 6", "a9 9 0 1 1 1 1", "a9 9 0 11.5.5", "m1 1z", "z", "1", "-", ".", "1e", "1e9 ", "t1 1",
        "h1v1", "s1 2 3 4", "M0 0h9v9z", "+", ",", "\n", "1e-40 ", "1" * 100 + " ",
    ])  # fmt: skip
    marker = '<marker id="m" markerWidth="9" markerHeight="9"><rect width="9" height="9"/></marker>'
    rule = chance.choice(["", 'fill-rule="evenodd"', 'stroke="red"', 'marker-mid="url(#m)"', 'transform="rotate(9)"'])
    return f'{marker}<path {rule} d="M0 0{unit * count}"/>'


def _numbers(chance: Random) -> bytes:
    numbers = ["0", "-0", "1e38", "1e-38", "1e39", "1e308", "1e400", "-1e38", "nan", "inf", "16777217", "1e9", "", "5%"]
    a, b, c = (chance.choice(numbers) for _ in range(3))
    transform = chance.choice([
        "", f"scale({a},{b})", f"matrix({a} {b} {c} 1 1 1)", f"rotate({a})", "skewX(90)", f"skewX({a})",
        f"translate({a} {b})", f"scale({a})" * 200, "matrix(1 2", "foo(1)", f"rotate({a} {b} {c})",
    ])  # fmt: skip
    content = (
        f'<g transform="{transform}"><path d="M{a} {b}C{b} {c} {a} {a} {c} {b}A{a} {b} {c} 1 0 {b} {c}z"/>'
        f'<circle cx="{a}" r="{b}"/><rect rx="{c}" width="{a}" height="{b}"/></g>'
    )
    size = chance.choice([
        "", 'width="32" height="24"', 'width="32" height="24"', f'width="{a}" height="{b}"',
        f'viewBox="{a} {b} {c} {a}"', f'viewBox="0 0 {a} {b}"',
    ])  # fmt: skip
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size}>{content}</svg>'.encode()


def _circles_of_references(chance: Random) -> str:
    a, b = chance.choice([("a", "a"), ("a", "b")])
    kind, name = chance.choice([("mask", "mask"), ("clipPath", "clip-path"), ("pattern", "fill"), ("filter", "filter")])
    parts = []
    for x, y in ((a, b), (b, a)):
        inner = _SHAPE.format(f'{name}="url(#{y})"')
        parts.append(f'<{kind} id="{x}" width="9" height="9">{inner}</{kind}>')
    own = (
        '<linearGradient id="g" href="#h"/><linearGradient id="h" href="#g"/><use id="u" href="#u"/>'
        '<g id="v"><use href="#v"/></g><marker id="m"><path d="M0 0h9" marker-end="url(#m)"/></marker>'
    )
    return "".join(parts) + own + _SHAPE.format(f'{name}="url(#a)" stroke="url(#g)" marker-end="url(#m)"')


def _images(chance: Random) -> str:
    """Images inside of the drawing: of many pixels in few bytes, or drawings that hold themselves again."""
    if chance.random() < 0.5:
        side, stream = chance.choice([100, 1000, 5000]), io.BytesIO()
        Image.new("1", (side, side)).save(stream, "PNG")
        url = "data:image/png;base64," + base64.b64encode(stream.getvalue()).decode()
    else:
        url = "data:image/svg+xml;base64," + base64.b64encode(_file("<rect width='9' height='9'/>")).decode()
        for _ in range(chance.choice([1, 3, 6])):
            inner = _file(f'<image href="{url}" width="32" height="24"/>' * chance.choice([1, 3]))
            url = "data:image/svg+xml;base64," + base64.b64encode(inner).decode()
    return f'<image href="{url}" width="32" height="24"/>' * chance.choice([1, 10])


def _texts(chance: Random) -> str:
    size, length = chance.choice(["9", "1e9", "1e38", "-1"]), chance.choice(["1", "1e9"])
    text = chance.choice(["a", "&#x202e;", "&#x1f600;", "x" * 10**4])
    return f'<text y="9" font-size="{size}" textLength="{length}">{text}<textPath href="#a">b</textPath></text>'


def _encodings(chance: Random) -> bytes:
    text = _file('<path d="M0 0h9v9z"/><desc>\u00e9\u2028</desc>').decode()
    head = '<?xml version="1.0" encoding="{}"?>'
    encoding = chance.choice(["utf-16", "utf-8-sig", "latin-1", "utf-32", "utf-7", "cp037"])
    body = text.partition("?>")[2].replace("\u2028", "") if encoding in ("latin-1", "cp037") else text
    return (head.format(encoding) * chance.choice([0, 1]) + body).encode(encoding, "ignore")


_BOMBS: list[Callable[[Random], str | bytes]] = [
    _uses, _patterns, _filters, _dashes, _style_sheets, _gzips, _entities, _deep, _many, _long_path, _numbers, _numbers,
    _circles_of_references, _images, _texts, _encodings,
]  # fmt: skip
