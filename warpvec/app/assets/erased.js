/* What has been taken out of a drawing: the next fit fills it in. */

import { emptyDrawing } from "app/picture.js";

/** Returns whether an SVG text of warpvec has anything but a background. */
export function hasShapes(text) {
  const parsed = new DOMParser().parseFromString(text, "image/svg+xml");
  return parsed.querySelector("path, circle, ellipse, rect:not(#background)") !== null;
}

/** Returns an SVG text of `paths` for a picture of that size; null without any. */
export function shapesText(paths, size) {
  if (!paths.length) return null;
  const lines = paths.map(({ d, rule, box }) => {
    const [x, y, width, height] = box.split(/[\s,]+/).map(Number);
    const place = `scale(${size.width / width} ${size.height / height}) translate(${-x} ${-y})`;
    return `<path${rule ? ` fill-rule="${rule}"` : ""} transform="${place}" d="${d.replace(/[&<"]/g, "")}"/>`;
  });
  return emptyDrawing(size).replace("/>", `>${lines.join("")}</svg>`);
}
