"""Refine the selected paths: warpvec moves their nodes and colours until they match the image beneath them."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from typing import Any

import inkex
from warpvec_command import fit
from warpvec_effect import WarpvecEffect, read_drawing
from warpvec_images import SVG, box_of, chosen, drawn, image_file, name_of
from warpvec_paths import SHAPES, draft_of, element_matrix, replace_shape
from warpvec_placement import Matrix, Size, compose, invert, place_pixels
from warpvec_refusal import Refusal

_IMAGE = SVG + "image"


class RefineEffect(WarpvecEffect):
    """The extension "Refine selected paths against the image"."""

    def add_arguments(self, pars: argparse.ArgumentParser) -> None:
        """Declare the options of the dialog."""
        pars.add_argument("--iterations", type=int, default=500)
        pars.add_argument("--free", type=inkex.Boolean, default=False)

    def work(self, folder: str) -> None:
        """Refine the selected paths, and tell the user if they stay as they are."""
        selected = [shape for shape in chosen(self.svg, set(self.options.ids), SHAPES) if not _has_stroke(shape)]
        if not selected:
            raise Refusal("Select paths with a fill and without a stroke, then try again.")
        image = self._image_under(selected[0])
        source = image_file(image, self.link_folders(), folder)
        pixels = Size(*fit("inkscape", "size", source, title=None))
        matrix, _ = place_pixels(box_of(image, pixels), pixels, image.get("preserveAspectRatio"))
        to_root = compose(element_matrix(image), matrix)
        shapes = _drawn_above(image, self.svg, selected)
        refined, is_unchanged = self._refined(shapes, image, source, pixels, invert(to_root), folder)
        count = 0 if is_unchanged else self._replace(selected, shapes, refined, to_root)
        if not count:
            inkex.errormsg("The paths stay as they are: warpvec found nothing better.")

    def _image_under(self, path: Any) -> Any:
        """Return the selected image, or the next one beneath ``path``.

        Raises:
            Refusal: there is none, or several are selected.
        """
        images = chosen(self.svg, set(self.options.ids), {_IMAGE})
        if len(images) > 1:
            raise Refusal("Select one image with the paths, not several, then try again.")
        if not images:
            below = drawn(self.svg, {_IMAGE, path.tag})
            images = [element for element in below[: below.index(path)] if element.tag == _IMAGE][-1:]
        if not images:
            raise Refusal("There is no image beneath the selected paths. Select it as well, then try again.")
        return images[0]

    def _refined(
        self, shapes: Sequence[Any], image: Any, source: str, pixels: Size, to_pixels: Matrix, folder: str
    ) -> Any:
        """Return warpvec's drawing of ``shapes``, and whether it is no closer to the image than these."""
        draft, out = os.path.join(folder, "draft.svg"), os.path.join(folder, "refined.svg")
        with open(draft, "wb") as file:
            file.write(draft_of(shapes, self.svg, pixels, to_pixels))
        arguments = ["--iterations", str(self.options.iterations), *(["--free"] if self.options.free else [])]
        title = f"Refining paths against {name_of(image)}"
        arguments += ["--plain-paths", "--json"]  # the outline of a shape is replaced by path data
        report: dict[str, Any] = fit("refine", source, out, "--from", draft, *arguments, title=title)
        # Plain paths are another file than the one given even if nothing better is found. Equal pictures have no PSNR.
        before, after = (float("inf") if report[key] is None else report[key] for key in ("start_psnr", "psnr"))
        return read_drawing(out), after <= before

    def _replace(self, selected: Sequence[Any], shapes: Sequence[Any], refined: Any, to_root: Matrix) -> int:
        """Give the ``selected`` of the ``shapes`` their refined outlines; return for how many there was one."""
        groups = {group.get("id").rpartition("-")[2]: group for group in refined.findall(f"{SVG}g")}
        definitions = {element.get("id"): element for element in refined.findall(f"{SVG}defs/*")}
        count, wanted = 0, set(selected)
        for number, shape in enumerate(shapes):
            paths: list[Any] = list(groups.get(str(number), ())) if shape in wanted else []
            if len(paths) == 1:
                to_shape = compose(invert(element_matrix(shape)), to_root)
                replace_shape(shape, paths[0], definitions, to_shape)
                count += 1
        return count


def _has_stroke(shape: Any) -> bool:
    return shape.specified_style().get("stroke", "none") != "none"


def _drawn_above(image: Any, root: Any, selected: Sequence[Any]) -> list[Any]:
    """Return all shapes that are drawn above ``image``, and the ``selected`` ones, from bottom to top.

    The fit needs them all. Where the others are, the selected ones must not grow to fill a gap.
    """
    everything = drawn(root, {*SHAPES, _IMAGE})
    above = {*everything[everything.index(image) :], *selected}
    return [element for element in everything if element.tag != _IMAGE and element in above]


if __name__ == "__main__":
    RefineEffect().run()
