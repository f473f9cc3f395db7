/* Finds a shape of one drawing in another drawing of the same picture: the shape that covers the same place in a similar
 * colour, or the pieces into which it has been cut. */

import { channelsOf } from "viewer/colors.js";
import { isGradient, paintOf } from "viewer/gradients.js";
import { boxesMeet, unionOfBoxes } from "viewer/paths.js";
import { paints, reachOf } from "viewer/raster.js";

// Points of a square grid over two shapes, along its side, at which they are compared.
const GRID = 20;
// Shapes are the same if they share so much of what they cover together.
const SAME_SHARE = 0.5;
// One lies in the other with so much of itself.
const INSIDE_SHARE = 0.85;
// Largest difference of a channel, of 255, between colours of one shape in two drawings, and of its pieces.
const NEAR_COLOR = 48;
const SAME_COLOR = 24;

/** Returns the largest difference of a channel between the colours of two items, from 0 to 255. */
export function colorGap(a, b) {
  const [from, to] = [meanColor(paintOf(a)), meanColor(paintOf(b))];
  return Math.max(...from.map((level, i) => Math.abs(level - to[i])));
}

function meanColor(paint) {
  if (!isGradient(paint)) return channelsOf(paint ?? "#000000");
  const stops = paint.stops.map(({ color }) => channelsOf(color));
  return [0, 1, 2].map((c) => stops.reduce((sum, stop) => sum + stop[c], 0) / stops.length);
}

/** Returns the areas of two items and of what they share, as shares of the box around both. */
export function sharedArea(a, b) {
  const [left, top, right, bottom] = unionOfBoxes([reachOf(a), reachOf(b)]);
  const counts = { a: 0, b: 0, both: 0 };
  for (let row = 0; row < GRID; row++) {
    for (let column = 0; column < GRID; column++) {
      const x = left + ((column + 0.5) / GRID) * (right - left);
      const y = top + ((row + 0.5) / GRID) * (bottom - top);
      const [inA, inB] = [paints(a, x, y), paints(b, x, y)];
      counts.a += Number(inA);
      counts.b += Number(inB);
      counts.both += Number(inA && inB);
    }
  }
  return counts;
}

/** Returns how much two items cover in common, from 0 to 1, of what they cover together. */
export function overlapOf(a, b) {
  const { a: own, b: other, both } = sharedArea(a, b);
  return both / Math.max(own + other - both, 1);
}

function isInside(inner, outer) {
  const { a, both } = sharedArea(inner, outer);
  return both >= INSIDE_SHARE * Math.max(a, 1);
}

/** Returns those of `items` that are `item` in another drawing: itself, its pieces, or the shape that has taken it up.
 *
 * @param {any} item
 * @param {any[]} items
 * @param {{withPieces?: boolean}} how */
export function counterparts(item, items, { withPieces = true } = {}) {
  const near = items.filter((other) => boxesMeet(reachOf(item), reachOf(other)) && colorGap(item, other) <= NEAR_COLOR);
  const scored = near.map((other) => ({ other, overlap: overlapOf(item, other) })).sort((a, b) => b.overlap - a.overlap);
  const [best] = scored;
  const found = best?.overlap >= SAME_SHARE ? [best.other] : [];
  const alike = near.filter((other) => !found.includes(other) && colorGap(item, other) <= SAME_COLOR);
  const pieces = withPieces ? alike.filter((other) => isInside(other, item)) : [];
  if (found.length || pieces.length) return [...found, ...pieces];
  const areaOf = ({ shape: { box } }) => (box[2] - box[0]) * (box[3] - box[1]);
  const around = alike.filter((other) => isInside(item, other)).sort((a, b) => areaOf(a) - areaOf(b));
  return withPieces ? around.slice(0, 1) : [];
}

/** Tells whether other items of the same colour lie in `item`, so that they cannot be told from its pieces. */
export function holdsOthers(item, items) {
  const alike = items.filter((other) => other !== item && boxesMeet(reachOf(item), reachOf(other)) && colorGap(item, other) <= SAME_COLOR);
  return alike.some((other) => isInside(other, item));
}
