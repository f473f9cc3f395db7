/* Commands that change the selected paths. */

import { multiply, rotation, scaleOf, scaling, translation } from "viewer/basics.js";
import { FORM_NAMES, shapeOfForm, transformForm } from "viewer/forms.js";
import { paintOf, recolored, transformFill, withPaint } from "viewer/gradients.js";
import { nodesOf } from "viewer/nodes.js";
import { boxesMeet, transformShape } from "viewer/paths.js";
import { IDENTITY, LAYER_ID, newLayer } from "viewer/read.js";
import { simplified } from "viewer/simplify.js";

export class Editor {
  constructor(app) {
    this.app = app;
  }

  get items() {
    return [...this.app.selection];
  }

  get layers() {
    return [...new Set(this.items.map(({ layer }) => layer))];
  }

  /** Runs `change` on each selected item as one command. */
  each(label, change, merge = false) {
    if (!this.app.selection.size) return;
    this.app.commands.record(label, this.items, [], () => this.items.forEach(change), merge);
  }

  /** Transforms the selection by keys: those that follow each other are one gesture, and thus one command. */
  nudge(label, matrix) {
    const { app } = this;
    app.begin(label);
    app.gesture?.place(multiply(matrix, app.gesture.matrix));
    app.gesture?.endSoon();
  }

  move(dx, dy) {
    this.nudge("Move", translation(dx, dy));
  }

  scale(factor) {
    if (factor > 0 && factor !== 1) this.nudge("Scale", scaling(factor, factor, ...this.center));
  }

  /** Turns the selection clockwise around the centre of its box. */
  turn(degrees) {
    if (Number.isFinite(degrees) && degrees) this.nudge("Turn", rotation((degrees * Math.PI) / 180, ...this.center));
  }

  get center() {
    const [left, top, right, bottom] = this.app.selectionBox;
    return [(left + right) / 2, (top + bottom) / 2];
  }

  remove() {
    this.rearrange("Delete", (list, chosen) => list.filter((item) => !chosen.has(item)));
    this.app.select([]);
  }

  /** Reorders the selection within its layers; `how` is "front", "back", "raise" or "lower". */
  reorder(how) {
    const labels = { front: "To front", back: "To back", raise: "Raise", lower: "Lower" };
    this.rearrange(labels[how], (list, chosen) => reordered(list, chosen, how));
  }

  rearrange(label, change) {
    const chosen = new Set(this.app.selection);
    if (!chosen.size) return;
    const layers = this.layers;
    this.app.commands.record(label, [], layers, () => {
      for (const layer of layers) layer.items = change(layer.items, chosen);
    });
  }

  /** Puts the selected paths on top of the layer `target`. */
  toLayer(target) {
    const chosen = new Set(this.app.selection);
    const layers = [...new Set([...this.layers, target])];
    if (!chosen.size || (layers.length === 1 && layers[0] === target)) return;
    const moving = this.app.drawing.layers.flatMap(({ items }) => items.filter((item) => chosen.has(item)));
    this.app.commands.record("To layer", moving, layers, () => {
      for (const layer of layers) layer.items = layer.items.filter((item) => !chosen.has(item));
      target.items = [...target.items, ...moving];
      for (const item of moving) item.layer = target;
    });
  }

  /** Makes a layer of the selected paths, above the highest layer of one of them. */
  group() {
    const { app } = this;
    if (!app.selection.size) return;
    const chosen = new Set(app.selection);
    const moving = app.drawing.layers.flatMap(({ items }) => items.filter((item) => chosen.has(item)));
    const layers = this.layers;
    const highest = app.drawing.layers.findLastIndex((layer) => layers.includes(layer));
    const number = freeNumber(app.drawing.layers);
    const names = { id: `layer-${number}`, name: `Layer ${number}` };
    const made = { ...newLayer(null, freeKey(app.drawing.layers)), ...names, items: moving };
    app.commands.record("New layer", moving, layers, () => {
      for (const layer of layers) layer.items = layer.items.filter((item) => !chosen.has(item));
      for (const item of moving) item.layer = made;
      app.drawing.layers = app.drawing.layers.toSpliced(highest + 1, 0, made);
    }, false, app.drawing);
    app.say(`Made ${made.name}`);
  }

  /** Merges the layers of the selected paths into those below them; the lowest one stays. */
  ungroup() {
    const { app } = this;
    const { layers } = app.drawing;
    const gone = this.layers.filter((layer) => layer !== layers[0]);
    if (!gone.length) return;
    const rest = layers.filter((layer) => !gone.includes(layer));
    const moving = gone.flatMap(({ items }) => items);
    app.commands.record("Merge layers", moving, layers, () => {
      layers.forEach((layer, i) => {
        if (!gone.includes(layer)) return;
        const below = layers.slice(0, i).findLast((other) => rest.includes(other));
        below.items = [...below.items, ...layer.items];
        for (const item of layer.items) item.layer = below;
      });
      app.drawing.layers = rest;
    }, false, app.drawing);
  }

  /** Renames the layer of the selected path. One that is named after its generation gets an id of its own. */
  renameLayer(name) {
    const { app } = this;
    const [layer] = this.layers;
    if (!layer || !name || name === layer.name) return;
    const id = LAYER_ID.test(layer.id) ? `layer-${freeNumber(app.drawing.layers)}` : layer.id;
    app.commands.record("Rename layer", [], [layer], () => Object.assign(layer, { id, name, isNamedByColor: false }));
  }

  /** Moves the layer of the selected path up (1) or down (-1) in the order of layers. */
  moveLayer(by) {
    const { app } = this;
    const { layers } = app.drawing;
    const at = layers.indexOf(this.layers[0]);
    if (at < 0 || !layers[at + by]) return;
    app.commands.record("Move layer", [], [layers[at]], () => {
      app.drawing.layers = layers.with(at, layers[at + by]).with(at + by, layers[at]);
    }, false, app.drawing);
  }

  /** Puts the box of the selection: any of {x, y, width, height} in user units. */
  place({ x, y, width, height }) {
    const { app } = this;
    app.endKeys();
    const [left, top, right, bottom] = app.selectionBox;
    if (![left, top, right, bottom].every(Number.isFinite)) return;
    const sx = width > 0 && right > left ? width / (right - left) : 1;
    const sy = height > 0 && bottom > top ? height / (bottom - top) : 1;
    const moved = translation(Number.isFinite(x) ? x - left : 0, Number.isFinite(y) ? y - top : 0);
    const matrix = multiply(moved, scaling(sx, sy, left, top));
    if (matrix.every((value, i) => Math.abs(value - IDENTITY[i]) < 1e-9)) return;
    this.each("Place", (item) => Object.assign(item, transformed(item, matrix)));
  }

  /** Gives the only selected shape another form. */
  reform(form) {
    this.each(`Change ${FORM_NAMES[form.element]}`, (item) => Object.assign(item, { shape: shapeOfForm(form) }));
  }

  /** Changes the width, cap, join or miter limit of the selected strokes. */
  restroke(change) {
    this.each("Stroke", (item) => item.stroke && Object.assign(item, { stroke: { ...item.stroke, ...change } }));
  }

  /** Leaves out nodes of the selected paths, whose outlines may move by `tolerance`. Forms stay forms. */
  simplify(tolerance) {
    const count = () => this.items.reduce((sum, { shape }) => sum + nodesOf(shape).length, 0);
    if (!(tolerance > 0) || !this.items.length) return;
    const before = count();
    const shapes = new Map(this.items.filter(({ shape }) => !shape.form).map((item) => [item, simplified(item.shape, tolerance)]));
    const fewer = [...shapes].filter(([item, shape]) => nodesOf(shape).length < nodesOf(item.shape).length);
    const made = new Map(fewer);
    if (fewer.length) this.each("Simplify", (item) => made.has(item) && Object.assign(item, { shape: made.get(item) }));
    this.app.say(fewer.length ? `${before} nodes became ${count()}` : "No node can be left out within that distance");
  }

  /** Makes paths of the selected forms, whose nodes can be moved one by one. */
  toPaths() {
    this.each("Form to path", (item) => item.shape.form && Object.assign(item, { shape: { ...item.shape, form: null } }));
  }

  /** Adds a path on top of `layer` and selects nothing, so that the next stroke can follow. */
  add(shape, fill, opacity, layer) {
    const item = { layer, shape, fill, opacity, rule: "nonzero", stroke: null, origin: null };
    this.app.commands.record("Brush", [], [layer], () => {
      layer.items = [...layer.items, item];
    });
    return item;
  }
}

/** Returns a key that no layer has. */
function freeKey(layers) {
  return Math.max(...layers.map(({ key }) => key)) + 1;
}

/** Returns a number that neither the id nor the name of a layer has. */
function freeNumber(layers) {
  const taken = new Set(layers.flatMap(({ id, key, name }) => [id || `layer-${key + 1}`, name]));
  let number = layers.length + 1;
  while (taken.has(`layer-${number}`) || taken.has(`Layer ${number}`)) number++;
  return number;
}

export function transformed(item, matrix) {
  const scale = scaleOf(matrix);
  const paint = item.stroke && transformFill(item.stroke.color, matrix);
  const stroke = item.stroke && { ...item.stroke, color: paint, width: item.stroke.width * scale };
  const shape = { ...transformShape(item.shape, matrix), form: transformForm(item.shape.form, matrix) };
  return { shape, fill: transformFill(item.fill, matrix), stroke, softness: (item.softness ?? 0) * scale };
}

/** Returns the paint of an item after a change; `fill` is for the first colour of a gradient, `endFill` for its last.
 *
 * @param {any} item
 * @param {{fill?: any, endFill?: string, opacity?: number, softness?: number}} paint */
export function painted(item, { fill, endFill, opacity, softness }) {
  const { stroke } = item;
  const recoloredPaint = recolored(paintOf(item), fill, endFill);
  const look = { opacity: opacity ?? item.opacity, softness: softness ?? item.softness };
  return { fill: item.fill, stroke, ...withPaint(item, recoloredPaint), ...look };
}

function reordered(list, chosen, how) {
  const picked = list.filter((item) => chosen.has(item));
  const others = list.filter((item) => !chosen.has(item));
  if (how === "front") return [...others, ...picked];
  if (how === "back") return [...picked, ...others];
  return how === "raise" ? raised(list, chosen) : raised(list.toReversed(), chosen).toReversed();
}

/** Moves each chosen item above the next one that it overlaps, or one place up without one; keeps their order. */
function raised(list, chosen) {
  const result = [...list];
  for (let i = result.length - 1; i >= 0; i--) {
    if (!chosen.has(result[i])) continue;
    let target = result.findIndex((other, j) => j > i && !chosen.has(other) && boxesMeet(other.shape.box, result[i].shape.box));
    if (target < 0) target = chosen.has(result[i + 1]) ? i : Math.min(i + 1, result.length - 1);
    result.splice(target, 0, ...result.splice(i, 1));
  }
  return result;
}
