/* Reads a drawing from SVG text that warpvec/svg/sanitize.py reduced. Only numbers, colours and names are taken from
 * the parsed document; none of its elements is ever inserted into the page.
 *
 * A drawing is {width, height, box, title, metadata, settings, background, layers, notes, base}, and has more that belongs
 * to it, which undo restores with it: {facts, past, erased}, see live.js. Its base is what was read, to which edits.js
 * compares. A layer is {key, id, name,
 * generation, items, version, visible}; its version grows with each change. An item is {layer, shape, fill, opacity,
 * rule, stroke, softness, origin}; fill and the colour of the stroke are as in gradients.js, the softness as in blurs.js, and
 * origin is the item as it was read, or null. */

import { multiply, parseTransform, pathDataOf, scaleOf } from "viewer/basics.js";
import { readBlurs } from "viewer/blurs.js";
import { clamp01, hexColor } from "viewer/colors.js";
import { nextVersion } from "viewer/commands.js";
import { formOf } from "viewer/forms.js";
import { GradientReader } from "viewer/gradients.js";
import { parseShape, transformShape } from "viewer/paths.js";
import { NUMBERS } from "viewer/pen.js";

const MAX_LAYERS = 64;
export const LAYER_ID = /^layer-\d+-generation-(\d+)$/;
export const IDENTITY = [1, 0, 0, 1, 0, 0];
const CONTAINERS = new Set(["g", "a", "svg", "switch"]);
const INVISIBLE = new Set(["title", "metadata", "css", "defs", "linearGradient", "radialGradient", "filter"]);
export const PLAIN_STROKE = { cap: "butt", join: "miter", limit: 4 };
const EFFECTS = ["clip-path", "mask", "stroke-dasharray"];

export function readDrawing(text) {
  const parsed = new DOMParser().parseFromString(text, "image/svg+xml");
  const root = parsed.documentElement;
  if (root.localName !== "svg") throw new Error("This is not an SVG file.");
  const size = readSize(root);
  const reader = new Reader(parsed, size.box);
  const metadata = childText(root, "metadata");
  const background = reader.background(root);
  const layers = reader.layers(root);
  const items = layers.flatMap((layer) => layer.items.map(({ origin }) => origin));
  return {
    ...size,
    title: childText(root, "title"),
    metadata,
    settings: parseObject(metadata),
    background,
    layers,
    notes: reader.notes,
    base: { items, layers: layers.map((layer) => ({ layer, name: layer.name })), background, width: size.width, height: size.height },
    facts: { figures: {}, history: [] },
    past: [],
    erased: [],
  };
}

function childText(root, name) {
  const child = [...root.children].find((element) => element.localName === name);
  return child ? child.textContent.trim() : "";
}

function parseObject(text) {
  try {
    const value = JSON.parse(text);
    return value && typeof value === "object" && !Array.isArray(value) ? value : null;
  } catch {
    return null;
  }
}

/** Returns the stated size, and the box of user units that it shows. */
function readSize(root) {
  const [width, height] = ["width", "height"].map((name) => root.getAttribute(name));
  const stated = (root.getAttribute("viewBox")?.match(NUMBERS) ?? []).map(Number);
  if (stated.length === 4 && stated[2] > 0 && stated[3] > 0) return { width, height, box: stated };
  return { width, height, box: [0, 0, parseFloat(width) || 300, parseFloat(height) || 150] };
}

class Reader {
  constructor(parsed, box) {
    this.notes = new Map();
    this.colors = new Map();
    this.styles = collectStyles(parsed);
    this.blurs = readBlurs(parsed);
    this.gradients = new GradientReader(parsed, this, box);
    this.scratch = document.createElement("canvas").getContext("2d");
  }

  /** Returns colour and opacity of the background rectangle of warpvec's files. */
  background(root) {
    const rect = [...root.children].find((element) => element.localName === "rect" && element.id === "background");
    if (!rect) return null;
    const context = this.inherit(rect, initialContext());
    // One with a gradient is an item like others.
    if (context?.fill?.reference) return null;
    this.backgroundElement = rect;
    return context?.fill ? { fill: context.fill, opacity: context.fillOpacity } : null;
  }

  /** Returns a layer for each top-level group, and for each run of other elements between them. */
  layers(root) {
    const layers = [];
    let loose = null;
    const context = this.inherit(root, initialContext());
    for (const element of root.children) {
      if (element === this.backgroundElement) continue;
      const isGroup = element.localName === "g";
      if (isGroup || !loose) layers.push((loose = newLayer(isGroup ? element : null, layers.length)));
      this.walk(element, context, loose);
      if (isGroup) loose = null;
    }
    const filled = layers.filter((layer) => layer.items.length);
    return filled.length > MAX_LAYERS ? [merged(filled)] : filled.length ? filled : [newLayer(null, 0)];
  }

  walk(element, parent, layer) {
    const name = element.localName;
    if (INVISIBLE.has(name)) return;
    const context = this.inherit(element, parent);
    if (!context) return;
    for (const effect of EFFECTS) {
      if ((context.own(effect) ?? "none") !== "none") this.note(`${effect}, not shown`);
    }
    if (CONTAINERS.has(name)) {
      if (context.groupOpacity < 1 && element.children.length > 1) this.note("opacity of a group, given to its paths");
      for (const child of element.children) this.walk(child, context, layer);
      return;
    }
    const d = pathDataOf(element);
    if (d === null) this.note(`<${element.getAttribute("name")}>, left out`);
    else this.addItem(d, context, layer, name === "path", this.form(element, context, parent));
  }

  /** Returns the form of a circle, an ellipse or a rectangle; null for other elements. */
  form(element, context, parent) {
    return formOf(element, context.matrix, parent.matrix === IDENTITY ? element.getAttribute("transform") ?? "" : null);
  }

  addItem(d, context, layer, verbatim, form) {
    const { matrix } = context;
    const moved = matrix !== IDENTITY;
    const plain = parseShape(d);
    const [fill, stroke] = [context.fill, context.stroke].map((paint) => this.placedPaint(paint, plain.box, matrix));
    if (!plain.subpaths.length || (!fill && !stroke)) return;
    const parsed = moved ? transformShape(plain, matrix) : plain;
    const scale = scaleOf(matrix);
    const item = {
      layer,
      shape: verbatim && !moved ? parsed : { ...parsed, d: null, form },
      fill,
      opacity: context.opacity * (fill ? context.fillOpacity : context.strokeOpacity),
      rule: context.rule,
      stroke: stroke && { color: stroke, width: context.strokeWidth * scale, ...context.strokeShape },
      softness: context.softness,
    };
    layer.items.push({ ...item, origin: item });
  }

  /** Returns the inherited style and transform of an element; null if it is not displayed. */
  inherit(element, parent) {
    const own = (name) => this.property(element, name);
    const number = (name, fallback) => (Number.isFinite(parseFloat(own(name))) ? parseFloat(own(name)) : fallback);
    if (own("display") === "none" || own("visibility") === "hidden") {
      this.note("hidden elements, left out");
      return null;
    }
    const groupOpacity = clamp01(number("opacity", 1));
    const transform = element.localName === "svg" ? null : element.getAttribute("transform");
    const matrix = transform ? multiply(parent.matrix, parseTransform(transform)) : parent.matrix;
    return {
      own,
      matrix,
      fill: this.paint(own("fill"), parent.fill),
      stroke: this.paint(own("stroke"), parent.stroke),
      strokeWidth: number("stroke-width", parent.strokeWidth),
      strokeShape: {
        cap: known(own("stroke-linecap"), ["butt", "round", "square"]) ?? parent.strokeShape.cap,
        join: known(own("stroke-linejoin"), ["miter", "round", "bevel"]) ?? parent.strokeShape.join,
        limit: Math.max(number("stroke-miterlimit", parent.strokeShape.limit), 1),
      },
      fillOpacity: clamp01(number("fill-opacity", parent.fillOpacity)),
      strokeOpacity: clamp01(number("stroke-opacity", parent.strokeOpacity)),
      rule: { evenodd: "evenodd", nonzero: "nonzero" }[own("fill-rule")] ?? parent.rule,
      opacity: parent.opacity * groupOpacity,
      groupOpacity,
      softness: Math.hypot(parent.softness, this.blur(own("filter") ?? "none", matrix)),
    };
  }

  /** Returns the standard deviation in user units of the canvas of the blur that a filter is; 0 for other filters. */
  blur(filter, matrix) {
    if (filter === "none") return 0;
    const sigma = this.blurs.get(filter.match(/^url\(\s*["']?#([^"')]+)/)?.[1]);
    if (sigma === undefined) this.note("filter, not shown");
    return (sigma ?? 0) * scaleOf(matrix);
  }

  /** Returns a property from the style attribute, a style sheet or an attribute, in this order. */
  property(element, name) {
    const style = element.getAttribute("css");
    if (style) {
      const found = style.match(new RegExp(`(?:^|;)\\s*${name}\\s*:\\s*([^;!]+)`));
      if (found) return found[1].trim();
    }
    return this.styles.get(element)?.get(name) ?? element.getAttribute(name);
  }

  /** Returns "#rrggbb", null, or {reference} to a gradient, which depends on the shape. */
  paint(value, inherited) {
    if (value === null || value === "inherit" || value === undefined) return inherited;
    if (value === "none" || value === "transparent") return null;
    const reference = value.match(/^url\(\s*["']?#([^"')]+)/);
    if (!reference) return this.color(value) ?? inherited;
    return { reference: reference[1] };
  }

  /** Returns the gradient that a paint refers to, for a shape with this box before `matrix`; other paints as they are. */
  placedPaint(paint, box, matrix) {
    if (!paint?.reference) return paint;
    return this.gradients.fill(paint.reference, box, matrix) ?? this.oneColor(paint);
  }

  /** Returns the middle colour of a paint by reference. */
  oneColor(paint) {
    this.note("gradients and patterns, shown as one colour");
    const stops = this.gradients.stops(this.gradients.chain(paint.reference));
    return stops[Math.floor(stops.length / 2)]?.color ?? "#808080";
  }

  /** Returns "#rrggbb" for any CSS colour, as the browser reads it; null for anything else. */
  color(value) {
    if (!this.colors.has(value)) {
      this.scratch.fillStyle = "#010203";
      this.scratch.fillStyle = value;
      const read = this.scratch.fillStyle;
      const isColor = read !== "#010203" || value.trim().toLowerCase() === "#010203";
      this.colors.set(value, isColor ? opaqueColor(read) : null);
    }
    return this.colors.get(value);
  }

  note(text) {
    this.notes.set(text, (this.notes.get(text) ?? 0) + 1);
  }
}

function initialContext() {
  return {
    matrix: IDENTITY, fill: "#000000", stroke: null, strokeWidth: 1, strokeShape: PLAIN_STROKE, fillOpacity: 1, strokeOpacity: 1,
    rule: "nonzero", opacity: 1, groupOpacity: 1, softness: 0,
  };
}

export function newLayer(group, index) {
  const id = group?.id || "";
  const generation = Number(id.match(LAYER_ID)?.[1] ?? index);
  const label = group?.getAttribute("label") || group?.getAttribute("inkscape:label") || id;
  const name = LAYER_ID.test(id) ? `Pass ${generation + 1}` : withoutNumber(label, id, index + 1) || `Layer ${index + 1}`;
  return { key: index, id, name, generation, items: [], version: nextVersion(), visible: true };
}

/** Returns a label without the number that save.js writes before the name; one that belongs to the name stays. */
function withoutNumber(label, id, number) {
  const [, first, name] = label.match(/^(\d+) (.+)$/s) ?? [];
  const written = name?.replace(/[^a-zA-Z0-9]+/g, "-").replace(/^-+|-+$/g, ""); // the id that warpvec gives the layer
  return name && (Number(first) === number || written === id) ? name : label;
}

function merged(layers) {
  const layer = { ...newLayer(null, 0), name: "All paths" };
  layer.items = layers.flatMap(({ items }) => items);
  for (const item of layer.items) item.layer = item.origin.layer = layer;
  return layer;
}

/** Returns the declarations of the document's style sheets by element, in the order of the sheets. */
function collectStyles(parsed) {
  const styles = new Map();
  for (const element of parsed.querySelectorAll("css")) {
    const sheet = new CSSStyleSheet();
    sheet.replaceSync(element.textContent.replace(/@import[^;]*;?/gi, ""));
    for (const rule of sheet.cssRules) {
      if (!(rule instanceof CSSStyleRule)) continue;
      for (const target of parsed.querySelectorAll(rule.selectorText)) {
        const declared = styles.get(target) ?? new Map();
        for (const name of rule.style) declared.set(name, rule.style.getPropertyValue(name));
        styles.set(target, declared);
      }
    }
  }
  return styles;
}

function opaqueColor(text) {
  if (text[0] === "#") return text;
  const channels = (text.match(NUMBERS) ?? []).slice(0, 3).map(Number);
  return channels.length === 3 ? hexColor(channels) : null;
}

function known(value, choices) {
  return choices.find((choice) => choice === value);
}

