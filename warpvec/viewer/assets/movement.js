/* What has moved between two states of a shape: all of it, or some of its nodes; and the same for a shape like it. */

import { makeShape, transformShape } from "viewer/paths.js";
import { neighbours, nodesOf } from "viewer/nodes.js";

// Share of the shape's size by which a point may differ after a move of the whole.
const SAME_PLACE = 1e-4;
// Share of the shape's size within which a node of a shape like it is the same node.
const SAME_NODE = 0.04;

/** Returns the matrix that moves one shape to another; null if their outlines differ by more than a move.
 *
 * @returns {number[] | null} */
export function affineBetween(before, after) {
  const [from, to] = [pointsOf(before), pointsOf(after)];
  if (from.length !== to.length || !sameLoops(before, after)) return null;
  const matrix = leastSquares(from, to);
  if (!matrix) return null;
  const moved = pointsOf(transformShape(before, matrix));
  const limit = SAME_PLACE * sizeOf(after);
  return moved.every(([x, y], i) => Math.abs(x - to[i][0]) <= limit && Math.abs(y - to[i][1]) <= limit) ? matrix : null;
}

function pointsOf({ subpaths }) {
  return subpaths.flatMap(({ points }) => Array.from({ length: points.length / 2 }, (_, i) => [points[2 * i], points[2 * i + 1]]));
}

function sameLoops(a, b) {
  return a.subpaths.length === b.subpaths.length && a.subpaths.every(({ points }, i) => points.length === b.subpaths[i].points.length);
}

function sizeOf({ box }) {
  return Math.max(box[2] - box[0], box[3] - box[1], 1e-9);
}

/** Returns the matrix that moves the points `from` closest to the points `to`; null if these lie on a line. */
function leastSquares(from, to) {
  const mean = (points, axis) => points.reduce((sum, point) => sum + point[axis], 0) / points.length;
  const [x, y, u, v] = [mean(from, 0), mean(from, 1), mean(to, 0), mean(to, 1)];
  const sums = { xx: 0, xy: 0, yy: 0, xu: 0, yu: 0, xv: 0, yv: 0 };
  from.forEach(([px, py], i) => {
    const [dx, dy, du, dv] = [px - x, py - y, to[i][0] - u, to[i][1] - v];
    sums.xx += dx * dx;
    sums.xy += dx * dy;
    sums.yy += dy * dy;
    sums.xu += dx * du;
    sums.yu += dy * du;
    sums.xv += dx * dv;
    sums.yv += dy * dv;
  });
  const { xx, xy, yy, xu, yu, xv, yv } = sums;
  const determinant = xx * yy - xy * xy;
  if (determinant <= 1e-9 * xx * yy || !(xx > 0)) return null;
  const row = (first, second) => [(first * yy - second * xy) / determinant, (second * xx - first * xy) / determinant];
  const [[a, c], [b, d]] = [row(xu, yu), row(xv, yv)];
  return [a, b, c, d, u - a * x - c * y, v - b * x - d * y];
}

/** Returns `shape` with the nodes moved that have moved from `before` to `after`; null if it does not have them. */
export function followNodes(before, after, shape) {
  if (!sameLoops(before, after)) return null;
  const [old, now, own] = [nodesOf(before), nodesOf(after), nodesOf(shape)];
  const moved = old.flatMap((node, i) => (differs(node, now[i]) ? [[node, now[i]]] : []));
  const limit = SAME_NODE * sizeOf(before);
  const subpaths = shape.subpaths.map(({ points, closed, kinds }) => ({ points: points.slice(), closed, kinds: kinds && [...kinds] }));
  for (const [from, to] of moved) {
    const nearest = own.map((node) => ({ node, gap: Math.hypot(node.x - from.x, node.y - from.y) })).sort((a, b) => a.gap - b.gap)[0];
    if (!nearest || nearest.gap > limit) return null;
    moveNode(subpaths[nearest.node.loop], nearest.node, from, to);
  }
  return { ...makeShape(subpaths), corners: shape.corners };
}

function differs(a, b) {
  return JSON.stringify([a.x, a.y, a.before, a.after]) !== JSON.stringify([b.x, b.y, b.before, b.after]);
}

/** Moves a node as another one has moved; its handles follow those of the other one. */
function moveNode(subpath, { node, x, y }, from, to) {
  const { points: p, kinds = [] } = subpath;
  const [dx, dy] = [to.x - from.x, to.y - from.y];
  const put = (at, shift) => [p[at], p[at + 1]] = [p[at] + shift[0], p[at + 1] + shift[1]];
  const shiftOf = (side) => (from[side] && to[side] ? [to[side][0] - from[side][0], to[side][1] - from[side][1]] : [dx, dy]);
  const [last, next] = neighbours(subpath, node);
  [p[6 * node], p[6 * node + 1]] = [x + dx, y + dy];
  if (subpath.closed && node === 0) [p[p.length - 2], p[p.length - 1]] = [x + dx, y + dy];
  if (last !== null) {
    put(6 * last + 4, shiftOf("before"));
    straighten(p, last, kinds);
  }
  if (next !== null) {
    put(6 * next + 2, shiftOf("after"));
    straighten(p, next, kinds);
  }
}

/** Puts the handles of a line back to its thirds. */
function straighten(p, segment, kinds) {
  if (kinds[segment] !== "l") return;
  const at = 6 * segment;
  for (const axis of [0, 1]) {
    const step = (p[at + 6 + axis] - p[at + axis]) / 3;
    p[at + 2 + axis] = p[at + axis] + step;
    p[at + 4 + axis] = p[at + 6 + axis] - step;
  }
}
