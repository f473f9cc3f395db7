"""Pages as browsers show them, for `bench/screenshots.py`: charts, tables, forms, maps, diagrams and words."""

# ruff: noqa: E501
# Pages stand in lines of their own length.

from __future__ import annotations

import io
import math
import random
from collections.abc import Callable

import numpy as np

_HEAD = '<!DOCTYPE html><meta charset="utf-8"><style>html{zoom:ZOOM}body{margin:20px;font:14px sans-serif;background:#fff;color:#222}'
"""Begin of a page, with the place of its zoom."""

_TINTS = ("#1f77b4", "#ff7f0e", "#2ca02c", "#d62728", "#9467bd", "#8c564b")


def _page(body: str, style: str = "") -> str:
    return f"{_HEAD}{style}</style>{body}"


def _drawing(body: str) -> str:
    return _page(f'<svg width="800" height="540">{body}</svg>')


def _chart(kind: str, rng: np.random.Generator) -> str:
    import matplotlib

    matplotlib.use("svg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(7.0, 4.5))
    if kind == "lines":
        axes.plot(rng.normal(size=(80, 4)).cumsum(0))
        axes.grid(visible=True)
    elif kind == "bars":
        axes.bar(range(12), rng.uniform(2.0, 9.0, 12))
    elif kind == "points":
        axes.scatter(*rng.normal(size=(2, 150)), c=rng.uniform(size=150), s=25)
    else:
        axes.pie(rng.uniform(1.0, 5.0, 6), labels=list("abcdef"))
    text = io.StringIO()
    figure.savefig(text, format="svg")
    plt.close(figure)
    return _page(text.getvalue()[text.getvalue().index("<svg") :])


def _table(rng: random.Random) -> str:
    rows = "".join(f"<tr>{''.join(f'<td>{rng.randint(10, 9999)}</td>' for _ in range(7))}</tr>" for _ in range(18))
    style = "table{border-collapse:collapse}td{border:1px solid #999;padding:4px 14px;text-align:right}tr:nth-child(even){background:#eef}"
    return _page(f"<h2>Results</h2><table>{rows}</table>", style)


def _form() -> str:
    fields = "".join(
        f'<p><label>{name}<br><input value="{name} of somebody" size=40></label></p>'
        for name in ("Name", "Mail", "City")
    )
    rest = "<p><input type=checkbox checked> I agree <input type=radio checked> yes</p><p><select><option>Blue</option></select> <button>Send it</button> <progress value=.4></progress></p>"
    return _page(f"<h2>Sign up</h2>{fields}{rest}")


def _cards(rng: random.Random) -> str:
    cards = "".join(
        f"<div><b>Card {number}</b><p>This costs {rng.randint(3, 99)} euros.</p><span>buy</span></div>"
        for number in range(8)
    )
    style = "div{display:inline-block;width:170px;height:130px;margin:10px;padding:12px;border-radius:10px;background:linear-gradient(#fff,#e8ecf4);border:1px solid #ccd;box-shadow:0 4px 12px rgba(0,0,0,.25)}span{background:#0a7;color:#fff;padding:4px 12px;border-radius:12px}"
    return _page(cards, style)


def _words() -> str:
    small = "Lorem ipsum dolor sit amet, consectetur adipiscing elit, sed do eiusmod tempor. " * 30
    return _page(
        f"<h1>Big words here</h1><h2>A second line</h2><p>{small}</p>",
        "h1{font:bold 80px serif;color:#b00}p{font:11px serif;columns:3}",
    )


def _code(rng: random.Random) -> str:
    lines = "\n".join(
        f"{number:3d}  def <b>f{number}</b>(x, y):  return x + y  # {'abc ' * rng.randint(1, 6)}"
        for number in range(28)
    )
    return _page(
        f"<pre>{lines}</pre>", "pre{font:13px monospace;background:#272822;color:#f8f8f2;padding:12px}b{color:#a6e22e}"
    )


def _network(rng: random.Random) -> str:
    places = [(rng.uniform(60.0, 740.0), rng.uniform(60.0, 480.0)) for _ in range(40)]
    near = ((a, b) for a in places for b in places if 0.0 < math.dist(a, b) < 130.0)
    lines = "".join(
        f'<line x1="{a[0]:.1f}" y1="{a[1]:.1f}" x2="{b[0]:.1f}" y2="{b[1]:.1f}" stroke="#999"/>' for a, b in near
    )
    dots = "".join(
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{rng.uniform(4.0, 12.0):.1f}" fill="{rng.choice(_TINTS)}" stroke="#fff" stroke-width="1.5"/>'
        for x, y in places
    )
    return _drawing(lines + dots)


def _polygon(x: float, y: float, radius: float, count: int, rng: random.Random) -> str:
    angles = (2.0 * math.pi * corner / count for corner in range(count))
    places = ((radius * rng.uniform(0.7, 1.2), angle) for angle in angles)
    return " ".join(f"{x + r * math.cos(angle):.1f},{y + r * math.sin(angle):.1f}" for r, angle in places)


def _map(rng: random.Random) -> str:
    lands = "".join(
        f'<polygon points="{_polygon(rng.uniform(80, 720), rng.uniform(80, 460), rng.uniform(40, 120), 14, rng)}" fill="{rng.choice(("#f2efe9", "#c8facc", "#add19e"))}" stroke="#777" stroke-width="{rng.choice((1, 0.7, 1.5))}"/>'
        for _ in range(14)
    )
    roads = "".join(
        f'<path d="M{rng.randint(0, 800)} 0L{rng.randint(0, 800)} 260L{rng.randint(0, 800)} 540" fill="none" stroke="{tint}" stroke-width="{width}"/>'
        for tint, width in (("#e892a2", 5), ("#fcd6a4", 4), ("#888", 1))
    )
    return _drawing(f'<rect width="800" height="540" fill="#aad3df"/>{lands}{roads}')


def _diagram() -> str:
    parts = []
    for number in range(9):
        x, y = 60 + 220 * (number % 3), 40 + 150 * (number // 3)
        parts.append(
            f'<rect x="{x}" y="{y}" width="150" height="80" rx="8" fill="#e3f2fd" stroke="#1565c0" stroke-width="1.5"/><text x="{x + 40}" y="{y + 45}">Step {number}</text>'
        )
        parts.append(
            f'<path d="M{x + 150} {y + 40}h64" stroke="#333" stroke-width="1.3"/><path d="M{x + 220} {y + 40}l-8-4v8z"/>'
        )
    return _drawing("".join(parts))


def _seats(rng: random.Random) -> str:
    places = ((30 + 24 * column, 30 + 24 * row) for row in range(20) for column in range(30))
    return _drawing(
        "".join(
            f'<rect x="{x}" y="{y}" width="18" height="18" rx="3" fill="{rng.choice(_TINTS)}" stroke="#555"/>'
            for x, y in places
        )
    )


def _hairlines() -> str:
    lines = "".join(
        f'<path d="M{20 + 12.5 * k} 20v480M20 {20 + 8 * k}h740" stroke="#bbb" stroke-width=".5"/>' for k in range(60)
    )
    rings = "".join(
        f'<circle cx="{60 + 60 * k}" cy="260" r="{6 + 2 * k}" fill="none" stroke="#06c"/>' for k in range(12)
    )
    return _drawing(lines + rings)


def _icons(rng: random.Random) -> str:
    shapes = (
        '<circle cx="12" cy="12" r="10"/><path d="M12 6v6l4 2"/>',
        '<rect x="3" y="3" width="18" height="18" rx="2"/><path d="M9 12l2 2 4-4"/>',
    )
    icons = "".join(
        f'<g transform="translate({60 + 110 * (k % 7)} {50 + 110 * (k // 7)}) scale({rng.choice((1.5, 2, 2.5))})">{rng.choice(shapes)}</g>'
        for k in range(28)
    )
    return _drawing(
        f'<g fill="none" stroke="#24292f" stroke-width="2" stroke-linecap="round" stroke-linejoin="round">{icons}</g>'
    )


PAGES: dict[str, Callable[[], str]] = {
    **{kind: lambda kind=kind: _chart(kind, np.random.default_rng(3)) for kind in ("lines", "bars", "points", "pie")},  # type: ignore[misc]
    "table": lambda: _table(random.Random(4)),
    "form": _form,
    "cards": lambda: _cards(random.Random(4)),
    "words": _words,
    "code": lambda: _code(random.Random(4)),
    "network": lambda: _network(random.Random(4)),
    "map": lambda: _map(random.Random(4)),
    "diagram": _diagram,
    "seats": lambda: _seats(random.Random(4)),
    "hairlines": _hairlines,
    "icons": lambda: _icons(random.Random(4)),
    "icons again": lambda: _icons(random.Random(5)),
}
"""Name -> what makes the text of the page."""
