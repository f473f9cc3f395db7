/* Says the selected shapes in other words: "Stroke to outline" and back, "Make it a circle". The server of the page works
 * on the shapes alone, each on a canvas of its own; paint, place and order stay here. */

import { multiply, scaling, translation } from "viewer/basics.js";
import { sameState } from "viewer/changes.js";
import { capture } from "viewer/commands.js";
import { transformed } from "viewer/edit.js";
import { formatNumber } from "viewer/paths.js";
import { inverse } from "viewer/planes.js";
import { reachOf } from "viewer/raster.js";
import { readDrawing } from "viewer/read.js";
import { writeDrawing } from "viewer/save.js";

// Small drawings are enlarged until their longer side has so many pixels, and large shapes are reduced to it.
const DRAWING_MIN = 512;
const SHAPE_MAX = 1000;
const MARGIN_PX = 4;

const LABELS = {
  outline: "Stroke to outline", stroke: "Outline to stroke", circle: "Make a circle", ellipse: "Make an ellipse",
  rect: "Make a rectangle",
};
const DONE = {
  outline: "Now an outline", stroke: "Now a stroke", circle: "Now a circle", ellipse: "Now an ellipse",
  rect: "Now a rectangle",
};
const REFUSALS = {
  outline: (item) => !item.stroke && "This shape is filled: it is an outline already.",
  stroke: (item) => item.stroke && "This shape is a stroke already.",
};

export class Reshaper {
  constructor(app) {
    this.app = app;
    this.isBusy = false;
  }

  /** Asks the server to say the selected shapes as `to`, and replaces those that it can, in one command. */
  async run(to) {
    const { app } = this;
    const { drawing } = app;
    if (this.isBusy || !LABELS[to] || !app.selection.size || !app.mayChange()) return;
    const asked = [...app.selection].map((item) => ({ item, ...sent(item, to, drawing.box), refused: REFUSALS[to]?.(item) }));
    const open = asked.filter(({ refused }) => !refused);
    this.isBusy = true;
    app.say("Working …");
    app.panel.request();
    try {
      const before = capture(open.map(({ item }) => item), []).items;
      const answers = open.length ? await window.desk.reshape(to, open.map(({ text }) => text)) : [];
      app.endKeys();
      const isBusy = ({ item }) => app.gesture?.before.items.has(item) || !sameState(item, before.get(item));
      open.forEach((each, i) => Object.assign(each, answers[i], isBusy(each) && CHANGED));
      if (app.drawing === drawing) this.finish(to, asked);
    } catch (error) {
      app.say(error.message);
    } finally {
      this.isBusy = false;
      app.panel.request();
    }
  }

  finish(to, asked) {
    const { app } = this;
    const present = new Set(app.drawing.layers.flatMap(({ items }) => items));
    const done = asked.filter(({ item, svg, refused }) => svg && !refused && present.has(item));
    const made = new Map(done.map((each) => [each.item, replacements(each, to)]));
    if (made.size && !app.mayChange()) return;
    const layers = [...new Set(done.map(({ item }) => item.layer))];
    const chosen = [...app.selection].flatMap((item) => made.get(item) ?? [item]);
    if (made.size) {
      app.commands.record(LABELS[to], [], layers, () => {
        for (const layer of layers) layer.items = layer.items.flatMap((item) => made.get(item) ?? [item]);
      });
      if (!app.gesture) app.select(chosen);
    }
    app.say(report(to, asked, done));
  }
}

const CHANGED = { refused: "The shape was changed in the meantime." };

/** Returns the text of an item on a canvas of its own, or that of the item `on`, and the `matrix` to it; black, as the
 * paint does not matter. */
export function sent(item, to, box, on = item) {
  const [left, top, right, bottom] = reachOf(on);
  const extent = Math.max(right - left, bottom - top, 1e-9);
  const scale = Math.min(Math.max(1, DRAWING_MIN / Math.max(box[2], box[3])), SHAPE_MAX / extent);
  const matrix = multiply(translation(MARGIN_PX - scale * left, MARGIN_PX - scale * top), scaling(scale, scale, 0, 0));
  const isStroke = item.stroke && (to === "outline" || !item.fill);
  const stroke = { ...item.stroke, color: "#000000" };
  const paint = isStroke ? { fill: null, stroke, rule: "nonzero" } : { fill: "#000000", stroke: null };
  const moved = transformed({ ...item, ...paint }, matrix);
  const [width, height] = [right - left, bottom - top].map((side) => Math.ceil(scale * side) + 2 * MARGIN_PX);
  const items = [{ ...item, ...paint, ...moved, opacity: 1, softness: 0 }];
  const layer = { id: "layer-1", key: 0, generation: 0, name: "Layer 1", items };
  const background = { fill: "#ffffff", opacity: 1 };
  const size = { width: String(width), height: String(height), box: [0, 0, width, height] };
  return { text: writeDrawing({ ...size, background, layers: [layer], title: "", metadata: "", settings: null }), matrix };
}

/** Returns the items that replace one: the shapes of the answer in its paint, where it was. */
export function replacements({ item, svg, matrix }, to) {
  const found = readDrawing(svg).layers.flatMap(({ items }) => items);
  const shapes = found.map((each) => ({ ...transformed(each, inverse(matrix)), isStroke: !each.fill }));
  const { layer, opacity } = item;
  const made = shapes.map(({ shape, stroke, isStroke }) => {
    const painted = to === "outline" || to === "stroke" ? otherPaint(item, stroke, isStroke) : { fill: item.fill, stroke: item.stroke };
    return { layer, shape, opacity, rule: "nonzero", softness: item.softness, origin: null, ...painted };
  });
  // The fill below a stroke that becomes an outline stays.
  return to === "outline" && item.fill ? [{ ...item, stroke: null, origin: null }, ...made] : made;
}

/** Returns the paint of an outline that was a stroke, or of a stroke that was an outline. */
function otherPaint(item, stroke, isStroke) {
  if (!isStroke) return { fill: item.stroke?.color ?? item.fill, stroke: null };
  return { fill: null, stroke: { ...stroke, color: item.fill } };
}

/** Returns one sentence: what was done, how far off it is, or why not. */
function report(to, asked, done) {
  const [refused] = asked.filter((each) => each.refused).map((each) => each.refused);
  if (!done.length) return refused ?? "Nothing was changed.";
  const gaps = done.filter(({ distance }) => typeof distance === "number").map(({ distance, matrix }) => distance / matrix[0]);
  const gap = gaps.length ? `, at most ${formatNumber(Math.max(...gaps), 2).replace(/^\./, "0.")} units from the shape before` : "";
  const count = asked.length > 1 ? ` (${done.length} of ${asked.length})` : "";
  return `${DONE[to]}${count}${gap}${refused ? `. ${refused}` : ""}`;
}
