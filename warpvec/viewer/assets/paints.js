/* Changes of gradients: their ends on the picture, and from one colour to a gradient and back. */

import { scaling, translation } from "viewer/basics.js";
import { distance } from "viewer/brush.js";
import { channelsOf, hexColor } from "viewer/colors.js";
import { endColors, isGradient, transformFill, transformPoint } from "viewer/gradients.js";

/** Returns the ends of a gradient [x, y]: start and end of a linear one, centre and rim of a radial one. */
export function gradientPoints(fill) {
  if (!isGradient(fill)) return [];
  const { kind, numbers: n, matrix } = fill;
  const points = kind === "linear" ? [[n[0], n[1]], [n[2], n[3]]] : [[n[0], n[1]], [n[0] + n[2], n[1]]];
  return matrix ? points.map(([x, y]) => transformPoint(matrix, x, y)) : points;
}

/** Moves an end of a gradient: 0 the start or the centre, 1 the end or the rim. */
export function moveGradientPoint(fill, index, dx, dy) {
  const n = [...fill.numbers];
  const [x, y] = gradientPoints(fill)[index];
  if (fill.kind === "linear") {
    [n[2 * index], n[2 * index + 1]] = [x + dx, y + dy];
    return { ...fill, numbers: n, onCanvas: null };
  }
  if (index === 0) return transformFill(fill, translation(dx, dy));
  const [cx, cy] = gradientPoints(fill)[0];
  const scale = distance([x + dx, y + dy], [cx, cy]) / (distance([x, y], [cx, cy]) || 1);
  return scale > 0 ? transformFill(fill, scaling(scale, scale, cx, cy)) : fill;
}

/** Returns a gradient across `box` from the colour of a fill; it ends lighter, or darker if the colour is light. */
function gradientAcross(color, kind, [left, top, right, bottom]) {
  const channels = channelsOf(color);
  const isLight = channels.reduce((sum, level) => sum + level, 0) > 384;
  const end = hexColor(channels.map((level) => (isLight ? level / 2 : (level + 255) / 2)));
  const stops = [{ offset: 0, color, opacity: 1 }, { offset: 1, color: end, opacity: 1 }];
  const [x, y, r] = [(left + right) / 2, (top + bottom) / 2, Math.max(right - left, bottom - top) / 2];
  const numbers = kind === "linear" ? [left, y, right, y] : [x, y, r, x, y];
  return { kind, numbers, matrix: null, spread: "pad", stops, onCanvas: null };
}

/** Returns a fill as one colour ("flat") or as a "linear" or "radial" gradient with its end colours. */
export function asKind(fill, kind, box) {
  if (fill === null) return fill;
  if (kind === "flat") return endColors(fill)[0];
  if (isGradient(fill) && fill.kind === kind) return fill;
  const made = gradientAcross(endColors(fill)[0], kind, box);
  return isGradient(fill) ? { ...made, stops: fill.stops } : made;
}
