/* What has been taken out of a drawing since its last fit: the shapes of deleted paths are filled in by the next one. */

import { emptyDrawing } from "app/picture.js";
import { pathDataOf } from "viewer/basics.js";

const SHAPES = "path, circle, ellipse, rect:not(#background)";

/** Returns whether an SVG text of warpvec has anything but a background. */
export function hasShapes(text) {
  return pathsOf(text).length > 0;
}

/** Returns the paths and forms of an SVG text in order, as {d, turn, paint, rule, box}.
 *
 * The box is that of the text's user units, and the turn that of a form about its centre. */
function pathsOf(text) {
  const parsed = new DOMParser().parseFromString(text, "image/svg+xml");
  const box = boxOf(text);
  return [...parsed.querySelectorAll(SHAPES)].map((element) => {
    const paint = ["fill", "fill-opacity", "stroke"].map((name) => element.getAttribute(name) ?? "").join(" ");
    const turn = element.getAttribute("transform") ?? "";
    return { d: pathDataOf(element) ?? "", turn, paint, rule: element.getAttribute("fill-rule"), box };
  });
}

/** Returns the viewBox of an SVG text of warpvec. */
export function boxOf(text) {
  return text.match(/viewBox="([^"]*)"/)?.[1] ?? "";
}

/** Returns the paths of `before` that `after` has lost.
 *
 * A path of which only the form or the paint has changed is not lost. Each path that is new in `after` stands for one
 * that is gone, if possible one of the same paint. */
export function lostPaths(before, after) {
  const now = pathsOf(after);
  const present = new Set(now.map(({ d }) => d));
  const old = pathsOf(before);
  const known = new Set(old.map(({ d }) => d));
  const gone = old.filter(({ d }) => !present.has(d));
  for (const { paint } of now.filter(({ d }) => !known.has(d))) {
    const same = gone.findIndex((path) => path.paint === paint);
    gone.splice(Math.max(same, 0), 1);
  }
  return gone;
}

/** Returns those of `paths` that the drawing `text` does not have: undone deletions are none. */
export function stillLost(paths, text) {
  const present = new Set(pathsOf(text).map(({ d }) => d));
  return paths.filter(({ d }) => !present.has(d));
}

/** Returns an SVG text of `paths` for a picture of that size; null without any. */
export function shapesText(paths, size) {
  if (!paths.length) return null;
  const lines = paths.map(({ d, turn, rule, box }) => {
    const [x, y, width, height] = box.split(/[\s,]+/).map(Number);
    const place = `scale(${size.width / width} ${size.height / height}) translate(${-x} ${-y}) ${turn.replace(/[^-\w.() ]/g, "")}`.trim();
    return `<path${rule ? ` fill-rule="${rule}"` : ""} transform="${place}" d="${d.replace(/[&<"]/g, "")}"/>`;
  });
  return emptyDrawing(size).replace("/>", `>${lines.join("")}</svg>`);
}
