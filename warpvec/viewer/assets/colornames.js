/* Words for colours, and the names of layers that are named after their colour, as "green #2e9b4f". */

import { hslOf } from "viewer/colors.js";
import { isGradient, paintOf } from "viewer/gradients.js";

// A name of flat art: words for a colour and its code.
const NAMED_BY_COLOR = /^[a-z ]+ (#[0-9a-f]{6})(, shaded|, \d+%)?( \(\d+\))?$/;
/** The hue in degrees at which each one ends.
 *
 * @type {[number, string][]} */
const HUES = [
  [15, "red"], [42, "orange"], [66, "yellow"], [165, "green"], [195, "turquoise"], [255, "blue"], [290, "violet"], [340, "pink"],
  [361, "red"],
];
const GREY_SATURATION = 0.12;
// Lightness below which a colour is black or dark, and above which it is light or white.
const [BLACK, DARK, LIGHT, WHITE] = [0.08, 0.3, 0.75, 0.96];
// Dark orange is brown.
const BROWN = 0.4;

/** Returns a colour in words: "dark green". */
export function colorWords(color) {
  const [hue, saturation, lightness] = hslOf(color);
  if (lightness <= BLACK) return "black";
  if (lightness >= WHITE) return "white";
  const shade = lightness < DARK ? "dark " : lightness > LIGHT ? "light " : "";
  if (saturation < GREY_SATURATION) return `${shade}grey`;
  const name = HUES.find(([end]) => hue < end)[1];
  return name === "orange" && lightness < BROWN ? "brown" : `${shade}${name}`;
}

function colorOf(item) {
  const paint = paintOf(item);
  return isGradient(paint) ? paint.stops[0].color : paint;
}

/** Returns the colour of most items of a layer; null without one. */
export function mainColor({ items }) {
  const counts = new Map();
  for (const item of items) {
    const color = colorOf(item);
    if (color) counts.set(color, (counts.get(color) ?? 0) + 1);
  }
  return [...counts].sort((a, b) => b[1] - a[1])[0]?.[0] ?? null;
}

/** Returns a layer that is named after the colour that all its items had as they were read, in layers of one colour each,
 * in painting order: programs of cutters and plotters take a layer for a colour. The names in `taken` are used already. */
export function coloredApart(layer, base, taken) {
  const read = base?.items.filter((item) => item.layer === layer) ?? [];
  const colors = [layer.items, read].map((items) => new Set(items.map(colorOf)));
  if (!NAMED_BY_COLOR.test(layer.name) || colors[0].size < 2 || colors[1].size !== 1) return [layer];
  const parts = [];
  for (const item of layer.items) {
    if (parts.length && colorOf(parts.at(-1)[0]) === colorOf(item)) parts.at(-1).push(item);
    else parts.push([item]);
  }
  return parts.map((items, i) => {
    const color = colorOf(items[0]);
    const name = !color || layer.name.includes(color) ? layer.name : `${colorWords(color)} ${color}`;
    return { ...layer, items, name, id: i ? freeId(`${layer.id || layer.key}-${i + 1}`, taken) : layer.id };
  });
}

function freeId(id, taken) {
  const free = taken.has(id) ? freeId(`${id}b`, taken) : id;
  taken.add(free);
  return free;
}

/** Names the layers that are named after a colour after the one that they have now. `stated` are their names as read. */
export function followColors(drawing) {
  const stated = new Map(drawing.base.layers.map(({ layer, name }) => [layer, name]));
  for (const layer of drawing.layers) {
    const [, code, shades = ""] = layer.name.match(NAMED_BY_COLOR) ?? [];
    const color = mainColor(layer);
    if (!code || !color || code === color) continue;
    const first = stated.get(layer);
    const name = first?.includes(color) ? first : `${colorWords(color)} ${color}${shades}`;
    Object.assign(layer, { name, isNamedByColor: name !== first });
  }
}
