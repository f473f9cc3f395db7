/* The picture of a drawing on a canvas, kept up to date with little work per frame.
 *
 * A small change redraws only its box. Anything else is drawn on a second canvas in steps, over several frames, while the
 * first one shows the picture before. */

import { differenceOf, snapshotOf } from "viewer/changes.js";
import { boxesMeet } from "viewer/paths.js";
import {
  newCanvas, paintBackground, painting, paintItems, PLAIN, reachOf, runUntil, signatures, windowOf,
} from "viewer/raster.js";
import { IDENTITY } from "viewer/read.js";

// A box with more paths than this is drawn in steps.
const MAX_PATCHED_PATHS = 160;
// A picture that is started anew after this time is finished at once, lest changes that follow each other keep it from ever
// showing.
const MAX_LATE_MS = 250;

export class PaintedDrawing {
  constructor() {
    this.front = newCanvas(1, 1);
    this.back = newCanvas(1, 1);
    this.matrix = IDENTITY;
    this.shown = null;
    this.job = null;
    this.lateSince = null;
  }

  get canvas() {
    return this.front.canvas;
  }

  /** Works on the picture `wanted` until `deadline`; returns whether it is shown. `planes` may make a change cheap.
   *
   * `wanted` is {drawing, layers, palette, width, height, matrix}: the visible layers, the size in pixels, and the matrix
   * from user units to pixels. */
  update(wanted, deadline, planes = null) {
    const key = keyOf(wanted);
    const now = performance.now();
    if (this.shown?.key === key || this.patch(wanted, key, planes)) {
      [this.job, this.lateSince] = [null, null];
      return true;
    }
    this.lateSince ??= now;
    const isNew = this.job?.key !== key;
    if (isNew) this.start(wanted, key);
    if (!runUntil(this.job.steps, isNew && now - this.lateSince > MAX_LATE_MS ? Infinity : deadline)) return false;
    [this.front, this.back] = [this.back, this.front];
    [this.shown, this.matrix, this.job, this.lateSince] = [this.job.shown, wanted.matrix, null, null];
    return true;
  }

  /** Redraws only what has changed, if that is little; returns whether it did. */
  patch(wanted, key, planes) {
    const { shown } = this;
    if (!shown || shown.place !== placeOf(wanted)) return false;
    const snapshot = snapshotOf(wanted.layers.flatMap(({ items }) => items));
    const box = differenceOf(shown.snapshot, snapshot);
    if (box && !this.redraw(box, snapshot.items, wanted, planes)) return false;
    this.shown = { key, place: shown.place, snapshot };
    return true;
  }

  redraw(box, items, wanted, planes) {
    const pixels = pixelBox(box, wanted.matrix, wanted);
    const { context } = this.front;
    const inside = windowOf({ width: pixels[2] - pixels[0], height: pixels[3] - pixels[1] }, shifted(wanted.matrix, pixels));
    const touched = items.filter((item) => boxesMeet(reachOf(item), inside));
    const helped = touched.length > MAX_PATCHED_PATHS;
    if (helped && !planes?.canDraw(items, wanted)) return false;
    inBox(context, pixels, () => {
      if (helped) planes.draw(context, IDENTITY, wanted.palette);
      else repaint(context, wanted, touched);
    });
    return true;
  }

  start(wanted, key) {
    const { canvas, context } = this.back;
    const { drawing, palette, matrix, width, height } = wanted;
    const snapshot = snapshotOf(wanted.layers.flatMap(({ items }) => items));
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    const steps = paintDrawing(context, drawing, snapshot.items, palette, matrix);
    this.job = { key, shown: { key, place: placeOf(wanted), snapshot }, steps };
  }
}

export function* paintDrawing(context, drawing, items, palette, matrix) {
  const { width, height } = context.canvas;
  context.setTransform(...IDENTITY);
  context.clearRect(0, 0, width, height);
  context.setTransform(...matrix);
  paintBackground(context, drawing, palette);
  yield* painting(context, items, palette, windowOf(context.canvas, matrix));
}

function repaint(context, { drawing, palette, matrix }, items) {
  context.setTransform(...matrix);
  paintBackground(context, drawing, palette);
  paintItems(context, items, palette, null);
}

/** Tells pictures apart whose unchanged parts are at other places or in other colours. */
export function placeOf({ drawing, layers, palette, width, height, matrix }) {
  const { background, box } = drawing;
  // Colours of layers change with their number.
  const counts = palette === PLAIN ? [] : [drawing.layers.length, ...layers.map(({ key, items }) => `${key}:${items.length}`)];
  return [palette.name, width, height, ...matrix, ...box, background?.fill, background?.opacity, ...counts].join(" ");
}

export function keyOf(wanted) {
  return `${placeOf(wanted)} ${signatures(wanted.layers, wanted.palette).at(-1)}`;
}

/** Returns the box of whole pixels around a box in user units, and one more for soft edges, inside the canvas.
 *
 * @param {number[]} box
 * @param {number[]} matrix
 * @param {{width: number, height: number}} size */
export function pixelBox([left, top, right, bottom], [a, , , d, e, f], { width, height }) {
  const low = (value, limit) => Math.min(Math.max(Math.floor(value) - 1, 0), limit);
  const high = (value, limit) => Math.max(Math.min(Math.ceil(value) + 1, limit), 0);
  return [low(a * left + e, width), low(d * top + f, height), high(a * right + e, width), high(d * bottom + f, height)];
}

/**
 * @param {number[]} matrix
 * @param {number[]} pixels */
function shifted([a, b, c, d, e, f], [left, top]) {
  return [a, b, c, d, e - left, f - top];
}

/** Clears a box of whole pixels and lets `draw` draw inside it.
 *
 * @param {any} context
 * @param {number[]} pixels
 * @param {() => void} draw */
export function inBox(context, [left, top, right, bottom], draw) {
  context.save();
  context.setTransform(...IDENTITY);
  context.beginPath();
  context.rect(left, top, Math.max(right - left, 0), Math.max(bottom - top, 0));
  context.clip();
  context.clearRect(left, top, right - left, bottom - top);
  draw();
  context.restore();
}
