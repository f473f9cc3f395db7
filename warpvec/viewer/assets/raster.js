/* Draws on canvases. Drawing is a generator, so that a long one can be spread over several frames. */

import { scaleOf } from "viewer/basics.js";
import { fillPath, strokePath } from "viewer/ink.js";
import { boxesMeet, grownBox, path2dOf } from "viewer/paths.js";

const PAPER = "#ffffff";
export const PLAIN = { name: "plain", paper: null, colorOf: () => null };
// After so many paths the canvas is made to draw what it has recorded, and the time is checked.
const BATCH = 24;
// Strokes with sharp corners reach farther than half their width; of others, square ends reach farthest.
const END_REACH = Math.SQRT2;
// A blur reaches so many standard deviations: what lies beyond is a third of an 8-bit level of an edge.
const BLUR_REACH = 3;

/** Makes a canvas in main memory: its pixels are read back, and drawing costs the same on every machine. */
export function newCanvas(width, height) {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [width, height];
  return { canvas, context: canvas.getContext("2d", { willReadFrequently: true }) };
}

/** Draws the `items` that overlap `window`, a box in user units, with the context's transform. */
export function paintItems(context, items, palette, window) {
  for (const item of items) if (!window || boxesMeet(reachOf(item), window)) paintItem(context, item, palette);
  context.globalAlpha = 1;
}

/** Does the same in batches; each step draws one. */
export function* painting(context, items, palette, window) {
  let count = 0;
  for (const item of items) {
    if (!boxesMeet(reachOf(item), window)) continue;
    paintItem(context, item, palette);
    if (++count % BATCH) continue;
    context.getImageData(0, 0, 1, 1);
    yield;
  }
  context.globalAlpha = 1;
}

function paintItem(context, item, palette) {
  context.globalAlpha = item.opacity;
  // A filter does not follow the context's transform.
  if (item.softness) context.filter = `blur(${item.softness * scaleOf(matrixOf(context))}px)`;
  const color = palette.colorOf(item);
  if (item.fill) fillPath(context, path2dOf(item.shape), item.rule, color ?? item.fill);
  if (item.stroke) strokePath(context, path2dOf(item.shape), item.stroke, color ?? item.stroke.color);
  if (item.softness) context.filter = "none";
}

function matrixOf(context) {
  const { a, b, c, d, e, f } = context.getTransform();
  return [a, b, c, d, e, f];
}

// A canvas of one pixel, on which paths are asked for a point.
let probe = null;

/** Returns the items that paint the point x, y of user units, the topmost first; thin strokes within `slack` too. */
export function itemsAt(items, x, y, slack) {
  const near = items.filter((item) => boxesMeet(grownBox(reachOf(item), slack), [x, y, x, y]));
  return near.reverse().filter((item) => paints(item, x, y, slack));
}

/** Tells whether an item paints the point x, y of user units; a thin stroke also within `slack`. */
export function paints({ shape, fill, rule, stroke }, x, y, slack = 0) {
  probe ??= newCanvas(1, 1).context;
  const context = probe;
  if (fill && context.isPointInPath(path2dOf(shape), x, y, rule)) return true;
  if (!stroke) return false;
  const { width, cap, join, limit } = stroke;
  Object.assign(context, { lineWidth: Math.max(width, 2 * slack), lineCap: cap, lineJoin: join, miterLimit: limit });
  return context.isPointInStroke(path2dOf(shape), x, y);
}

/** Returns the box of what an item paints. */
export function reachOf({ shape, stroke, softness }) {
  const ofStroke = stroke ? (stroke.width / 2) * (stroke.join === "miter" ? Math.max(stroke.limit, END_REACH) : END_REACH) : 0;
  const reach = ofStroke + (softness ? BLUR_REACH * softness : 0);
  return reach ? grownBox(shape.box, reach) : shape.box;
}

/** Draws white paper and the drawing's background. */
export function paintBackground(context, drawing, palette) {
  const [x, y, width, height] = drawing.box;
  context.fillStyle = palette.paper ?? PAPER;
  context.fillRect(x, y, width, height);
  if (!drawing.background || palette.paper) return;
  context.globalAlpha = drawing.background.opacity;
  context.fillStyle = drawing.background.fill;
  context.fillRect(x, y, width, height);
  context.globalAlpha = 1;
}

/** Runs a generator until it ends or the time `deadline`; returns whether it has ended. */
export function runUntil(steps, deadline) {
  let step = steps.next();
  while (!step.done && performance.now() < deadline) step = steps.next();
  return Boolean(step.done);
}

/** Returns the visible part of a canvas, as a box in user units, for a matrix from user units to pixels.
 *
 * @param {{width: number, height: number}} size
 * @param {number[]} matrix
 * @returns {number[]} */
export function windowOf({ width, height }, [scaleX, , , scaleY, x, y]) {
  return [-x / scaleX, -y / scaleY, (width - x) / scaleX, (height - y) / scaleY];
}

/** Returns keys of the picture after the background and after each of `layers`. */
export function signatures(layers, palette) {
  const keys = [palette.name];
  for (const { key, version } of layers) keys.push(`${keys.at(-1)} ${key}:${version}`);
  return keys;
}
