/* Another drawing in the place of the shown one: hidden and locked layers, and the selection, are found again in it. */

import { mainColor } from "viewer/colornames.js";
import { gapBetween } from "viewer/colors.js";
import { nextVersion } from "viewer/commands.js";

// Largest difference of a channel, of 255, between the colours of one layer in two drawings.
const NEAR_COLOR = 24;

/** Returns the function that finds the layer of `drawing` that a layer of `next` was: the one of the same name as read,
 * or as it is now, or else the one that had or has the nearest colour. */
function counterpartLayers(drawing, next) {
  const [known, read] = [looksOf(drawing), looksOf(next)];
  const { layers } = drawing;
  return (layer) => {
    const { name, color } = read.get(layer) ?? {};
    const same = layers.find((old) => known.get(old)?.name === name) ?? layers.find((old) => old.name === layer.name);
    if (same || !color) return same;
    const owns = layers.flatMap((old) => [known.get(old)?.color, mainColor(old)].map((own) => ({ old, own })));
    const gaps = owns.filter(({ own }) => own);
    const [nearest] = gaps.map(({ old, own }) => ({ old, gap: gapBetween(color, own) })).sort((a, b) => a.gap - b.gap);
    return nearest?.gap <= NEAR_COLOR ? nearest.old : undefined;
  };
}

/** Returns name and main colour as read, by layer. It goes through the items once: there may be thousands, in each frame. */
function looksOf({ base }) {
  const items = new Map(base.layers.map(({ layer }) => [layer, []]));
  for (const origin of base.items) items.get(origin.layer)?.push(origin);
  return new Map(base.layers.map(({ layer, name }) => [layer, { name, color: mainColor({ items: items.get(layer) }) }]));
}

/** Puts the content of `next` into the app's drawing; hidden and locked layers, and the selection, are found again. */
export function replaceDrawing(app, next) {
  const counterpart = counterpartLayers(app.drawing, next);
  const chosen = [];
  for (const layer of next.layers) {
    layer.version = nextVersion();
    const old = counterpart(layer);
    if (!old) continue;
    [layer.visible, layer.isLocked] = [old.visible, old.isLocked];
    old.items.forEach((item, i) => {
      if (app.selection.has(item) && layer.items[i]) chosen.push(layer.items[i]);
    });
  }
  Object.assign(app.drawing, next);
  app.selection = new Set(chosen);
}
