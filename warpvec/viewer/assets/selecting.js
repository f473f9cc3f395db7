/* Ways to select paths without pointing at them. */

import { paintKey } from "viewer/palette.js";

/** Selects all paths that a click may select, or with the node tool all nodes. */
export function selectAll(app) {
  if (app.nodes.path) app.nodes.chooseAll();
  else app.select(app.pickable);
}

/** Selects all paths that have the "fill" or the "layer" of a selected one. */
export function selectAlike(app, what) {
  const keyOfItem = (item) => (what === "fill" ? paintKey(item) : item.layer);
  const keys = new Set([...app.selection].map(keyOfItem));
  if (keys.size) app.select(app.pickable.filter((item) => keys.has(keyOfItem(item))));
}

/** Selects the path after (1) or before (-1) the selected one, in drawing order. */
export function selectNext(app, step) {
  const items = app.pickable;
  if (!items.length) return;
  const current = items.findIndex((item) => app.selection.has(item));
  const start = current < 0 ? (step > 0 ? -1 : 0) : current;
  app.select([items[(start + step + items.length) % items.length]]);
}
