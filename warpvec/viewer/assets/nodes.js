/* The nodes of a shape, and changes of them. Each change returns a new shape and leaves the old one as it is.
 *
 * A node is {index, loop, node, x, y, before, after, isSmooth}. `before` and `after` are its handles [x, y]; null next to
 * a line and at the end of an open path. A shape may have `corners`, indices of nodes whose handles move apart although
 * they are in line. */

import { distance } from "viewer/brush.js";
import { makeShape } from "viewer/paths.js";

// Handles that are in line within 1 degree make a smooth node.
const SMOOTH_SINE = Math.sin(Math.PI / 180);
const PLACES_PER_SEGMENT = 24;

/** Returns the nodes of a shape, loop by loop. */
export function nodesOf(shape) {
  return (shape.nodes ??= shape.subpaths.flatMap(nodesOfLoop).map((node, index) => {
    return { ...node, index, isSmooth: isSmooth(node) && !shape.corners?.has(index) };
  }));
}

function nodesOfLoop(subpath, loop) {
  const { points: p, closed, kinds = [] } = subpath;
  const count = segmentCount(subpath);
  return Array.from({ length: closed ? count : count + 1 }, (_, node) => {
    const [last, next] = neighbours(subpath, node);
    const handle = (segment, at) => (segment === null || kinds[segment] === "l" ? null : [p[6 * segment + at], p[6 * segment + at + 1]]);
    return { loop, node, x: p[6 * node], y: p[6 * node + 1], before: handle(last, 4), after: handle(next, 2) };
  });
}

function segmentCount({ points }) {
  return (points.length - 2) / 6;
}

/** Returns the indices of the segments before and after a node; null without one. */
export function neighbours(subpath, node) {
  const count = segmentCount(subpath);
  return [node > 0 ? node - 1 : subpath.closed ? count - 1 : null, node < count ? node : null];
}

function isSmooth({ x, y, before, after }) {
  if (!before || !after) return false;
  const [ax, ay, bx, by] = [before[0] - x, before[1] - y, after[0] - x, after[1] - y];
  const size = Math.hypot(ax, ay) * Math.hypot(bx, by);
  return size > 0 && ax * bx + ay * by < 0 && Math.abs(ax * by - ay * bx) <= SMOOTH_SINE * size;
}

/** Returns a shape of changed copies of the subpaths. Lines are kept straight, and loops closed. */
function reshaped(shape, change, corners = shape.corners) {
  const copies = shape.subpaths.map(({ points, closed, kinds = [] }) => ({ points: points.slice(), closed, kinds: [...kinds] }));
  const subpaths = change(copies) ?? copies;
  for (const { points: p, closed, kinds } of subpaths) {
    if (closed) [p[p.length - 2], p[p.length - 1]] = [p[0], p[1]];
    kinds.forEach((kind, i) => kind === "l" && p.set(thirds(...p.slice(6 * i, 6 * i + 2), ...p.slice(6 * i + 6, 6 * i + 8)), 6 * i + 2));
  }
  return { ...makeShape(subpaths), corners };
}

export function thirds(x, y, endX, endY) {
  const [dx, dy] = [(endX - x) / 3, (endY - y) / 3];
  return [x + dx, y + dy, endX - dx, endY - dy];
}

/** Moves the nodes of the given indices, with their handles. */
export function moveNodes(shape, indices, dx, dy) {
  return reshaped(shape, (subpaths) => {
    for (const { loop, node } of nodesOf(shape).filter(({ index }) => indices.has(index))) {
      const { points: p } = subpaths[loop];
      const [last, next] = neighbours(subpaths[loop], node);
      const places = [6 * node, last === null ? null : 6 * last + 4, next === null ? null : 6 * next + 2];
      for (const place of places.filter((at) => at !== null)) [p[place], p[place + 1]] = [p[place] + dx, p[place + 1] + dy];
    }
  });
}

/** Moves the handle on the `side`, "before" or "after", of a node to x, y. A smooth node turns the other one with it. */
export function moveHandle(shape, index, side, x, y) {
  const node = nodesOf(shape)[index];
  const other = side === "before" ? "after" : "before";
  return reshaped(shape, (subpaths) => {
    setHandle(subpaths[node.loop], node.node, side, x, y);
    const length = Math.hypot(node.x - x, node.y - y);
    if (!node.isSmooth || !length) return;
    const scale = Math.hypot(node[other][0] - node.x, node[other][1] - node.y) / length;
    setHandle(subpaths[node.loop], node.node, other, node.x + scale * (node.x - x), node.y + scale * (node.y - y));
  });
}

function setHandle(subpath, node, side, x, y) {
  const [last, next] = neighbours(subpath, node);
  const place = side === "before" ? 6 * last + 4 : 6 * next + 2;
  [subpath.points[place], subpath.points[place + 1]] = [x, y];
}

/** Makes nodes smooth: their handles lie in line. Lines beside them become curves. */
export function smoothNodes(shape, indices) {
  const corners = new Set([...(shape.corners ?? [])].filter((index) => !indices.has(index)));
  return reshaped(shape, (subpaths) => {
    for (const node of nodesOf(shape).filter(({ index }) => indices.has(index))) smoothNode(subpaths[node.loop], node);
  }, corners);
}

function smoothNode(subpath, { node, x, y }) {
  const [last, next] = neighbours(subpath, node);
  if (last === null || next === null) return;
  const p = subpath.points;
  const ends = [[p[6 * last], p[6 * last + 1]], [p[6 * next + 6], p[6 * next + 7]]];
  const handles = [[p[6 * last + 4], p[6 * last + 5]], [p[6 * next + 2], p[6 * next + 3]]];
  const arms = handles.map((handle, i) => (distance(handle, [x, y]) > 1e-6 ? handle : ends[i]));
  const [back, ahead] = arms.map((arm) => [(arm[0] - x) / (distance(arm, [x, y]) || 1), (arm[1] - y) / (distance(arm, [x, y]) || 1)]);
  let [dx, dy] = [ahead[0] - back[0], ahead[1] - back[1]];
  if (Math.hypot(dx, dy) < 1e-3) [dx, dy] = [-ahead[1], ahead[0]];
  const size = Math.hypot(dx, dy);
  if (!size) return; // all three nodes lie in one place
  [subpath.kinds[last], subpath.kinds[next]] = ["c", "c"];
  const lengths = handles.map((handle, i) => distance(handle, [x, y]) || distance(ends[i], [x, y]) / 3);
  setHandle(subpath, node, "before", x - (lengths[0] * dx) / size, y - (lengths[0] * dy) / size);
  setHandle(subpath, node, "after", x + (lengths[1] * dx) / size, y + (lengths[1] * dy) / size);
}

/** Makes nodes corners: their handles, which stay where they are, move apart from now on. */
export function cornerNodes(shape, indices) {
  return reshaped(shape, () => {}, new Set([...(shape.corners ?? []), ...indices]));
}

/** Makes the segments after nodes lines, or curves if all of them are lines. */
export function switchLines(shape, indices) {
  const chosen = nodesOf(shape).filter(({ index }) => indices.has(index));
  return reshaped(shape, (subpaths) => {
    const segments = chosen.map(({ loop, node }) => [subpaths[loop].kinds, neighbours(subpaths[loop], node)[1]]);
    const known = segments.filter(([, segment]) => segment !== null);
    const kind = known.every(([kinds, segment]) => kinds[segment] === "l") ? "c" : "l";
    for (const [kinds, segment] of known) kinds[segment] = kind;
  });
}

/** Adds a node at the share `t` of a segment of a loop, without a change of the outline. */
export function addNode(shape, loop, segment, t = 0.5) {
  return reshaped(shape, (subpaths) => {
    const pieces = segmentsOf(subpaths[loop]);
    pieces.splice(segment, 1, ...halves(pieces[segment], t));
    subpaths[loop] = joined(pieces, subpaths[loop].closed);
  }, null);
}

/** Removes nodes; the curves beside each become one that leaves and arrives as they did. A loop needs two nodes. */
export function removeNodes(shape, indices) {
  return reshaped(shape, (subpaths) => {
    const chosen = nodesOf(shape).filter(({ index }) => indices.has(index));
    for (const { loop, node } of chosen.toReversed()) subpaths[loop] &&= withoutNode(subpaths[loop], node);
    return subpaths.filter(Boolean);
  }, null);
}

function withoutNode(subpath, node) {
  const pieces = segmentsOf(subpath);
  if (pieces.length < (subpath.closed ? 3 : 2)) return null;
  const [last, next] = neighbours(subpath, node);
  if (last === null) pieces.shift();
  else if (next === null) pieces.pop();
  else if (node === 0) pieces.splice(-1, 1, joinedPieces(pieces.at(-1), pieces.shift()));
  else pieces.splice(last, 2, joinedPieces(pieces[last], pieces[next]));
  return joined(pieces, subpath.closed);
}

/** Returns segments {points, kind} of four points [x, y] each. */
export function segmentsOf({ points: p, kinds = [] }) {
  const count = (p.length - 2) / 6;
  return Array.from({ length: count }, (_, i) => {
    return { points: [0, 2, 4, 6].map((at) => [p[6 * i + at], p[6 * i + at + 1]]), kind: kinds[i] === "l" ? "l" : "c" };
  });
}

export function joined(pieces, closed) {
  const points = [...pieces[0].points[0], ...pieces.flatMap((piece) => piece.points.slice(1).flat())];
  return { points: Float64Array.from(points), closed, kinds: pieces.map(({ kind }) => kind) };
}

/**
 * @param {{points: number[][], kind?: string}} segment
 * @param {number} t */
export function halves({ points: [a, b, c, d], kind }, t) {
  const [ab, bc, cd] = [between(a, b, t), between(b, c, t), between(c, d, t)];
  const [abc, bcd] = [between(ab, bc, t), between(bc, cd, t)];
  const middle = between(abc, bcd, t);
  return [{ points: [a, ab, abc, middle], kind }, { points: [middle, bcd, cd, d], kind }];
}

function between(a, b, t) {
  return [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
}

export function joinedPieces(first, second) {
  const [a, b] = first.points;
  const [, , c, d] = second.points;
  const lengths = [first, second].map(({ points }) => distance(points[0], points[3]) || 1);
  const whole = lengths[0] + lengths[1];
  const kind = first.kind === "l" && second.kind === "l" ? "l" : "c";
  return { points: [a, between(a, b, whole / lengths[0]), between(d, c, whole / lengths[1]), d], kind };
}

/** Returns the place of the outline nearest to x, y: {loop, segment, t, distance}. */
export function nearestPlace(shape, x, y) {
  let best = { distance: Infinity, loop: -1, segment: -1, t: 0 };
  shape.subpaths.forEach((subpath, loop) => {
    segmentsOf(subpath).forEach(({ points }, segment) => {
      for (let i = 1; i < PLACES_PER_SEGMENT; i++) {
        const t = i / PLACES_PER_SEGMENT;
        const gap = distance(halves({ points }, t)[0].points[3], [x, y]);
        if (gap < best.distance) best = { loop, segment, t, distance: gap };
      }
    });
  });
  return best;
}
