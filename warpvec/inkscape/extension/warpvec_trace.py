"""Trace the selected images: warpvec draws each, and the drawing becomes a layer just above its image."""

from __future__ import annotations

import argparse
import os
from itertools import groupby
from typing import Any

import inkex
from warpvec_command import fit
from warpvec_effect import WarpvecEffect, read_drawing, unused_id
from warpvec_images import SVG, box_of, chosen, image_file, name_of
from warpvec_placement import Box, Size, matrix_text, place_pixels
from warpvec_refusal import Refusal

USUAL_DETAIL = 0.1
"""Detail that warpvec has by itself."""

_MODE, _LABEL = (f"{{http://www.inkscape.org/namespaces/inkscape}}{name}" for name in ("groupmode", "label"))

_KEPT = ("transform", "clip-path", "mask", "filter", "opacity", "class", "style")
"""Attributes of an image that its drawing has as well."""

_PLAIN = (
    "fill-opacity:1;fill-rule:nonzero;stroke:none;stroke-opacity:1;stroke-linecap:butt;stroke-linejoin:miter;"
    "stroke-miterlimit:4;stroke-dasharray:none;marker:none;paint-order:normal;shape-rendering:auto"
)
"""Style that keeps from the shapes of a drawing what groups around the image state: an image ignores it. Shapes of a
drawing leave out what is usual, such as flat ends of strokes."""

_DRAWN = {SVG + name for name in ("g", "path", "circle", "ellipse", "rect", "line", "polyline", "polygon")}
"""Elements of a drawing that paint something."""


class Trace(WarpvecEffect):
    """The extension "Trace image"."""

    def add_arguments(self, pars: argparse.ArgumentParser) -> None:
        """Declare the options of the dialog."""
        pars.add_argument("--tab")
        pars.add_argument("--mode", default="auto")
        pars.add_argument("--limit", default="usual")
        pars.add_argument("--detail", type=float, default=USUAL_DETAIL)
        for name in ("paths", "kilobytes", "colors", "gradients"):
            pars.add_argument("--" + name, type=int, default=0)
        for name in ("opaque", "cutout"):
            pars.add_argument("--" + name, type=inkex.Boolean, default=False)

    def work(self, folder: str) -> None:
        """Trace each selected image."""
        images = chosen(self.svg, set(self.options.ids), {SVG + "image"})
        if not images:
            raise Refusal("Select an image to trace, then try again.")
        arguments = fit_arguments(self.options)
        for number, image in enumerate(images, 1):
            count = f" ({number} of {len(images)})" if len(images) > 1 else ""
            source, out = image_file(image, self.link_folders(), folder), os.path.join(folder, "drawing.svg")
            title = f"Tracing {name_of(image)}{count}"
            report = fit("run", source, out, *arguments, "--trim", "--no-metadata", "--json", title=title)
            self._insert(image, read_drawing(out), report)

    def _insert(self, image: Any, drawing: Any, report: dict[str, Any]) -> None:
        pixels = Size(*(float(number) for number in drawing.get("viewBox").split()[2:]))
        name = unused_id(self.svg, f"trace-of-{image.get('id')}")
        layer = placed_layer(image, drawing, pixels, name)
        quality = "" if report["psnr"] is None else f", {report['psnr']:.1f} dB"
        layer.set(_LABEL, f"Trace of {name_of(image)}: {report['curves']} paths{quality}")
        for definition in drawing.findall(f"{SVG}defs/*"):
            self.svg.defs.append(definition)
        image.addnext(layer)


def fit_arguments(options: argparse.Namespace) -> list[str]:
    """Return the arguments of ``warpvec run`` that the dialog's ``options`` ask for."""
    arguments = ["--mode", options.mode]
    if options.limit == "paths":
        arguments += ["--curves", str(options.paths)]
    if options.limit == "bytes":
        arguments += ["--max-bytes", str(1000 * options.kilobytes)]
    if options.detail != USUAL_DETAIL:
        arguments += ["--detail", str(options.detail)]
    if options.colors:
        arguments += ["--colors", str(options.colors)]
    if options.gradients:
        arguments += ["--gradients", str(options.gradients / 100.0)]
    return arguments + [f"--{name}" for name in ("opaque", "cutout") if getattr(options, name)]


def placed_layer(image: Any, drawing: Any, pixels: Size, name: str) -> Any:
    """Return a layer with the ``drawing`` of ``image``, to be put above the image.

    The ids in the layer, and of the definitions that stay in ``drawing``, begin with ``name``.
    """
    _rename(drawing, name)
    layer = inkex.Group(id=name)
    layer.set(_MODE, "layer")
    for attribute in _KEPT:
        if image.get(attribute):
            layer.set(attribute, image.get(attribute))
    layer.set("style", ";".join(filter(None, (image.get("style"), _PLAIN))))
    box = box_of(image, pixels)
    matrix, is_cut = place_pixels(box, pixels, image.get("preserveAspectRatio"))
    frame = _cut_off(layer, drawing, box, name) if is_cut else layer
    for child in _groups_of(drawing):
        child.set("transform", matrix_text(matrix))
        frame.append(child)
    return layer


def _groups_of(drawing: Any) -> list[Any]:
    """Return what is drawn, with shapes that are in no group in one of their own: a short file has no layers.

    A shape alone, such as the canvas, stays as it is if nothing turns it.
    """
    found: list[Any] = []
    for is_group, run in groupby(
        [child for child in drawing if child.tag in _DRAWN], key=lambda child: child.tag == SVG + "g"
    ):
        children = list(run)
        if is_group or (len(children) == 1 and not children[0].get("transform")):
            found += children
        else:
            group = inkex.Group()
            group.extend(children)
            found.append(group)
    return found


def _cut_off(layer: Any, drawing: Any, box: Box, name: str) -> Any:
    """Return a new group in ``layer`` that shows what is in ``box``; ``drawing`` gets the definition of its edges.

    The layer may have a clipping path of its own.
    """
    edges = inkex.ClipPath(inkex.Rectangle(**{key: f"{value:.12g}" for key, value in box._asdict().items()}))
    edges.set("id", f"{name}-box")
    drawing.insert(0, inkex.Defs(edges))
    frame = inkex.Group()
    frame.set("clip-path", f"url(#{name}-box)")
    layer.append(frame)
    return frame


def _rename(drawing: Any, name: str) -> None:
    """Put ``name`` before each id of ``drawing`` and each reference to one."""
    for element in drawing.iter(SVG + "*"):
        if element.get("id"):
            element.set("id", f"{name}-{element.get('id')}")
        for role in ("fill", "stroke"):
            paint = element.get(role, "")
            if paint.startswith("url(#"):
                element.set(role, f"url(#{name}-{paint[5:]}")


if __name__ == "__main__":
    Trace().run()
