/* Gradient paints. A fill, or the colour of a stroke, is "#rrggbb", null, or a gradient, which is never changed, so that
 * undo can keep it:
 * {kind, numbers, matrix, spread, stops, onCanvas}. Numbers are x1, y1, x2, y2 of a "linear" one, and cx, cy, r, fx, fy of
 * a "radial" one, in user units; a radial one may have a matrix [a, b, c, d, e, f] that makes it an ellipse. A stop is
 * {offset, color, opacity}; there are two at least, in rising order. `onCanvas` is made when it is first drawn. */

import { multiply, parseTransform, scaleOf } from "viewer/basics.js";
import { clamp01, shortColor, writeOpacity } from "viewer/colors.js";
import { formatNumber } from "viewer/paths.js";

const GRADIENT_SIDES = { linear: ["x1", "y1", "x2", "y2"], radial: ["cx", "cy", "r", "fx", "fy"] };
const LINEAR_DEFAULTS = { x1: "0%", y1: "0%", x2: "100%", y2: "0%" };
const RADIAL_DEFAULTS = { cx: "50%", cy: "50%", r: "50%" };
const MAX_REFERENCES = 16;
// The `id` that the file states for a gradient, which it keeps as long as it is not changed.
const STATED_IDS = new WeakMap();
const SAFE_ID = /^[A-Za-z_][\w.-]*$/;
// Names of one hash that are tried: layers have others, and equal hashes are rare.
const NAMES_TRIED = 8;

/** Returns the `id` that the file states for a gradient; undefined for none. */
export function statedIdOf(paint) {
  return STATED_IDS.get(paint);
}

export function keepStatedId(paint, id) {
  STATED_IDS.set(paint, id);
}

export function isGradient(fill) {
  return typeof fill === "object" && fill !== null;
}

/** Returns the paint that the page edits: the fill, or that of the stroke of a path without one. */
export function paintOf({ fill, stroke }) {
  return fill ?? stroke?.color ?? null;
}

/** Returns what to change of an item to give it another paint. */
export function withPaint({ fill, stroke }, paint) {
  return fill || !stroke ? { fill: paint } : { stroke: { ...stroke, color: paint } };
}

/** Returns the first colour of a fill, and the last one. */
export function endColors(fill) {
  return isGradient(fill) ? [fill.stops[0].color, fill.stops.at(-1).color] : [fill, fill];
}

/** Returns the fill with its first colour replaced by `start` and its last one by `end`, where these are given. */
export function recolored(fill, start, end) {
  if (!isGradient(fill)) return fill && start ? start : fill;
  const stops = fill.stops.map((stop) => ({ ...stop }));
  if (start) stops[0].color = start;
  if (end) stops.at(-1).color = end;
  return { ...fill, stops, onCanvas: null };
}

/** Returns the fill moved with its shape by `matrix`. */
export function transformFill(fill, matrix) {
  if (!isGradient(fill)) return fill;
  const placed = fill.kind === "linear" ? transformLinear(fill.numbers, matrix) : transformRadial(fill, matrix);
  return { ...fill, ...placed, onCanvas: null };
}

/** Moves the start, and turns the direction so that lines of equal colour stay lines of equal colour. */
function transformLinear([x1, y1, x2, y2], matrix) {
  const [a, b, c, d] = matrix;
  const [dx, dy] = [x2 - x1, y2 - y1];
  const [nx, ny] = [d * dx - b * dy, a * dy - c * dx];
  const length = ((a * d - b * c) * (dx * dx + dy * dy)) / (nx * nx + ny * ny);
  const [x, y] = transformPoint(matrix, x1, y1);
  // A gradient of no length stays one.
  return { numbers: Number.isFinite(length) ? [x, y, x + length * nx, y + length * ny] : [x, y, x, y] };
}

function transformRadial({ numbers, matrix: own }, matrix) {
  const whole = own ? multiply(matrix, own) : matrix;
  const [a, b, c, d] = whole;
  const scale = scaleOf(whole);
  const error = Math.max(Math.abs(Math.hypot(a, b) - scale), Math.abs(Math.hypot(c, d) - scale));
  if (error > 1e-6 * scale) return { numbers, matrix: whole };
  const [cx, cy, r, fx, fy] = numbers;
  return { numbers: [...transformPoint(whole, cx, cy), scale * r, ...transformPoint(whole, fx, fy)], matrix: null };
}

export function transformPoint([a, b, c, d, e, f], x, y) {
  return [a * x + c * y + e, b * x + d * y + f];
}

/** Reads the gradients of a document; `reader` knows styles and colours. */
export class GradientReader {
  constructor(parsed, reader, box) {
    this.elements = new Map([...parsed.querySelectorAll("linearGradient, radialGradient")].map((g) => [g.id, g]));
    this.reader = reader;
    this.canvas = box;
  }

  /** Returns the gradient `id`, or its only colour, for a shape with this bounding box before `matrix`; null without it. */
  fill(id, box, matrix) {
    const chain = this.chain(id);
    const stops = this.stops(chain);
    if (!stops.length) return null;
    if (stops.length === 1) return stops[0].color;
    const own = (name) => chain.find((element) => element.hasAttribute(name))?.getAttribute(name);
    const kind = chain[0].localName === "linearGradient" ? "linear" : "radial";
    const inBox = own("gradientUnits") !== "userSpaceOnUse";
    if (inBox && !(box[2] > box[0] && box[3] > box[1])) return null;
    const spread = own("spreadMethod") ?? "pad";
    if (spread !== "pad") this.reader.note("gradients that repeat, shown without repeating");
    const numbers = this.numbers(kind, own, inBox ? [0, 0, 1, 1] : this.canvas);
    let placed = parseTransform(own("gradientTransform") ?? "");
    if (inBox) placed = multiply([box[2] - box[0], 0, 0, box[3] - box[1], box[0], box[1]], placed);
    const paint = transformFill({ kind, numbers, matrix: null, spread, stops, onCanvas: null }, multiply(matrix, placed));
    keepStatedId(paint, id);
    return paint;
  }

  /** Returns the gradient and those that it takes missing attributes from. */
  chain(id) {
    const chain = [];
    let element = this.elements.get(id);
    while (element && !chain.includes(element) && chain.length < MAX_REFERENCES) {
      chain.push(element);
      element = this.elements.get(element.getAttribute("template")?.slice(1));
    }
    return chain;
  }

  stops(chain) {
    const holder = chain.find((element) => [...element.children].some((child) => child.localName === "stop"));
    let last = 0;
    return [...(holder?.children ?? [])].filter((child) => child.localName === "stop").map((stop) => {
      const offset = Math.max(clamp01(lengthOf(this.reader.property(stop, "offset") ?? "0", 1)), last);
      const opacity = parseFloat(this.reader.property(stop, "stop-opacity") ?? "1");
      const color = this.reader.color(this.reader.property(stop, "stop-color") ?? "") ?? "#000000";
      last = offset;
      return { offset, color, opacity: Number.isFinite(opacity) ? clamp01(opacity) : 1 };
    });
  }

  /** Returns the numbers in units of a box [x, y, width, height], of which percentages are parts. */
  numbers(kind, own, [, , width, height]) {
    const whole = { x: width, y: height, r: Math.hypot(width, height) / Math.SQRT2 };
    const defaults = kind === "linear" ? LINEAR_DEFAULTS : RADIAL_DEFAULTS;
    const read = (name, fallback) => lengthOf(own(name) ?? fallback, name === "r" ? whole.r : whole[name.match(/[xy]/)[0]]);
    const numbers = Object.entries(defaults).map(([name, fallback]) => read(name, fallback));
    if (kind === "linear") return numbers;
    const [fx, fy] = ["fx", "fy"].map((name, i) => (own(name) === undefined ? numbers[i] : read(name)));
    return [...numbers, fx, fy];
  }
}

/** Returns a number, or a percentage of `whole`. */
function lengthOf(text, whole) {
  const value = parseFloat(text) || 0;
  return text.trim().endsWith("%") ? (value / 100) * whole : value;
}

/** Names the gradients of the `items` for a file: equal ones share a name. Returns their elements by name and paint.
 *
 * A name is the one that was read, or follows from the gradient, so that files on one web page share one only with an
 * equal gradient. */
export function nameGradients(items, taken, decimals) {
  const used = new Set(taken);
  const byText = new Map();
  const names = new Map();
  for (const paint of items.flatMap(({ fill, stroke }) => [fill, stroke?.color])) {
    if (!isGradient(paint) || names.has(paint)) continue;
    const text = writeGradient(paint, decimals);
    if (!byText.has(text)) {
      const name = [STATED_IDS.get(paint), ...contentNames(text)].find((each) => SAFE_ID.test(each ?? "") && !used.has(each));
      byText.set(text, name);
      used.add(name);
    }
    names.set(paint, byText.get(text));
  }
  const lines = [...byText].map(([text, name]) => text.replace(" ", ` id="${name}" `));
  return { names, lines };
}

/** Returns names that follow from a text: by its hash (FNV-1a), then with a number after it. */
function contentNames(text) {
  let hash = 0x811c9dc5;
  for (const byte of new TextEncoder().encode(text)) hash = Math.imul(hash ^ byte, 0x01000193) >>> 0;
  const name = `g${hash.toString(16).padStart(8, "0")}`;
  return [name, ...Array.from({ length: NAMES_TRIED }, (_, i) => `${name}-${i + 2}`)];
}

/** Returns an item whose gradients state its opacity by their stops: some programs ignore that beside a gradient. */
export function withOpacityInStops(item) {
  const { fill, stroke, opacity } = item;
  const paints = [fill, stroke?.color].filter(Boolean);
  if (opacity === 1 || !paints.length || !paints.every(isGradient)) return item;
  return { ...item, fill: faded(fill, opacity), stroke: stroke && { ...stroke, color: faded(stroke.color, opacity) }, opacity: 1 };
}

function faded(paint, opacity) {
  return paint && { ...paint, stops: paint.stops.map((stop) => ({ ...stop, opacity: stop.opacity * opacity })) };
}

/** Returns a radial gradient with a matrix about its own centre: programs that ignore the matrix show it in its place. */
function aboutCenter(paint) {
  const { numbers, matrix } = paint;
  const [a, b, c, d] = matrix ?? [];
  const isCentered = numbers[3] === numbers[0] && numbers[4] === numbers[1];
  const [x, y] = matrix && isCentered ? transformPoint(matrix, numbers[0], numbers[1]) : numbers;
  const radius = numbers[2] * Math.hypot(a, b);
  if (!(radius > 0) || Math.hypot(x - numbers[0], y - numbers[1]) < 1e-3) return paint;
  const columns = [a, b, c, d].map((value) => (value * numbers[2]) / radius);
  const moved = [x - columns[0] * x - columns[2] * y, y - columns[1] * x - columns[3] * y];
  return { ...paint, numbers: [x, y, radius, x, y], matrix: [...columns, ...moved] };
}

function writeGradient(paint, decimals) {
  const { kind, numbers, matrix, spread, stops } = aboutCenter(paint);
  const element = `${kind}Gradient`;
  const isCentered = kind === "radial" && numbers[3] === numbers[0] && numbers[4] === numbers[1];
  const sides = GRADIENT_SIDES[kind].slice(0, isCentered ? 3 : undefined);
  const attributes = ['gradientUnits="userSpaceOnUse"', ...sides.map((name, i) => `${name}="${formatNumber(numbers[i], decimals)}"`)];
  if (matrix) attributes.push(`gradientTransform="matrix(${matrix.map((value) => formatNumber(value, 9)).join(" ")})"`);
  if (["reflect", "repeat"].includes(spread)) attributes.push(`spreadMethod="${spread}"`);
  return `<${element} ${attributes.join(" ")}>${stops.map(writeStop).join("")}</${element}>`;
}

function writeStop({ offset, color, opacity }) {
  return `<stop offset="${formatNumber(offset, 4)}" stop-color="${shortColor(color)}"${writeOpacity("stop-opacity", opacity)}/>`;
}
