/* Turns a freehand stroke of a round brush into its outline, one closed path of cubics. */

import { makeShape } from "viewer/paths.js";

const CIRCLE_HANDLE = 0.5523;
// Spline points of each round end of a stroke.
const CAP_CORNERS = 3;

/** Returns the outline of a stroke along `points` [[x, y], ...] with a brush of `width`; a dot for a single point. */
export function strokeOutline(points, width) {
  const radius = width / 2;
  const line = smoothed(spaced(points, Math.max(radius / 2, width / 8)));
  if (line.length < 2) return makeShape([circle(points[0], radius)]);
  const ends = [cap(line.at(-1), line.at(-2), radius), cap(line[0], line[1], radius)];
  const corners = [...side(line, radius), ...ends[0], ...side(line.toReversed(), radius), ...ends[1]];
  return makeShape([closedSpline(corners)]);
}

function circle([x, y], r) {
  const k = CIRCLE_HANDLE * r;
  const points = [
    x + r, y, x + r, y + k, x + k, y + r, x, y + r, x - k, y + r, x - r, y + k, x - r, y,
    x - r, y - k, x - k, y - r, x, y - r, x + k, y - r, x + r, y - k, x + r, y,
  ];
  return { points: Float64Array.from(points), closed: true };
}

/** Returns points at least `gap` apart; the last point is kept. */
function spaced(points, gap) {
  const kept = [points[0]];
  for (const point of points) if (distance(point, kept.at(-1)) >= gap) kept.push(point);
  const last = points.at(-1);
  if (kept.length > 1 && distance(last, kept.at(-1)) > 0) kept.splice(-1, 1, last);
  return kept;
}

/** Smooths the line twice by weighted means of neighbours; the ends stay in place. */
function smoothed(points) {
  let line = points;
  for (let round = 0; round < 2; round++) {
    line = line.map((point, i) => {
      if (i === 0 || i === line.length - 1) return point;
      return [0, 1].map((axis) => (line[i - 1][axis] + 2 * point[axis] + line[i + 1][axis]) / 4);
    });
  }
  return line;
}

/** Returns the line shifted to its left by `radius`. */
function side(line, radius) {
  return line.map((point, i) => {
    const [before, after] = [line[Math.max(i - 1, 0)], line[Math.min(i + 1, line.length - 1)]];
    const length = distance(before, after) || 1;
    const [nx, ny] = [(after[1] - before[1]) / length, (before[0] - after[0]) / length];
    return [point[0] + radius * nx, point[1] + radius * ny];
  });
}

/** Returns points of the half circle around `end`, from the left to the right of the line from `before`. */
function cap(end, before, radius) {
  const start = Math.atan2(before[0] - end[0], end[1] - before[1]);
  return Array.from({ length: CAP_CORNERS }, (_, i) => {
    const angle = start + (Math.PI * (i + 1)) / (CAP_CORNERS + 1);
    return [end[0] + radius * Math.cos(angle), end[1] + radius * Math.sin(angle)];
  });
}

/** Returns the closed Catmull-Rom spline through `corners` as cubics. */
function closedSpline(corners) {
  const at = (i) => corners[(i + corners.length) % corners.length];
  const points = [...corners[0]];
  corners.forEach((corner, i) => {
    const next = at(i + 1);
    for (const axis of [0, 1]) points.push(corner[axis] + (next[axis] - at(i - 1)[axis]) / 6);
    for (const axis of [0, 1]) points.push(next[axis] - (at(i + 2)[axis] - corner[axis]) / 6);
    points.push(...next);
  });
  return { points: Float64Array.from(points), closed: true };
}

export function distance(a, b) {
  return Math.hypot(a[0] - b[0], a[1] - b[1]);
}
