/* The lasso and the eraser: they take an area out of all shapes below it, or out of the selected ones. The server cuts
 * the shapes; the area is noted with the drawing, so that the next fit fills it in. */

import { strokeOutline } from "viewer/brush.js";
import { counted } from "viewer/charts.js";
import { boxesMeet, makeShape, writeShape } from "viewer/paths.js";
import { reachOf } from "viewer/raster.js";
import { replacements, sent } from "viewer/reshape.js";
import { decimalsFor } from "viewer/save.js";

// Shapes of a request, each with its area: together the limit of the server.
const SHAPES_MAX = 32;

export class Eraser {
  constructor(app) {
    this.app = app;
    this.isBusy = false;
  }

  /** Erases what was drawn around ("lasso") or over ("eraser"), along points [[x, y], ...] in user units. */
  async run(tool, points) {
    const { app } = this;
    const { drawing } = app;
    if (this.isBusy || (tool === "lasso" && points.length < 3) || !app.mayChange()) return;
    const area = tool === "lasso" ? polygon(points) : strokeOutline(points, app.brush.width);
    const among = app.selection.size ? [...app.selection] : app.pickable;
    const items = among.filter((item) => boxesMeet(reachOf(item), area.box));
    this.isBusy = true;
    app.say("Erasing …");
    try {
      const shapes = items.map(({ shape }) => shape);
      const answered = await cut(items, area, drawing.box);
      const isSame = items.every(({ shape }, i) => shape === shapes[i]);
      if (app.drawing === drawing && isSame && app.mayChange()) this.finish(answered, area);
    } catch (error) {
      app.say(error.message);
    } finally {
      this.isBusy = false;
      app.panel.request();
    }
  }

  finish(answered, area) {
    const { app } = this;
    const { drawing } = app;
    const hit = answered.filter(({ left }) => left);
    const refused = answered.find((each) => each.refused)?.refused;
    const left = new Map(hit.map((each) => [each.item, each.left]));
    const layers = [...new Set(hit.map(({ item }) => item.layer))];
    const noted = { d: writeShape(area, decimalsFor(drawing.box)), rule: null, box: drawing.box.join(" "), isNew: true, isArea: true };
    if (hit.length) {
      app.commands.record("Erase", [], layers, () => {
        for (const layer of layers) layer.items = layer.items.flatMap((item) => left.get(item) ?? [item]);
        drawing.erased = [...drawing.erased, noted];
      }, false, drawing);
    }
    app.say([hit.length ? `Erased from ${counted(hit.length, "path")}` : "Nothing to erase there", refused].filter(Boolean).join(". "));
  }
}

/** Cuts an `area` out of items. Returns {item, left, refused} of each: what is left of it, undefined if the area is
 * elsewhere or the server refuses.
 *
 * @param {any[]} items
 * @param {any} area a shape, in the user units of the items
 * @param {number[]} box the box of their drawing */
export async function cut(items, area, box) {
  const asked = items.map((item) => ({ item, ...sent(item, item.fill ? "cut" : "outline", box) }));
  const answers = await ask(asked, area, box);
  return asked.map((each, i) => {
    const { svg, gone, refused } = answers[i];
    const left = gone ? [] : svg ? rest({ ...each, svg }, area) : undefined;
    return { item: each.item, left, refused };
  });
}

async function ask(asked, area, box) {
  const answers = [];
  for (let start = 0; start < asked.length; start += SHAPES_MAX) {
    const part = asked.slice(start, start + SHAPES_MAX);
    const areaFor = (item) => sent({ ...item, fill: "#000000", stroke: null, shape: area }, "cut", box, item).text;
    answers.push(...(await window.desk.reshape("cut", part.flatMap(({ item, text }) => [text, areaFor(item)]))));
  }
  return answers;
}

/** Returns what is left of an item: the same item in its new shape. */
function rest(each, area) {
  const { item } = each;
  const [first] = replacements(each, item.fill ? "cut" : "outline");
  const { fill, stroke, shape } = first ?? {};
  return first ? [{ ...item, fill, stroke, shape, rule: "nonzero", erased: [...(item.erased ?? []), area] }] : [];
}

function polygon(points) {
  const rows = [...points.slice(1), points[0]];
  const flat = [...points[0]];
  let [x, y] = points[0];
  for (const [u, v] of rows) {
    flat.push(x + (u - x) / 3, y + (v - y) / 3, u - (u - x) / 3, v - (v - y) / 3, u, v);
    [x, y] = [u, v];
  }
  return makeShape([{ points: Float64Array.from(flat), closed: true, kinds: rows.map(() => "l") }]);
}
