/* What the user has changed of a drawing, as a list that can be applied to another drawing of the same picture.
 *
 * Each item knows its origin, the item as it was read, and a drawing knows all its origins (`base`). An edit is {kind, ...}:
 *   color       {from, to, uses}         a colour that has been replaced in all its uses
 *   background  {to}
 *   size        {width, height}          as the file states them
 *   change      {before, after, matrix}  another paint, place or outline; `matrix` if the shape has only been moved, and
 *                                        `erased` has the areas that were taken out of it
 *   delete      {before}
 *   add         {after, layerName}
 *   order       {before, below}          the item lies on `below` now, or at the bottom
 *   layer       {name, to}               another name
 *   layers      {}                       layers were made, merged or moved
 *   opened      {}                       all that was done before the file was saved, which is not known apart from it */

import { multiply } from "viewer/basics.js";
import { longestRise, sameState } from "viewer/changes.js";
import { transformed } from "viewer/edit.js";
import { isGradient, paintOf, withPaint } from "viewer/gradients.js";
import { counterparts, holdsOthers, overlapOf } from "viewer/likeness.js";
import { affineBetween, followNodes } from "viewer/movement.js";
import { inverse } from "viewer/planes.js";
import { IDENTITY, LAYER_ID } from "viewer/read.js";

// An outline of which the nodes have been edited replaces one that covers the same place to this share.
const SAME_OUTLINE = 0.85;
// Widths, and places of gradients in a shape, are the same if they differ by less than this share.
const SAME_LENGTH = 1e-3;

export function itemsOf({ layers }) {
  return layers.flatMap(({ items }) => items);
}

/** Tells whether a drawing is as it was read. */
export function isPristine(drawing) {
  const { base } = drawing;
  const items = itemsOf(drawing);
  if (drawing.width !== base.width || drawing.height !== base.height) return false;
  if (drawing.background !== base.background || items.length !== base.items.length) return false;
  if (!sameLayers(drawing) || drawing.layers.some(({ name }, i) => name !== base.layers[i].name)) return false;
  return items.every((item, i) => item.origin === base.items[i] && sameState(item, item.origin) && item.layer === item.origin.layer);
}

function sameLayers({ layers, base }) {
  return layers.length === base.layers.length && layers.every((layer, i) => layer === base.layers[i].layer);
}

/** Returns the items as they were read that the drawing does not have any more. */
export function deletedItems(drawing) {
  const present = new Set(itemsOf(drawing).map(({ origin }) => origin));
  return drawing.base.items.filter((origin) => !present.has(origin));
}

/** Returns all edits of a drawing, those from before it was fitted again first. */
export function editsOf(drawing) {
  const { base } = drawing;
  const items = itemsOf(drawing);
  const colors = replacedColors(items);
  const changed = items.filter((item) => item.origin && !sameState(item, item.origin));
  const changes = changed.flatMap((item) => changeOf(item, colors, base));
  const added = items.filter(({ origin }) => !origin);
  return [
    ...(drawing.past ?? []),
    ...[...colors].map(([from, to]) => ({ kind: "color", from, to, uses: base.items.filter((origin) => paintOf(origin) === from) })),
    ...(drawing.background === base.background ? [] : [{ kind: "background", to: drawing.background }]),
    ...(drawing.width === base.width ? [] : [{ kind: "size", width: drawing.width, height: drawing.height }]),
    ...changes,
    ...deletedItems(drawing).map((before) => ({ kind: "delete", before, isWhole: !holdsOthers(before, base.items) })),
    ...added.map((after) => ({ kind: "add", after: frozen(after), layerName: after.layer.name })),
    ...orderEdits(drawing),
    ...layerEdits(drawing),
  ];
}

function frozen({ layer, shape, fill, opacity, rule, stroke, softness }) {
  return { layer, shape, fill, opacity, rule, stroke, softness, origin: null };
}

/** Returns the colours, of fills alone, of which every use has become the same other one. */
function replacedColors(items) {
  const targets = new Map();
  for (const item of items) {
    if (!item.origin) continue;
    const [from, to] = [paintOf(item.origin), paintOf(item)];
    if (isGradient(from) || isGradient(to) || !from) continue;
    targets.set(from, new Set([...(targets.get(from) ?? []), to]));
  }
  const replaced = [...targets].filter(([from, found]) => found.size === 1 && !found.has(from));
  return new Map(replaced.map(([from, found]) => [from, [...found][0]]));
}

/** Returns the change of an item beyond that of its colour everywhere. What only moves with the shape is no change. */
function changeOf(item, colors, base) {
  const { origin } = item;
  const isMoved = item.shape !== origin.shape;
  const matrix = isMoved ? affineBetween(origin.shape, item.shape) : null;
  const carried = matrix ? { ...origin, ...transformed(origin, matrix) } : origin;
  const isReplaced = colors.has(paintOf(origin)) && colors.get(paintOf(origin)) === paintOf(item);
  const made = {
    isMoved,
    isPainted: !isReplaced && !hasSamePaint(item, carried),
    isFaded: item.opacity !== origin.opacity,
    isDrawn: !hasSameStroke(item, carried),
    isSoftened: !isNear(item.softness ?? 0, carried.softness ?? 0),
  };
  if (!Object.values(made).some(Boolean)) return [];
  const isWhole = !holdsOthers(origin, base.items);
  return [{ kind: "change", before: frozen(origin), after: frozen(item), matrix, ...made, isWhole, erased: item.erased }];
}

function isNear(a, b, size = Math.max(Math.abs(a), Math.abs(b))) {
  return Math.abs(a - b) <= SAME_LENGTH * size;
}

/** Tells whether two items have the same colours in the same places. */
function hasSamePaint(item, other) {
  const [paint, old] = [paintOf(item), paintOf(other)];
  if (Boolean(item.fill) !== Boolean(other.fill) || Boolean(item.stroke) !== Boolean(other.stroke)) return false;
  if (!isGradient(paint) || !isGradient(old)) return paint === old;
  if (paint.kind !== old.kind || JSON.stringify(paint.stops) !== JSON.stringify(old.stops)) return false;
  const { box } = item.shape;
  const size = Math.max(box[2] - box[0], box[3] - box[1]);
  const [matrix, oldMatrix] = [paint.matrix ?? IDENTITY, old.matrix ?? IDENTITY];
  const isPlaced = paint.numbers.every((value, i) => isNear(value, old.numbers[i], size));
  return isPlaced && matrix.every((value, i) => isNear(value, oldMatrix[i], i < 4 ? 1 : size));
}

function hasSameStroke({ stroke }, { stroke: old }) {
  if (!stroke || !old) return !stroke === !old;
  const isAlike = ["cap", "join", "limit"].every((name) => stroke[name] === old[name]);
  return isAlike && isNear(stroke.width, old.width);
}

/** Returns an edit for each item that lies elsewhere in the order than when it was read. */
function orderEdits(drawing) {
  const items = itemsOf(drawing).filter(({ origin }) => origin);
  const places = new Map(drawing.base.items.map((origin, i) => [origin, i]));
  const inOrder = longestRise(items.map(({ origin }) => places.get(origin)));
  const moved = items.filter((_, i) => !inOrder.has(i));
  const below = new Map(items.map((item, i) => [item, items[i - 1]?.origin ?? null]));
  return moved.map((item) => ({ kind: "order", before: frozen(item.origin), below: below.get(item) }));
}

function layerEdits(drawing) {
  const { layers, base } = drawing;
  const isArranged = !sameLayers(drawing) || itemsOf(drawing).some((item) => item.origin && item.layer !== item.origin.layer);
  const renamed = base.layers.filter(({ layer, name }) => layers.includes(layer) && layer.name !== name && !layer.isNamedByColor);
  return [
    ...renamed.map(({ layer, name }) => ({ kind: "layer", name, to: layer.name })),
    ...(isArranged ? [{ kind: "layers" }] : []),
  ];
}

/** Applies edits to another drawing, as it was read, in place. Returns those for which it has no place.
 *
 * @param {any[]} edits
 * @param {any} drawing
 * @param {number[]} matrix from the user units of the edits to those of the drawing
 * @param {Map<number, any[]>} left what is left of items after erasing, by their place; see `erasing.js` */
export function applyEdits(edits, drawing, matrix, left = new Map()) {
  const placed = edits.map((edit) => inUnits(edit, matrix));
  const found = new Finder(drawing, left);
  const order = ["opened", "color", "background", "size", "change", "delete", "order", "layer", "layers", "add"];
  const sorted = placed.map((edit, i) => ({ edit, i })).sort((a, b) => order.indexOf(a.edit.kind) - order.indexOf(b.edit.kind));
  return sorted.filter(({ edit }) => !APPLY[edit.kind](edit, drawing, found)).map(({ i }) => edits[i]);
}

function inUnits(edit, matrix) {
  if (matrix.every((value, i) => value === IDENTITY[i])) return edit;
  const moved = (item) => item && { ...item, ...transformed(item, matrix) };
  const own = edit.matrix && multiply(multiply(matrix, edit.matrix), inverse(matrix));
  const [before, after, below] = [edit.before, edit.after, edit.below].map(moved);
  return { ...edit, before, after, below, uses: edit.uses?.map(moved), matrix: own };
}

/** Finds the items of a new drawing that an item of the old one was, as they were read. */
class Finder {
  constructor(drawing, left) {
    this.left = left;
    this.items = itemsOf(drawing);
    this.origins = drawing.base.items;
    this.known = new Map();
  }

  of(before, isWhole) {
    if (!this.known.has(before)) {
      const origins = counterparts(before, this.origins, { withPieces: isWhole });
      this.known.set(before, origins.map((origin) => this.items[this.origins.indexOf(origin)]));
    }
    return this.known.get(before);
  }

  /** Returns what erasing leaves of an item; undefined if nothing was erased of it. */
  leftOf({ origin }) {
    return this.left.get(this.origins.indexOf(origin));
  }
}

const APPLY = {
  color: ({ from, to, uses }, drawing, found) => {
    const same = itemsOf(drawing).filter(({ origin }) => paintOf(origin) === from);
    const items = same.length ? same : uses.flatMap((use) => found.of(use, true));
    for (const item of items) Object.assign(item, withPaint(item, to));
    return items.length > 0;
  },
  background: ({ to }, drawing) => {
    drawing.background = to;
    return true;
  },
  size: ({ width, height }, drawing) => {
    Object.assign(drawing, { width, height });
    return true;
  },
  change: (edit, drawing, found) => {
    // What is erased of a photo is not drawn again.
    if (edit.erased && isOfPhoto(drawing)) return true;
    const items = found.of(edit.before, edit.isWhole);
    if (edit.erased && items.some((item) => found.leftOf(item))) {
      for (const item of items) leaveRest(edit, item, found.leftOf(item) ?? [item]);
      return true;
    }
    return items.length > 0 && items.filter((item, i) => changeItem(edit, item, i === 0)).length > 0;
  },
  delete: ({ before, isWhole }, drawing, found) => {
    // Without a counterpart it has gone already.
    const gone = new Set(found.of(before, isWhole));
    for (const layer of drawing.layers) layer.items = layer.items.filter((item) => !gone.has(item));
    return true;
  },
  add: ({ after, layerName }, drawing) => {
    const layer = drawing.layers.find(({ name }) => name === layerName) ?? drawing.layers.at(-1);
    layer.items = [...layer.items, { ...after, layer }];
    return true;
  },
  order: ({ before, below }, drawing, found) => {
    const [item] = found.of(before, false);
    const [under] = below ? found.of(below, false) : [null];
    if (!item || (below && !under) || item.layer !== (under ?? item).layer) return false;
    const { layer } = item;
    const rest = layer.items.filter((other) => other !== item);
    layer.items = rest.toSpliced(under ? rest.indexOf(under) + 1 : 0, 0, item);
    return true;
  },
  layer: ({ name, to }, drawing) => {
    const layer = drawing.layers.find((other) => other.name === name);
    if (layer) layer.name = to;
    return Boolean(layer);
  },
  layers: () => false,
  opened: () => false,
};

/** Tells whether a drawing is one of a photo, by its layers. */
export function isOfPhoto({ layers }) {
  return layers.every(({ id }) => LAYER_ID.test(id));
}

/** Replaces an item by what erasing leaves of it. */
function leaveRest(edit, item, [rest]) {
  if (!rest) item.layer.items = item.layer.items.filter((other) => other !== item);
  else {
    Object.assign(item, { shape: rest.shape, rule: rest.rule, erased: rest.erased });
    changeItem({ ...edit, isMoved: false }, item, false);
  }
}

function changeItem(edit, item, isFirst) {
  const { after, before, matrix } = edit;
  if (edit.isMoved) {
    if (matrix) Object.assign(item, transformed(item, matrix));
    else if (!isFirst) return false;
    else {
      const shape = followNodes(before.shape, after.shape, item.shape);
      if (!shape && overlapOf(before, item.origin) < SAME_OUTLINE) return false;
      item.shape = shape ?? after.shape;
    }
  }
  if (edit.isPainted) Object.assign(item, withPaint(item, paintOf(after)));
  if (edit.isFaded) item.opacity = after.opacity;
  if (edit.isSoftened) item.softness = after.softness;
  if (edit.isDrawn && item.stroke && after.stroke) {
    const { cap, join, limit, width } = after.stroke;
    item.stroke = { ...item.stroke, cap, join, limit, width };
  }
  return true;
}
