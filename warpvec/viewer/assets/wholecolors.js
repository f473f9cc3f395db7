/* Changes of the colours of the whole drawing: without its background, and in the colours of a brand alone. */

import { counted } from "viewer/charts.js";
import { channelsOf } from "viewer/colors.js";
import { itemsOf } from "viewer/edits.js";
import { colorsOf, withColors } from "viewer/palette.js";
import { boxContains } from "viewer/paths.js";

// The shape of a background reaches the edges of the canvas to this share of its sides.
const EDGE = 0.005;

/** Removes the background of the file, or the lowest shape if it fills the whole canvas. */
export function removeBackground(app) {
  const { drawing } = app;
  const [x, y, width, height] = drawing.box;
  const inner = [x + EDGE * width, y + EDGE * height, x + (1 - EDGE) * width, y + (1 - EDGE) * height];
  const lowest = itemsOf(drawing)[0];
  const isWhole = lowest && isRectangle(lowest) && boxContains(lowest.shape.box, inner);
  if (!drawing.background && !isWhole) {
    app.say("There is no background: the canvas is clear");
    return;
  }
  app.commands.record("Remove background", [], isWhole ? [lowest.layer] : [], () => {
    drawing.background = null;
    if (isWhole) lowest.layer.items = lowest.layer.items.filter((item) => item !== lowest);
  }, false, drawing);
  app.say("Background removed");
}

/** Tells whether an item has no more corners than a rectangle. */
function isRectangle({ shape, fill }) {
  return Boolean(fill) && shape.subpaths.length === 1 && shape.subpaths[0].points.length <= 26;
}

/** Gives each colour of the drawing the colour of `text` that looks most like it; says if the text has none. */
export function useBrand(app, text) {
  const { drawing } = app;
  const found = [...text.matchAll(/#?\b([0-9a-f]{6}|[0-9a-f]{3})\b/gi)].map(([, digits]) => digits.toLowerCase());
  const brand = found.map((digits) => `#${digits.length === 3 ? digits.replace(/./g, "$&$&") : digits}`);
  if (!brand.length) {
    app.say("Give codes of colours, for example #1c64d1 #ffffff");
    return;
  }
  const items = itemsOf(drawing).filter(({ layer }) => !layer.isLocked);
  const used = new Set([...items.flatMap(colorsOf), ...(drawing.background ? [drawing.background.fill] : [])]);
  const swapped = new Map([...used].map((color) => [color, nearest(color, brand)]));
  app.commands.record("Colours of a brand", items, [], () => {
    for (const item of items) Object.assign(item, withColors(item, swapped));
    const { background } = drawing;
    if (background) drawing.background = { ...background, fill: swapped.get(background.fill) };
  }, false, drawing);
  app.say(`The drawing has ${counted(new Set(swapped.values()).size, "colour")} of the brand now`);
}

/** Returns the colour that looks most like another one; the eye sees green best, and blue least. */
function nearest(color, brand) {
  const distance = (other) => {
    const [red, green, blue] = channelsOf(color).map((level, i) => level - channelsOf(other)[i]);
    return 2 * red ** 2 + 4 * green ** 2 + 3 * blue ** 2;
  };
  return brand.toSorted((a, b) => distance(a) - distance(b))[0];
}
