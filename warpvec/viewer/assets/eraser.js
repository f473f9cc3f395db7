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
      const asked = items.map((item) => ({ item, state: item.shape, ...sent(item, item.fill ? "cut" : "outline", drawing.box) }));
      const answers = await ask(asked, area, drawing.box);
      const isSame = asked.every(({ item, state }) => item.shape === state);
      if (app.drawing === drawing && isSame && app.mayChange()) this.finish(asked.map((each, i) => Object.assign(each, answers[i])), area);
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
    const hit = answered.filter(({ svg, gone }) => svg || gone);
    const refused = answered.find((each) => each.refused)?.refused;
    const left = new Map(hit.map((each) => [each.item, each.gone ? [] : rest(each)]));
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
function rest(each) {
  const { item } = each;
  const [first] = replacements(each, item.fill ? "cut" : "outline");
  return first ? [{ ...item, fill: first.fill, stroke: first.stroke, shape: first.shape, rule: "nonzero", isErased: true }] : [];
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
