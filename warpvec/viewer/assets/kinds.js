/* What shapes are: circles, ellipses, rectangles, strokes or paths; and how many of each there are. */

import { counted } from "viewer/charts.js";
import { FORM_NAMES } from "viewer/forms.js";

const NAMES = { ...FORM_NAMES, stroke: "stroke", path: "path" };

/** Returns "circle", "ellipse", "rect", "stroke" (a centre line without a fill) or "path". */
function kindOf({ shape, fill, stroke }) {
  if (shape.form) return shape.form.element;
  return stroke && !fill ? "stroke" : "path";
}

/** Returns the kind of an item in words: "Circle", or "Circle, stroked". */
export function kindName(item) {
  const kind = kindOf(item);
  const name = NAMES[kind][0].toUpperCase() + NAMES[kind].slice(1);
  return item.stroke && kind !== "stroke" ? `${name}, stroked` : name;
}

/** Returns "3 circles, 12 strokes, 4 paths"; without any, "0 paths". */
export function countedKinds(items) {
  const counts = Object.fromEntries(Object.keys(NAMES).map((kind) => [kind, 0]));
  for (const item of items) counts[kindOf(item)]++;
  const parts = Object.entries(counts).filter(([, count]) => count).map(([kind, count]) => counted(count, NAMES[kind]));
  return parts.join(", ") || counted(0, "path");
}
