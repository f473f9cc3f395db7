/* Checks of the page's geometry on random shapes, run by test_geometry_in_browser.py. */

import { distance } from "viewer/brush.js";
import { differenceOf, sameState, snapshotOf } from "viewer/changes.js";
import {
  addNode, cornerNodes, halves, moveHandle, moveNodes, nearestPlace, nodesOf, removeNodes, segmentsOf, smoothNodes,
  switchLines, thirds,
} from "viewer/nodes.js";
import { boxContains, parseShape } from "viewer/paths.js";

let seed = 1;

function random() {
  seed = (seed * 1103515245 + 12345) & 0x7fffffff;
  return seed / 0x7fffffff;
}

function below(count) {
  return Math.floor(random() * count);
}

/** Returns path data of one to three loops, with lines, curves, points in one place, and open ends. */
function randomPath() {
  const place = () => `${below(400) / 4 - 10} ${below(400) / 4 - 10}`;
  const commands = [
    () => `L${place()}`, () => `C${place()} ${place()} ${place()}`, () => `S${place()} ${place()}`, () => `Q${place()} ${place()}`,
    () => "h0",
  ];
  const loop = () => `M${place()}${Array.from({ length: below(6) }, () => commands[below(5)]()).join("")}${below(2) ? "z" : ""}`;
  return Array.from({ length: 1 + below(3) }, loop).join("");
}

// Where the last node was added.
let added = null;

const CHANGES = {
  move: (shape, chosen) => moveNodes(shape, chosen, random() * 20 - 10, random() * 20 - 10),
  handle: (shape, [index]) => {
    const side = below(2) ? "before" : "after";
    return nodesOf(shape)[index][side] ? moveHandle(shape, index, side, random() * 50, random() * 50) : shape;
  },
  smooth: smoothNodes,
  corner: cornerNodes,
  lines: switchLines,
  remove: removeNodes,
  add: (shape) => {
    added = nearestPlace(shape, random() * 50, random() * 50);
    return added.loop < 0 ? shape : addNode(shape, added.loop, added.segment, added.t);
  },
};

/** Returns what is wrong with a shape after a change; an empty text if nothing is. */
function fault(shape) {
  for (const { points, closed, kinds } of shape.subpaths) {
    const count = (points.length - 2) / 6;
    if (!Number.isInteger(count) || (kinds && kinds.length !== count)) return "wrong number of points";
    if (!points.every(Number.isFinite)) return "a number that is none";
    if (closed && (points[0] !== points.at(-2) || points[1] !== points.at(-1))) return "an open loop";
    const lines = (kinds ?? []).flatMap((kind, i) => (kind === "l" ? [i] : []));
    if (lines.some((i) => bend(points.slice(6 * i, 6 * i + 8)) > 1e-6)) return "a bent line";
  }
  return "";
}

/** Returns how far the handles of a segment lie from its thirds. */
function bend([x, y, x1, y1, x2, y2, endX, endY]) {
  const at = thirds(x, y, endX, endY);
  return Math.max(...[x1, y1, x2, y2].map((value, i) => Math.abs(value - at[i])));
}

function checkNodes(rounds) {
  const faults = [];
  for (let round = 0; round < rounds; round++) {
    let shape = parseShape(randomPath());
    for (let i = 0; i < 6 && nodesOf(shape).length; i++) {
      const name = Object.keys(CHANGES)[below(7)];
      const chosen = new Set([below(nodesOf(shape).length), below(nodesOf(shape).length)]);
      const before = JSON.stringify(shape.subpaths.map(({ points }) => [...points]));
      const changed = CHANGES[name](shape, chosen);
      if (JSON.stringify(shape.subpaths.map(({ points }) => [...points])) !== before) faults.push(`${name}: changes its input`);
      if (fault(changed)) faults.push(`${name}: ${fault(changed)}`);
      if (changed !== shape && name === "add") faults.push(...strays(changed, shape, added));
      shape = changed;
    }
  }
  return faults;
}

/** Adding a node must leave the outline where it is: says which points of the divided segment have moved. */
function strays(shape, original, { loop, segment, t }) {
  const whole = segmentsOf(original.subpaths[loop])[segment];
  const pieces = segmentsOf(shape.subpaths[loop]).slice(segment, segment + 2);
  const at = (piece, share) => halves(piece, share)[0].points[3];
  return [0.1, 0.5, 0.9].flatMap((share) => {
    const places = [share * t, t + share * (1 - t)];
    const gaps = places.map((place, i) => distance(at(pieces[i], share), at(whole, place)));
    return Math.max(...gaps) > 1e-6 ? [`add: moves the outline by ${Math.max(...gaps)}`] : [];
  });
}

/** The box of a difference must contain all that was added, removed, changed or moved past another. */
function checkDifferences(rounds) {
  const faults = [];
  const item = (id) => ({ id, shape: { box: [id, 0, id + 1, 1] }, fill: "#000000", opacity: 1, stroke: null });
  for (let round = 0; round < rounds; round++) {
    const items = Array.from({ length: below(12) }, (_, i) => item(i));
    const before = snapshotOf(items);
    const after = [...items];
    const touched = [];
    for (let i = below(3); i > 0; i--) {
      const at = below(after.length);
      const kind = below(3);
      if (kind === 0 && after[at]) touched.push(...after.splice(at, 1));
      else if (kind === 1) touched.push((after.splice(at, 0, item(50 + i)), after[at]));
      else if (after[at]) touched.push(Object.assign(after[at], { opacity: after[at].opacity / 2 }));
    }
    if (!touched.length && after.length > 1) after.push(...after.splice(0, 1 + below(after.length - 1)));
    const box = differenceOf(before, snapshotOf(after));
    const shown = touched.filter((one) => after.includes(one) || items.includes(one));
    const lost = shown.filter(({ shape }) => !box || !boxContains(box, shape.box));
    faults.push(...lost.map(({ id }) => `difference: leaves out ${id}`));
    const isSame = after.length === items.length && after.every((one, i) => one === items[i] && sameState(one, before.states[i]));
    if (isSame !== (box === null)) faults.push(`difference: ${box} for ${isSame ? "nothing" : "a change"}`);
  }
  return faults;
}

Object.assign(window, { checkNodes, checkDifferences });
