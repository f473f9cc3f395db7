/* Simplifies shapes: neighbouring curves become one as long as the outline stays within a tolerance of what it was. */

import { distance } from "viewer/brush.js";
import { halves, joined, joinedPieces, segmentsOf, thirds } from "viewer/nodes.js";
import { makeShape } from "viewer/paths.js";

// Points of a curve at which it is compared.
const SAMPLES = 16;

/** Returns a shape of fewer nodes whose outline is at most `tolerance` from that of `shape`, in user units. */
export function simplified(shape, tolerance) {
  const subpaths = shape.subpaths.map((subpath) => simplifiedLoop(subpath, tolerance));
  return { ...makeShape(subpaths), corners: null };
}

function simplifiedLoop({ points, closed, kinds }, tolerance) {
  const pieces = segmentsOf({ points, kinds }).map((piece) => ({ ...piece, covers: samplesOf(piece) }));
  const fewest = closed ? 2 : 1;
  while (pieces.length > fewest) {
    const count = closed ? pieces.length : pieces.length - 1;
    const tried = Array.from({ length: count }, (_, i) => trial(pieces, i));
    const best = tried.reduce((a, b) => (b.error < a.error ? b : a));
    if (best.error > tolerance) break;
    if (best.at === pieces.length - 1) {
      pieces.shift();
      pieces.splice(-1, 1, best.piece);
    } else pieces.splice(best.at, 2, best.piece);
  }
  return joined(pieces, closed);
}

/** Returns the piece that a piece and the next one would become, and how far it is from the outline that it covers. */
function trial(pieces, at) {
  const [first, second] = [pieces[at], pieces[(at + 1) % pieces.length]];
  if (first.next === second) return { ...first.trial, at };
  const piece = straight(joinedPieces(first, second));
  const covers = [...first.covers, ...second.covers];
  const own = samplesOf(piece);
  const gaps = [farthest(covers, own), farthest(own, covers)];
  first.next = second;
  first.trial = { piece: { ...piece, covers }, error: Math.max(...gaps) };
  return { ...first.trial, at };
}

/** Returns a line with its handles at its thirds; curves as they are. */
function straight({ points, kind }) {
  if (kind !== "l") return { points, kind };
  const [x, y, u, v] = thirds(...points[0], ...points[3]);
  return { points: [points[0], [x, y], [u, v], points[3]], kind };
}

/** Returns the largest distance of one row of points from a line through others. */
function farthest(points, line) {
  return Math.max(...points.map((point) => Math.min(...line.slice(1).map((end, i) => distanceToLine(point, line[i], end)))));
}

function distanceToLine([x, y], [ax, ay], [bx, by]) {
  const [dx, dy] = [bx - ax, by - ay];
  const squared = dx * dx + dy * dy;
  const share = squared ? Math.min(Math.max(((x - ax) * dx + (y - ay) * dy) / squared, 0), 1) : 0;
  return distance([x, y], [ax + share * dx, ay + share * dy]);
}

function samplesOf({ points }) {
  return Array.from({ length: SAMPLES + 1 }, (_, i) => halves({ points }, i / SAMPLES)[0].points[3]);
}
