/* Path data: reads that of any SVG as cubics, and writes cubics in the short form of warpvec.
 *
 * A shape is {subpaths, d, box, path2d, form} and is never changed, so that undo can keep it. Its form is as in forms.js. A subpath is
 * {points, closed, kinds}; points are 2 * (3 * segments + 1) numbers: x, y of anchor, handle, handle, anchor, ... A kind
 * for each segment says how to write it: "l" a line, "s" a cubic whose handle mirrors the one before, else "c". */

import { COMMAND, Pen } from "viewer/pen.js";

/** Returns the shape of path data. */
export function parseShape(d) {
  const pen = new Pen();
  for (const [, letter, text] of d.matchAll(COMMAND)) pen.command(letter, text);
  return makeShape(pen.finished(), d);
}

/** Returns a shape of `subpaths`; `d` is its original text, null if it has to be written anew. */
export function makeShape(subpaths, d = null) {
  return { subpaths, d, box: boundsOf(subpaths), path2d: null };
}

/**
 * @param {any} shape
 * @param {number[]} matrix */
export function transformShape(shape, [a, b, c, d, e, f]) {
  const moved = shape.subpaths.map(({ points, ...rest }) => {
    const result = new Float64Array(points.length);
    for (let i = 0; i < points.length; i += 2) {
      result[i] = a * points[i] + c * points[i + 1] + e;
      result[i + 1] = b * points[i] + d * points[i + 1] + f;
    }
    return { points: result, ...rest };
  });
  return makeShape(moved);
}

/** Returns the Path2D of a shape, made when it is first drawn. */
export function path2dOf(shape) {
  if (shape.path2d) return shape.path2d;
  const path = new Path2D();
  for (const { points: p, closed } of shape.subpaths) {
    path.moveTo(p[0], p[1]);
    for (let i = 2; i < p.length; i += 6) path.bezierCurveTo(p[i], p[i + 1], p[i + 2], p[i + 3], p[i + 4], p[i + 5]);
    if (closed) path.closePath();
  }
  shape.path2d = path;
  return path;
}

/** Returns path data with `decimals`, as warpvec/svg/path_data.py writes it: the first start is absolute, and one after a
 * point, as a point is a short line and the pen lies beside it. */
export function writeShape(shape, decimals) {
  if (shape.d !== null) return shape.d;
  const perUnit = 10 ** decimals;
  let at = null;
  let text = "";
  for (const subpath of shape.subpaths) {
    const { points, closed } = subpath;
    const start = [toTicks(points[0], perUnit), toTicks(points[1], perUnit)];
    const move = at ? [start[0] - at[0], start[1] - at[1]] : start;
    const segments = writeSegments(subpath, perUnit);
    text += (at ? "m" : "M") + numberList(move, perUnit) + segments + (closed ? "z" : "");
    at = closed ? start : [...points.slice(-2)].map((value) => toTicks(value, perUnit));
    if (!closed && /^h\.0?1$/.test(segments)) at = null;
  }
  return text;
}

function toTicks(value, perUnit) {
  return Math.round(value * perUnit) + 0;
}

function writeSegments(subpath, perUnit) {
  const segments = relativeSegments(subpath, perUnit).filter(({ ticks }) => ticks.some((value) => value !== 0));
  if (subpath.closed && segments.at(-1)?.kind === "l") segments.pop(); // "z" draws it
  if (!segments.length) return subpath.kinds?.[0] === "l" ? "" : "c0 0 0 0 0 0";
  let text = "";
  let last = "";
  let mirrored = [0, 0];
  for (const { kind, ticks } of segments) {
    const isSmooth = kind === "s" && ticks[0] === mirrored[0] && ticks[1] === mirrored[1];
    const [letter, values] = kind === "l" ? writeLine(ticks) : isSmooth ? ["s", ticks.slice(2)] : ["c", ticks];
    const words = numberList(values, perUnit);
    text += letter === last ? (words[0] === "-" ? words : ` ${words}`) : letter + words;
    last = letter;
    mirrored = kind === "l" ? [0, 0] : [ticks[4] - ticks[2], ticks[5] - ticks[3]];
  }
  return text;
}

/**
 * @param {number[]} ticks
 * @returns {[string, number[]]} */
function writeLine([x, y]) {
  return y === 0 ? ["h", [x]] : x === 0 ? ["v", [y]] : ["l", [x, y]];
}

/** Returns kind and ticks of each segment relative to its anchor: differences of rounded anchors, so that a reader's sum
 * is exact, and rounded offsets of handles, so that moving a path keeps them. */
function relativeSegments({ points: p, kinds = [] }, perUnit) {
  const segments = [];
  for (let i = 0; i + 7 < p.length; i += 6) {
    const [x, y] = [p[i], p[i + 1]];
    const end = [p[i + 6], p[i + 7]].map((value, axis) => toTicks(value, perUnit) - toTicks(p[i + axis], perUnit));
    const handles = [p[i + 2] - x, p[i + 3] - y, p[i + 4] - x, p[i + 5] - y].map((value) => toTicks(value, perUnit));
    const kind = kinds[i / 6] ?? "c";
    segments.push({ kind, ticks: kind === "l" ? end : [...handles, ...end] });
  }
  return segments;
}

/** Joins numbers; no space is needed before a minus, nor before a point if the last number contains one. */
function numberList(ticks, perUnit) {
  let text = "";
  let hasPoint = false;
  for (const value of ticks) {
    const word = formatNumber(value / perUnit);
    const separates = text === "" || word[0] === "-" || (word[0] === "." && hasPoint);
    text += separates ? word : ` ${word}`;
    hasPoint = word.includes(".");
  }
  return text;
}

/** Returns a number without the zero before its point: "12.5", "-.25", "0". */
export function formatNumber(value, decimals = 6) {
  const text = value.toFixed(decimals).replace(/\.?0+$/, "").replace(/^(-?)0\./, "$1.");
  return text === "-0" ? "0" : text;
}

/** Returns the tight box [left, top, right, bottom] of the curves; without any, [Infinity, ..., -Infinity]. */
function boundsOf(subpaths) {
  const box = [Infinity, Infinity, -Infinity, -Infinity];
  for (const { points: p } of subpaths) {
    for (let axis = 0; axis < 2; axis++) {
      extend(box, axis, p[axis]);
      for (let i = axis; i + 6 < p.length; i += 6) {
        extend(box, axis, p[i + 6]);
        extendByExtremes(box, axis, p[i], p[i + 2], p[i + 4], p[i + 6]);
      }
    }
  }
  return box;
}

function extend(box, axis, value) {
  if (value < box[axis]) box[axis] = value;
  if (value > box[axis + 2]) box[axis + 2] = value;
}

/** Extends the box to the points of a cubic at which the derivative of one coordinate is zero. */
function extendByExtremes(box, axis, p0, p1, p2, p3) {
  const inside = (p) => p >= box[axis] && p <= box[axis + 2];
  if (inside(p1) && inside(p2)) return;
  const a = 3 * (p1 - p2) + p3 - p0;
  const b = 2 * (p0 - 2 * p1 + p2);
  const c = p1 - p0;
  const root = Math.sqrt(Math.max(b * b - 4 * a * c, 0));
  const candidates = Math.abs(a) < 1e-9 ? [-c / b] : [(-b + root) / (2 * a), (-b - root) / (2 * a)];
  for (const t of candidates) {
    if (!(t > 0 && t < 1)) continue;
    const s = 1 - t;
    extend(box, axis, s * s * s * p0 + 3 * s * s * t * p1 + 3 * s * t * t * p2 + t * t * t * p3);
  }
}

export function unionOfBoxes(boxes) {
  const union = [Infinity, Infinity, -Infinity, -Infinity];
  for (const box of boxes) {
    for (let axis = 0; axis < 2; axis++) {
      if (box[axis] < union[axis]) union[axis] = box[axis];
      if (box[axis + 2] > union[axis + 2]) union[axis + 2] = box[axis + 2];
    }
  }
  return union;
}

/**
 * @param {number[]} box
 * @param {number} by */
export function grownBox([left, top, right, bottom], by) {
  return [left - by, top - by, right + by, bottom + by];
}

/** Returns the box around a transformed box.
 *
 * @param {number[]} box
 * @param {number[]} matrix */
export function transformedBox([left, top, right, bottom], [a, b, c, d, e, f]) {
  const corners = [[left, top], [right, top], [right, bottom], [left, bottom]];
  return unionOfBoxes(corners.map(([x, y]) => [a * x + c * y + e, b * x + d * y + f]).map(([x, y]) => [x, y, x, y]));
}

export function boxesMeet(a, b) {
  return a[0] <= b[2] && b[0] <= a[2] && a[1] <= b[3] && b[1] <= a[3];
}

export function boxContains(outer, inner) {
  return inner[0] >= outer[0] && inner[1] >= outer[1] && inner[2] <= outer[2] && inner[3] <= outer[3];
}
