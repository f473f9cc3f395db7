/* The controls of the numbers of a form, such as its radius, and of strokes: width, ends and corners. */

import { connectClicks, find, findAll, setText } from "viewer/dom.js";
import { changedForm } from "viewer/formpoints.js";
import { kindName } from "viewer/kinds.js";
import { formatNumber } from "viewer/paths.js";
import { Reshaper } from "viewer/reshape.js";

// Which numbers a form has, and what they are called.
const LABELS = {
  circle: { x: "X", y: "Y", first: "Radius" },
  ellipse: { x: "X", y: "Y", first: "Radius X", second: "Radius Y", angle: "Turn °" },
  rect: { x: "X", y: "Y", first: "Width", second: "Height", corner: "Radius", angle: "Turn °" },
};
const NUMBERS = ["x", "y", "first", "second", "corner", "angle"];
const DECIMALS = 3;
const POSITIVE = new Set(["first", "second"]);

export class ShapePanel {
  constructor(app) {
    this.app = app;
    for (const name of NUMBERS) this.onNumber(`form-${name}`, (value) => this.reform(name, value));
    this.onNumber("stroke-width", (width) => width > 0 && this.restroke({ width }));
    this.onNumber("stroke-limit", (limit) => this.restroke({ limit: Math.max(limit, 1) }));
    for (const name of ["cap", "join"]) {
      const field = find(`stroke-${name}`);
      field.addEventListener("change", () => this.restroke({ [name]: field.value }));
    }
    this.reshaper = new Reshaper(app);
    connectClicks({
      "to-path": () => app.editor.toPaths(), "to-outline": () => this.reshaper.run("outline"),
      "to-stroke": () => this.reshaper.run("stroke"),
    });
    find("make-form").addEventListener("change", () => {
      const to = find("make-form").value;
      find("make-form").selectedIndex = 0;
      this.reshaper.run(to);
    });
  }

  onNumber(id, action) {
    find(id).addEventListener("change", () => {
      const value = find(id).valueAsNumber;
      if (Number.isFinite(value)) action(value);
      this.app.panel.request();
    });
  }

  reform(name, value) {
    const { app } = this;
    app.endKeys();
    const form = this.form;
    if (!form || (POSITIVE.has(name) && !(value > 0)) || isShown(form[name], value)) return;
    app.editor.reform(changedForm(form, { [name]: value }));
  }

  restroke(change) {
    const { app } = this;
    app.endKeys();
    const isNew = ({ stroke }) => stroke && Object.keys(change).some((name) => !isShown(stroke[name], change[name]));
    if ([...app.selection].some(isNew)) app.editor.restroke(change);
  }

  /** The form of the one selected shape; null without one. */
  get form() {
    const { selection } = this.app;
    return (selection.size === 1 && [...selection][0].shape.form) || null;
  }

  show() {
    const items = [...this.app.selection];
    const stroked = items.filter(({ stroke }) => stroke);
    find("shape-box").hidden = !items.length;
    setText("shape-kind", items.length === 1 ? kindName(items[0]) : "");
    this.showForm(this.form);
    this.showStroke(stroked);
    find("to-path").hidden = !items.some(({ shape }) => shape.form);
    this.showCommands(items, stroked);
  }

  /** Shows the commands that the server runs, where there is one and they can do something. */
  showCommands(items, stroked) {
    const canAsk = Boolean(window.desk?.reshape);
    const shown = { "to-outline": stroked.length, "to-stroke": items.some(({ fill, stroke }) => fill && !stroke) };
    for (const [id, isUseful] of Object.entries(shown)) {
      find(id).hidden = !canAsk || !isUseful;
      find(id).disabled = this.reshaper.isBusy;
    }
    find("reshape-box").hidden = !canAsk;
    find("make-form-field").hidden = !canAsk || items.every(({ shape }) => shape.form);
    find("make-form").disabled = this.reshaper.isBusy;
  }

  showForm(form) {
    find("form-box").hidden = !form;
    if (!form) return;
    for (const name of NUMBERS) {
      const label = LABELS[form.element][name];
      const field = find(`form-${name}`);
      field.parentElement.hidden = !label;
      if (!label) continue;
      setText(`form-${name}-label`, label);
      showNumber(field, form[name]);
    }
  }

  /** Shows the look of the first stroke; a look that the others do not share is changed in all. */
  showStroke(stroked) {
    find("stroke-box").hidden = !stroked.length;
    if (!stroked.length) return;
    const { width, cap, join, limit } = stroked[0].stroke;
    showNumber(find("stroke-width"), width);
    showNumber(find("stroke-limit"), limit);
    [find("stroke-cap").value, find("stroke-join").value] = [cap, join];
    find("stroke-limit-field").hidden = join !== "miter";
    for (const field of findAll("#stroke-box [data-cap]")) field.hidden = !stroked.some(({ shape }) => hasEnds(shape));
  }
}

function hasEnds(shape) {
  return shape.subpaths.some(({ closed }) => !closed);
}

/** Tells whether a value is what a field shows already: leaving a field is no change, nor are decimals that it hides. */
function isShown(old, value) {
  return typeof old === "number" ? formatNumber(old, DECIMALS) === formatNumber(value, DECIMALS) : old === value;
}

/** Shows a number in a field, unless somebody is typing there. */
function showNumber(field, value) {
  const text = formatNumber(value, DECIMALS).replace(/^(-?)\./, "$10.");
  if (field.value !== text && document.activeElement !== field) field.value = text;
}
