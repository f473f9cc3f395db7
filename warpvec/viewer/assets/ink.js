/* Fills and strokes on a canvas, with colours and gradients. */

import { isGradient } from "viewer/gradients.js";

// Below this length or radius in user units, SVG and warpvec show the last colour alone.
const EXTENT_MIN = 1e-3;

/** Fills `path` with a fill, in the context's transform. */
export function fillPath(context, path, rule, fill) {
  context.fillStyle = inkOf(context, fill);
  const matrix = isGradient(fill) && fill.matrix;
  if (!matrix) {
    context.fill(path, rule);
    return;
  }
  // The canvas transforms path and gradient alike, so the path is first transformed back.
  const back = new Path2D();
  back.addPath(path, new DOMMatrix(matrix).inverse());
  context.save();
  context.transform(...matrix);
  context.fill(back, rule);
  context.restore();
}

/** Strokes `path` with a stroke as in read.js, in `paint`, in the context's transform. */
export function strokePath(context, path, { width, cap, join, limit }, paint) {
  const look = { lineWidth: width, lineCap: cap, lineJoin: join, miterLimit: limit };
  if (isGradient(paint) && paint.matrix) {
    strokeThrough(context, path, look, paint);
    return;
  }
  Object.assign(context, look, { strokeStyle: inkOf(context, paint) });
  context.stroke(path);
}

/** Strokes with a gradient that has a matrix, which must not turn the width: the stroke is the mask of a filled sheet. */
function strokeThrough(context, path, look, paint) {
  const { width, height } = context.canvas;
  const sheet = new OffscreenCanvas(width, height).getContext("2d");
  sheet.setTransform(context.getTransform());
  Object.assign(sheet, look);
  sheet.stroke(path);
  sheet.globalCompositeOperation = "source-in";
  const all = new Path2D();
  all.addPath(boxPath(width, height), sheet.getTransform().inverse());
  fillPath(sheet, all, "nonzero", paint);
  context.save();
  context.resetTransform();
  context.drawImage(sheet.canvas, 0, 0);
  context.restore();
}

function boxPath(width, height) {
  const path = new Path2D();
  path.rect(0, 0, width, height);
  return path;
}

/** Returns what a canvas paints with; that of a gradient is kept. */
function inkOf(context, paint) {
  if (!isGradient(paint)) return paint;
  paint.onCanvas ??= canvasGradient(context, paint);
  return paint.onCanvas;
}

function canvasGradient(context, { kind, numbers: n, stops }) {
  const extent = kind === "linear" ? Math.hypot(n[2] - n[0], n[3] - n[1]) : n[2];
  if (!(extent >= EXTENT_MIN)) return cssColor(stops.at(-1));
  const gradient =
    kind === "linear" ? context.createLinearGradient(...n) : context.createRadialGradient(n[3], n[4], 0, n[0], n[1], n[2]);
  for (const stop of stops) gradient.addColorStop(stop.offset, cssColor(stop));
  return gradient;
}

function cssColor({ color, opacity }) {
  return opacity === 1 ? color : color + Math.round(255 * opacity).toString(16).padStart(2, "0");
}
