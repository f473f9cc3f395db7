/* The size of the drawing on paper: its width in pixels, millimetres or inches, which the file states. */

import { find } from "viewer/dom.js";
import { formatNumber } from "viewer/paths.js";

// CSS pixels of a unit.
const UNITS = { px: 1, mm: 96 / 25.4, cm: 96 / 2.54, in: 96, pt: 96 / 72, pc: 16 };

export class SizePanel {
  constructor(app) {
    this.app = app;
    find("size-width").addEventListener("change", () => this.put(find("size-width").valueAsNumber, find("size-unit").value));
    find("size-unit").addEventListener("change", () => {
      const unit = find("size-unit").value;
      this.put(this.pixels / UNITS[unit], unit);
    });
  }

  /** The width in CSS pixels. */
  get pixels() {
    const { width, box } = this.app.drawing;
    const { value, unit } = lengthOf(width);
    return value > 0 ? value * UNITS[unit] : box[2];
  }

  /** States the width in a unit; the height follows. */
  put(width, unit) {
    const { app } = this;
    const { drawing } = app;
    const [, , across, down] = drawing.box;
    if (!(width > 0 && Number.isFinite(width))) {
      app.panel.request();
      return;
    }
    const suffix = unit === "px" ? "" : unit;
    const text = (value) => `${Number(value.toFixed(unit === "in" ? 4 : 3))}${suffix}`;
    app.commands.record("Size", [], [], () => {
      Object.assign(drawing, { width: text(width), height: text((width * down) / across) });
    }, false, drawing);
  }

  show() {
    const { drawing } = this.app;
    const { unit } = lengthOf(drawing.width);
    const shown = unit in { px: 1, mm: 1, in: 1 } ? unit : "mm";
    const field = find("size-width");
    if (document.activeElement !== field) field.value = String(Number((this.pixels / UNITS[shown]).toFixed(3)));
    find("size-unit").value = shown;
  }

  /** The size in words, in the unit of the drawing: "63.5 × 42.33 mm". */
  get text() {
    return this.sizeIn(lengthOf(this.app.drawing.width).unit);
  }

  /** Returns the size in words, in a unit. */
  sizeIn(unit) {
    const { drawing } = this.app;
    const width = this.pixels / UNITS[unit];
    return `${[width, (width * drawing.box[3]) / drawing.box[2]].map((side) => formatNumber(side, 2)).join(" × ")} ${unit}`;
  }
}

/** Returns value and unit of a length; without a known one, 0 px. */
function lengthOf(text) {
  const found = (text ?? "").trim().match(/^([\d.]+)(px|mm|cm|in|pt|pc)?$/);
  return found ? { value: Number(found[1]), unit: found[2] ?? "px" } : { value: 0, unit: "px" };
}
