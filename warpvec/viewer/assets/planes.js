/* The picture split into the selected paths and still planes below and above them.
 *
 * Still planes are drawn only once, so a frame in which the selection changes costs a few copies, however many paths there
 * are. They are drawn in steps as soon as something is selected, so that they are mostly there when they are needed. */

import { multiply } from "viewer/basics.js";
import { differenceOf, sameState, snapshotOf } from "viewer/changes.js";
import { placeOf } from "viewer/painted.js";
import { newCanvas, paintBackground, painting, paintItems, runUntil, windowOf } from "viewer/raster.js";
import { IDENTITY } from "viewer/read.js";

// More moving planes cost more copies per frame. Beyond these, the drawing order is wrong until the gesture ends.
const MAX_MOVING_PLANES = 4;
// A moving plane with more paths is moved as a picture, whose edges are blurred until the gesture ends.
const MAX_LIVE_PATHS = 200;

export class Planes {
  /** `wanted` is as in painted.js; `old` planes are taken over as far as they are the same. */
  constructor(wanted, selection, old = null) {
    this.wanted = wanted;
    this.place = placeOf(wanted);
    this.items = wanted.layers.flatMap(({ items }) => items);
    const runs = runsOf(this.items, selection);
    this.isExact = runs.length === exactRunCount(this.items, selection);
    this.planes = runs.map((run, i) => {
      const isLive = run.isMoving && run.items.length <= MAX_LIVE_PATHS;
      return { ...run, isFirst: i === 0, snapshot: snapshotOf(run.items), isLive, isReady: isLive, canvas: null, steps: null };
    });
    for (const plane of this.planes) {
      if (old?.place === this.place) plane.canvas = old.canvasOf(plane);
      plane.isReady ||= Boolean(plane.canvas);
    }
  }

  /** Tells whether these are the planes of the same paths, selected alike. */
  isFor(wanted, selection) {
    if (this.place !== placeOf(wanted)) return false;
    const [items, state] = [wanted.layers.flatMap((layer) => layer.items), new Map()];
    if (items.length !== this.items.length || items.some((item, i) => item !== this.items[i])) return false;
    for (const plane of this.planes) for (const item of plane.items) state.set(item, plane.isMoving);
    return items.every((item) => state.get(item) === selection.has(item)) && this.planes.every((plane) => !isOutdated(plane));
  }

  /** Returns the finished canvas of the same plane, which this object then no longer owns. */
  canvasOf({ isLive, isFirst, snapshot }) {
    const same = this.planes.find((plane) => {
      const isSame = !isLive && plane.isReady && plane.canvas && plane.isFirst === isFirst;
      return isSame && differenceOf(plane.snapshot, snapshot) === null;
    });
    return same?.canvas ?? null;
  }

  /** The memory of the canvases of all planes. */
  get byteCount() {
    return 4 * this.wanted.width * this.wanted.height * this.planes.filter((plane) => !plane.isLive).length;
  }

  get isReady() {
    return this.planes.every((plane) => plane.isReady);
  }

  /** Draws what is missing until `deadline`; returns whether all is there. */
  work(deadline) {
    for (const plane of this.planes) {
      if (plane.isReady) continue;
      plane.steps ??= this.drawing(plane);
      plane.isReady = runUntil(plane.steps, deadline);
      if (!plane.isReady) return false;
    }
    return true;
  }

  *drawing(plane) {
    const { width, height, matrix, drawing, palette } = this.wanted;
    const { canvas, context } = newCanvas(width, height);
    plane.canvas = canvas;
    context.setTransform(...matrix);
    if (plane.isFirst) paintBackground(context, drawing, palette);
    yield* painting(context, plane.items, palette, windowOf(canvas, matrix));
  }

  /** Lets a moving plane that is a picture be painted from its paths, which no longer look as in it. */
  paintLive() {
    for (const plane of this.planes) if (plane.isMoving) Object.assign(plane, { isLive: true, isReady: true, canvas: null });
  }

  /** Tells whether `draw` gives the very picture of `items`, of which only the selected ones may have changed. */
  canDraw(items, wanted) {
    const alike = this.isReady && this.isExact && this.place === placeOf(wanted) && items.length === this.items.length;
    if (!alike || this.planes.some((plane) => (plane.isMoving ? !plane.isLive : isOutdated(plane)))) return false;
    return items.every((item, i) => item === this.items[i]);
  }

  /** Draws the planes, the moving ones transformed by `change`, on a canvas of their size. */
  draw(context, change, palette) {
    const { matrix } = this.wanted;
    for (const plane of this.planes) {
      if (plane.isLive) {
        context.setTransform(...multiply(matrix, change));
        paintItems(context, plane.items, palette, null);
      } else if (plane.items.length || plane.isFirst) {
        context.setTransform(...(plane.isMoving ? multiply(multiply(matrix, change), inverse(matrix)) : IDENTITY));
        context.drawImage(plane.canvas, 0, 0);
      }
    }
    context.setTransform(...IDENTITY);
  }
}

function isOutdated(plane) {
  return !plane.isLive && plane.items.some((item, i) => !sameState(item, plane.snapshot.states[i]));
}

/** Returns runs of still and moving items in drawing order. The first run is still and may be empty. */
function runsOf(items, moving) {
  const runs = [{ isMoving: false, items: [] }];
  for (const item of items) {
    if (moving.has(item) !== runs.at(-1).isMoving) runs.push({ isMoving: moving.has(item), items: [] });
    runs.at(-1).items.push(item);
  }
  let count = runs.filter((run) => run.isMoving).length;
  for (; count > MAX_MOVING_PLANES; count--) mergeNearest(runs);
  return runs;
}

function exactRunCount(items, moving) {
  let [count, last] = [1, false];
  for (const item of items) {
    if (moving.has(item) === last) continue;
    count++;
    last = !last;
  }
  return count;
}

/** Merges the two moving runs with the fewest still items between them; those items move below. */
function mergeNearest(runs) {
  let best = 2;
  for (let i = 2; i < runs.length - 1; i += 2) if (runs[i].items.length < runs[best].items.length) best = i;
  const [first, between, second] = runs.splice(best - 1, 3);
  runs[best - 2].items = runs[best - 2].items.concat(between.items);
  runs.splice(best - 1, 0, { isMoving: true, items: first.items.concat(second.items) });
}

/** Returns the inverse of a matrix that only scales and translates.
 *
 * @param {number[]} matrix */
export function inverse([a, , , d, e, f]) {
  return [1 / a, 0, 0, 1 / d, -e / a, -f / d];
}
