/* The list of the stops of a gradient: colour, place in per cent, opacity. */

import { find } from "viewer/dom.js";
import { isGradient, paintOf, withPaint } from "viewer/gradients.js";
import { STOPS_MAX, withNewStop, withoutStop, withStop } from "viewer/stops.js";

const FIELDS = [
  { name: "color", type: "color", words: "colour", read: (field) => field.value, write: ({ color }) => color },
  {
    name: "offset", type: "number", max: 100, words: "place in per cent", read: (field) => field.valueAsNumber / 100,
    write: ({ offset }) => String(Number((100 * offset).toFixed(2))),
  },
  {
    name: "opacity", type: "number", max: 1, words: "opacity", read: (field) => field.valueAsNumber,
    write: ({ opacity }) => String(Number(opacity.toFixed(4))),
  },
];

export class StopPanel {
  constructor(app) {
    this.app = app;
    this.rows = [];
    find("stop-add").addEventListener("click", () => this.change("Add a stop", withNewStop));
  }

  /** The gradient of the one selected path; null without one. */
  get fill() {
    const { selection } = this.app;
    const [item] = selection;
    return selection.size === 1 && isGradient(paintOf(item)) ? paintOf(item) : null;
  }

  change(label, change) {
    const { app, fill } = this;
    app.endKeys();
    const changed = fill && change(fill);
    if (changed && changed !== fill) app.editor.each(label, (item) => Object.assign(item, withPaint(item, changed)));
  }

  show() {
    const { fill } = this;
    find("stop-box").hidden = !fill;
    if (!fill) return;
    const { stops } = fill;
    if (this.rows.length !== stops.length) this.list(stops.length);
    stops.forEach((stop, i) => {
      for (const { name, write } of FIELDS) {
        const field = this.rows[i].fields[name];
        if (field.value !== write(stop) && document.activeElement !== field) field.value = write(stop);
      }
      this.rows[i].remove.disabled = stops.length <= 2;
    });
    find("stop-add").disabled = stops.length >= STOPS_MAX;
  }

  list(count) {
    this.rows = Array.from({ length: count }, (_, index) => this.makeRow(index));
    find("stops").replaceChildren(...this.rows.map(({ element }) => element));
  }

  makeRow(index) {
    const element = document.createElement("div");
    const fields = Object.fromEntries(FIELDS.map((kind) => [kind.name, this.makeField(index, kind)]));
    const remove = document.createElement("button");
    remove.textContent = "×";
    remove.title = `Delete stop ${index + 1}`;
    remove.setAttribute("aria-label", remove.title);
    remove.addEventListener("click", () => this.change("Delete a stop", (fill) => withoutStop(fill, index)));
    element.append(...Object.values(fields), remove);
    return { element, fields, remove };
  }

  /**
   * @param {number} index
   * @param {{name: string, type: string, max?: number, words: string, read: Function, write: Function}} kind */
  makeField(index, { name, type, max, words, read, write }) {
    const field = document.createElement("input");
    Object.assign(field, { type, title: `Stop ${index + 1}: ${words}`, ...(max && { min: 0, max, step: "any" }) });
    field.setAttribute("aria-label", field.title);
    field.dataset.stop = `${name} ${index}`;
    const isNew = () => {
      const value = read(field);
      return this.fill && (typeof value === "string" || Number.isFinite(value)) && field.value !== write(this.fill.stops[index]);
    };
    const changed = (fill) => withStop(fill, index, { [name]: read(field) });
    if (type === "color") {
      field.addEventListener("input", () => isNew() && this.follow(changed));
      field.addEventListener("change", () => this.app.end());
    } else {
      field.addEventListener("change", () => {
        if (isNew()) this.change("Stop", changed);
        this.app.panel.request();
      });
    }
    return field;
  }

  /** Lets the gradient follow a colour that is being chosen; its end makes one command. */
  follow(changed) {
    const { app } = this;
    app.begin("Stop");
    app.gesture?.reshape(withPaint([...app.selection][0], changed(this.fill)));
    app.panel.request();
  }
}
