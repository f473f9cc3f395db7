/* Basic shapes as path data, and transforms as matrices [a, b, c, d, e, f]. */

import { NUMBERS } from "viewer/pen.js";

/** Returns the path data of a path or a basic shape; null for any other element. */
export function pathDataOf(element) {
  const attribute = (name) => parseFloat(element.getAttribute(name)) || 0;
  const points = () => (element.getAttribute("points")?.match(NUMBERS) ?? []).join(" ");
  switch (element.localName) {
    case "path": return element.getAttribute("d") ?? "";
    case "rect": return rectangle(attribute, element);
    case "circle": return ellipseData(attribute("cx"), attribute("cy"), attribute("r"), attribute("r"));
    case "ellipse": return ellipseData(attribute("cx"), attribute("cy"), attribute("rx"), attribute("ry"));
    case "line": return `M${attribute("x1")} ${attribute("y1")}L${attribute("x2")} ${attribute("y2")}`;
    case "polyline": return `M${points()}`;
    case "polygon": return `M${points()}z`;
    default: return null;
  }
}

function rectangle(attribute, element) {
  const [x, y, width, height] = ["x", "y", "width", "height"].map(attribute);
  if (!(width > 0 && height > 0)) return "";
  const stated = ["rx", "ry"].map((name) => (element.hasAttribute(name) ? attribute(name) : null));
  const rx = Math.min(stated[0] ?? stated[1] ?? 0, width / 2);
  const ry = Math.min(stated[1] ?? stated[0] ?? 0, height / 2);
  return rectangleData(x, y, width, height, rx, ry);
}

/** Returns the path data of a rectangle from its left upper corner, with the radii of its corners. */
export function rectangleData(x, y, width, height, rx, ry) {
  if (!(rx > 0 && ry > 0)) return `M${x} ${y}h${width}v${height}h${-width}z`;
  const corner = (dx, dy) => `a${rx} ${ry} 0 0 1 ${dx} ${dy}`;
  return (
    `M${x + rx} ${y}h${width - 2 * rx}${corner(rx, ry)}v${height - 2 * ry}${corner(-rx, ry)}` +
    `h${2 * rx - width}${corner(-rx, -ry)}v${2 * ry - height}${corner(rx, -ry)}z`
  );
}

/** Returns the path data of an ellipse that is not turned. */
export function ellipseData(cx, cy, rx, ry) {
  if (!(rx > 0 && ry > 0)) return "";
  return `M${cx - rx} ${cy}a${rx} ${ry} 0 0 1 ${2 * rx} 0a${rx} ${ry} 0 0 1 ${-2 * rx} 0z`;
}

/** Returns the matrix of a transform attribute; unknown functions are ignored. */
export function parseTransform(text) {
  let matrix = [1, 0, 0, 1, 0, 0];
  for (const [, name, list] of text.matchAll(/(\w+)\s*\(([^)]*)\)/g)) {
    matrix = multiply(matrix, oneTransform(name, (list.match(NUMBERS) ?? []).map(Number)));
  }
  return matrix;
}

function oneTransform(name, n) {
  const radians = ((n[0] ?? 0) * Math.PI) / 180;
  switch (name) {
    case "matrix": return n.length === 6 ? n : [1, 0, 0, 1, 0, 0];
    case "translate": return [1, 0, 0, 1, n[0] ?? 0, n[1] ?? 0];
    case "scale": return [n[0] ?? 1, 0, 0, n[1] ?? n[0] ?? 1, 0, 0];
    case "skewX": return [1, 0, Math.tan(radians), 1, 0, 0];
    case "skewY": return [1, Math.tan(radians), 0, 1, 0, 0];
    case "rotate": return rotation(radians, n[1] ?? 0, n[2] ?? 0);
    default: return [1, 0, 0, 1, 0, 0];
  }
}

export function rotation(radians, x, y) {
  const [cos, sin] = [Math.cos(radians), Math.sin(radians)];
  return [cos, sin, -sin, cos, x - cos * x + sin * y, y - sin * x - cos * y];
}

/** Returns how many times as long a matrix makes lengths: the root of how many times as large it makes areas.
 *
 * @param {number[]} matrix */
export function scaleOf([a, b, c, d]) {
  return Math.sqrt(Math.abs(a * d - b * c));
}

export function translation(x, y) {
  return [1, 0, 0, 1, x, y];
}

/** Returns the scaling by `sx`, `sy` that keeps the point `x`, `y` in place. */
export function scaling(sx, sy, x, y) {
  return [sx, 0, 0, sy, x - sx * x, y - sy * y];
}

/** Returns the matrix that applies `second` and then `first`.
 *
 * @param {number[]} first
 * @param {number[]} second
 * @returns {number[]} */
export function multiply(first, second) {
  const [a, b, c, d, e, f] = first;
  const [g, h, i, j, k, l] = second;
  return [a * g + c * h, b * g + d * h, a * i + c * j, b * i + d * j, a * k + c * l + e, b * k + d * l + f];
}
