/* The list of all colours of the drawing, and the replacement of one of them wherever it is used: in fills, gradients,
 * strokes and the background, on hidden layers too. Colours near it, as far as the slider says, change by as much. */

import { counted } from "viewer/charts.js";
import { colorOfHsl, gapBetween, hslOf, shiftedColor } from "viewer/colors.js";
import { find, onInput, setChoice, setText, setValue } from "viewer/dom.js";
import { isGradient, paintOf } from "viewer/gradients.js";
import { PLAIN, signatures } from "viewer/raster.js";

const MAX_SWATCHES = 48;
// Selections that follow each other within this time, as when a key is held, change the list only when they rest: to lay
// it out takes as long as all else in a frame.
const STEPPING_MS = 150;

export class PalettePanel {
  // The colour whose uses are replaced, and the version of the drawing in which they were found.
  from = null;
  version = null;

  constructor(app) {
    this.app = app;
    this.color = null;
    this.listed = null;
    this.lastFollowed = -Infinity;
  }

  connect() {
    find("palette").addEventListener("change", (event) => this.choose(event.target.value));
    onInput("replace", (value) => this.replace(value));
    find("replace-hex").addEventListener("change", () => this.replaceByText(find("replace-hex").value));
    onInput("near", () => this.choose(this.color));
    for (const id of ["hue", "saturation", "lightness"]) onInput(id, () => this.replace(this.mixed()));
    find("select-color").addEventListener("click", () => this.selectPaths());
  }

  /** Chooses a colour; the uses that it has now are those that are replaced. */
  choose(color) {
    this.take(color);
    this.app.panel.request();
  }

  /** Chooses the colour of a selection: at once, or when selections cease to follow each other. */
  follow(color) {
    const { selection } = this.app;
    const now = performance.now();
    const isStepping = now - this.lastFollowed < STEPPING_MS;
    this.lastFollowed = now;
    clearTimeout(this.timer);
    if (isStepping) this.timer = setTimeout(() => this.app.selection === selection && this.choose(color), STEPPING_MS);
    else this.take(color);
  }

  take(color) {
    clearTimeout(this.timer);
    const { background } = this.app.drawing;
    this.color = color;
    const reach = Number(find("near").value);
    const isNear = (other) => color && (reach ? gapBetween(color, other) <= reach : color === other);
    this.near = new Set([...this.items.keys()].filter(isNear));
    const items = [...this.near].flatMap((other) => this.items.get(other));
    this.uses = new Map(items.map((item) => [item, { fill: item.fill, stroke: item.stroke }]));
    this.background = this.near.has(background?.fill) ? background : null;
    [this.from, this.version] = [color, this.versionOf()];
  }

  selectPaths() {
    const { app } = this;
    app.select(app.pickable.filter((item) => this.uses.has(item)));
  }

  replaceByText(text) {
    const hex = text.trim().replace(/^#?(?=[0-9a-f])/i, "#").replace(/^#(.)(.)(.)$/, "#$1$1$2$2$3$3").toLowerCase();
    if (/^#[0-9a-f]{6}$/.test(hex)) this.replace(hex);
    else this.app.say("Give six digits from 0 to f, for example #1c64d1");
    this.app.panel.request();
  }

  /** Replaces the chosen colour in all its uses; replacements that follow each other are one command. */
  replace(color) {
    const { app, uses, background } = this;
    if (!this.color || color === this.color || (!uses.size && !background)) return;
    const swapped = new Map([...this.near].map((other) => [other, shiftedColor(other, this.from, color)]));
    const change = () => {
      for (const [item, use] of uses) Object.assign(item, withColors(use, swapped));
      if (background) app.drawing.background = { ...background, fill: swapped.get(background.fill) };
    };
    app.commands.record("Replace colour", [...uses.keys()], [], change, true, app.drawing);
    [this.color, this.version] = [color, this.versionOf()];
    app.say(`Replaced in ${counted(uses.size, "path")}${background ? " and the background" : ""}`);
  }

  /** Returns the colour of the three sliders. */
  mixed() {
    const [hue, saturation, lightness] = ["hue", "saturation", "lightness"].map((id) => Number(find(id).value));
    return colorOfHsl(hue, saturation / 100, lightness / 100);
  }

  /** The items that are painted with each colour. */
  get items() {
    const version = this.versionOf();
    if (this.indexed?.version !== version) this.indexed = { version, items: itemsByColor(this.app.drawing) };
    return this.indexed.items;
  }

  versionOf() {
    const { layers, background } = this.app.drawing;
    return `${signatures(layers, PLAIN).at(-1)} ${background?.fill}`;
  }

  show() {
    const { app } = this;
    const selected = app.selection.size ? colorsOf([...app.selection][0])[0] : null;
    if (selected && this.shownFor !== app.selection) this.follow(selected);
    else if (this.color && this.version !== this.versionOf()) this.take(this.items.has(this.color) ? this.color : selected);
    this.shownFor = app.selection;
    this.list();
    const count = this.color ? this.uses.size + Number(Boolean(this.background)) : 0;
    find("replace-box").disabled = !count;
    setText("replace-text", count ? counted(count, "use") : "");
    if (!count) return;
    setValue("replace", this.color, counted(count, "use"));
    if (document.activeElement !== find("replace-hex")) find("replace-hex").value = this.color;
    if (this.mixed() !== this.color) this.showMix();
    setText("near-text", find("near").value);
  }

  showMix() {
    const [hue, saturation, lightness] = hslOf(this.color);
    if (saturation > 0) find("hue").value = Math.round(hue);
    find("saturation").value = Math.round(100 * saturation);
    find("lightness").value = Math.round(100 * lightness);
  }

  /** Lists the colours with the most uses, and the chosen one. */
  list() {
    const { background } = this.app.drawing;
    const countOf = (color) => (this.items.get(color)?.length ?? 0) + (background?.fill === color);
    const { items } = this;
    if (this.listed !== this.indexed.version) {
      const byUse = [...items.keys()].map((color) => [color, countOf(color)]).sort((a, b) => b[1] - a[1]);
      const listed = byUse.slice(0, MAX_SWATCHES);
      find("palette").replaceChildren(...listed.map(([color, count]) => swatch(color, count)));
      const rest = byUse.length - listed.length;
      setText("palette-more", rest ? `and ${rest.toLocaleString("en")} more with fewer uses` : "");
      [this.listed, this.extra] = [this.indexed.version, null];
    }
    this.extra?.remove();
    const isListed = document.querySelector(`[name=swatch][value="${this.color}"]`);
    this.extra = this.color && !isListed ? swatch(this.color, countOf(this.color)) : null;
    if (this.extra) find("palette").append(this.extra);
    setChoice("swatch", this.color);
  }
}

function swatch(color, count) {
  const label = document.createElement("label");
  const input = document.createElement("input");
  Object.assign(input, { type: "radio", name: "swatch", value: color });
  input.setAttribute("aria-label", `${color}, ${counted(count, "use")}`);
  label.title = input.getAttribute("aria-label");
  const mark = document.createElement("i");
  mark.style.background = color;
  label.append(input, mark);
  return label;
}

/** Returns the colours that an item is painted with. */
export function colorsOf({ fill, stroke }) {
  const colors = (paint) => (isGradient(paint) ? paint.stops.map(({ color }) => color) : paint ? [paint] : []);
  return [...colors(fill), ...colors(stroke?.color)];
}

function itemsByColor({ layers, background }) {
  const items = new Map(background ? [[background.fill, []]] : []);
  for (const item of layers.flatMap((layer) => layer.items)) {
    for (const color of new Set(colorsOf(item))) {
      if (!items.has(color)) items.set(color, []);
      items.get(color).push(item);
    }
  }
  return items;
}

/** Returns fill and stroke with each colour that `swapped` has replaced by the other one. */
export function withColors({ fill, stroke }, swapped) {
  const color = stroke && paintWith(stroke.color, swapped);
  return { fill: paintWith(fill, swapped), stroke: stroke && color !== stroke.color ? { ...stroke, color } : stroke };
}

/** Returns the very same paint if none of its colours is replaced. */
function paintWith(paint, swapped) {
  if (!isGradient(paint)) return swapped.get(paint) ?? paint;
  if (!paint.stops.some(({ color }) => swapped.has(color))) return paint;
  const stops = paint.stops.map((stop) => ({ ...stop, color: swapped.get(stop.color) ?? stop.color }));
  return { ...paint, stops, onCanvas: null };
}

/** Returns a text that is the same for items that are painted alike. */
export function paintKey(item) {
  const paint = paintOf(item);
  const stops = isGradient(paint) && paint.stops.map(({ color, offset }) => `${color} ${offset}`).join(" ");
  return `${item.fill ? "" : "stroke "}${stops ? `${paint.kind} ${stops}` : paint}`;
}

