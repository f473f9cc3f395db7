/* State of the page, and the actions that change it. */

import { strokeOutline } from "viewer/brush.js";
import { Caret } from "viewer/caret.js";
import { formatBytes } from "viewer/charts.js";
import { followColors } from "viewer/colornames.js";
import { hexColor } from "viewer/colors.js";
import { Commands } from "viewer/commands.js";
import { Editor, painted } from "viewer/edit.js";
import { Eraser } from "viewer/eraser.js";
import { Figures } from "viewer/figures.js";
import { Gesture } from "viewer/gesture.js";
import { LAYER_COLORS } from "viewer/layers.js";
import { drawingOf, EMPTY, Live } from "viewer/live.js";
import { rampColor } from "viewer/measure.js";
import { NodeTool } from "viewer/nodetool.js";
import { PalettePanel } from "viewer/palette.js";
import { formatNumber, unionOfBoxes } from "viewer/paths.js";
import { itemsAt, PLAIN } from "viewer/raster.js";
import { writeDrawing } from "viewer/save.js";

// A stroke that is thinner than twice this can be clicked so near its centre line.
const STROKE_REACH_PX = 3;

export class App {
  // The parts that need the document and this: `main.js` makes them.
  panel = null;
  stage = null;
  pointer = null;

  constructor() {
    this.tool = "select";
    this.panning = false;
    this.live = new Live(this);
    this.editor = new Editor(this);
    this.nodes = new NodeTool(this);
    this.caret = new Caret(this);
    this.figures = new Figures(this);
    this.eraser = new Eraser(this);
    this.palettes = new PalettePanel(this);
    // Each click adds to the selection, as with Shift, which a touch screen lacks.
    this.adding = false;
    this.byLayer = { name: "layers", paper: "#d8d8d4", colorOf: ({ layer }) => this.layerColor(layer) };
  }

  /** Shows a document; `data` is that in the page, and `meter` compares with its photo, if there is one. */
  open(data, meter) {
    this.data = data;
    const facts = { figures: data.figures ?? {}, history: data.history ?? [], ...data.facts };
    this.drawing = data.kept?.drawing ?? drawingOf(data.svg ?? EMPTY, facts);
    this.meter = meter;
    this.selection = new Set();
    this.layerLimit = Infinity;
    this.show = "drawing";
    this.split = meter ? 50 : 0;
    this.filter = null;
    this.gesture = null;
    this.edited = false;
    const { layers, box } = this.drawing;
    this.brush = { fill: "#d9480f", opacity: 1, width: Math.max(Math.round(box[2] / 60), 1), layer: layers.at(-1) };
    this.commands = data.kept?.commands ?? this.newCommands();
    this.shownBox = box;
    this.panel?.reopen();
    this.stage?.fit();
  }

  newCommands() {
    return new Commands(() => this.mayChange(), () => this.changed());
  }

  /** Ends a gesture by keys, and tells whether the drawing can be edited now; if not, says why. */
  mayChange() {
    this.endKeys();
    if (this.live.isOn) this.say("The drawing is being fitted: stop the fit to edit it");
    return !this.live.isOn;
  }

  /** Ends a gesture by keys, which waits for the next key. */
  endKeys() {
    if (this.gesture?.timer) this.end();
  }

  /** Says where keys have moved the selection to, for those who do not see it. */
  reportPlace(label) {
    if (this.nodes.path) {
      this.say(`${label}: ${this.nodes.describe()}`);
      return;
    }
    const [left, top, right, bottom] = this.selectionBox.map((value) => formatNumber(value, 1));
    this.say(`${label}: now from ${left}, ${top} to ${right}, ${bottom}`);
  }

  /** The number of layers that are shown, from the lowest. */
  get shownCount() {
    return Math.min(this.layerLimit, this.drawing.layers.length);
  }

  get shownLayers() {
    return this.drawing.layers.slice(0, this.shownCount).filter((layer) => layer.visible);
  }

  get palette() {
    return this.show === "layers" ? this.byLayer : PLAIN;
  }

  /** Items that a click may select: visible, not locked, and of the layer chosen in the filter. */
  get pickable() {
    const isOpen = (layer) => !layer.isLocked && (!this.filter || layer === this.filter);
    return this.shownLayers.filter(isOpen).flatMap(({ items }) => items);
  }

  get pathCount() {
    return this.drawing.layers.reduce((sum, { items }) => sum + items.length, 0);
  }

  get selectionBox() {
    return unionOfBoxes([...this.selection].map(({ shape }) => shape.box));
  }

  layerColor(layer) {
    const count = this.drawing.layers.length;
    const share = count > 1 ? this.drawing.layers.indexOf(layer) / (count - 1) : 0;
    return hexColor(rampColor(LAYER_COLORS, share));
  }

  /** Pickable items under a point of the stage, the topmost first. */
  pathsAt(point) {
    const [x, y] = this.stage.toUser(...point);
    return itemsAt(this.pickable, x, y, STROKE_REACH_PX / this.stage.view.scale);
  }

  select(items) {
    if (this.gesture) this.end();
    this.selection = new Set(items);
    this.refresh();
  }

  /** Moves the chosen nodes or the selection by a key; returns whether there was something to move. */
  nudge(dx, dy) {
    if (this.nodes.nudge(dx, dy)) return true;
    this.editor.move(dx, dy);
    return this.selection.size > 0;
  }

  toggleCaret() {
    this.pointer.surface.focus({ preventScroll: true });
    this.caret.toggle();
  }

  /** Updates the page after a command has changed the drawing, or has been undone. */
  changed() {
    this.edited = true;
    this.split = 0;
    followColors(this.drawing);
    const present = new Set(this.drawing.layers.flatMap(({ items }) => items));
    this.keepSelected((item) => present.has(item));
    this.refresh();
  }

  /** Updates the page after a change of the visible layers, the colours or the split. */
  refresh() {
    this.keepLayers();
    this.keepView();
    const shown = new Set(this.shownLayers);
    this.keepSelected(({ layer }) => shown.has(layer) && !layer.isLocked);
    this.stage.request();
    this.panel.request();
    this.live.onChange?.();
  }

  /** Shows the whole drawing if it is in other user units by now. */
  keepView() {
    const { box } = this.drawing;
    if (box.every((value, i) => value === this.shownBox[i])) return;
    this.brush.width = Math.max((this.brush.width * box[2]) / this.shownBox[2], Number.MIN_VALUE);
    this.shownBox = box;
    this.stage.fit();
  }

  /** Finds the layers of filter and brush again by their names, if the drawing has others now. */
  keepLayers() {
    const { layers } = this.drawing;
    const again = (layer) => (layers.includes(layer) ? layer : layers.find(({ name }) => name === layer?.name));
    this.filter = again(this.filter) ?? null;
    this.brush.layer = again(this.brush.layer) ?? layers.at(-1);
  }

  keepSelected(isKept) {
    const kept = [...this.selection].filter(isKept);
    if (kept.length < this.selection.size) this.selection = new Set(kept);
  }

  /** Starts a gesture on the selection, unless one is already active. */
  begin(label) {
    if (this.gesture && this.gesture.label !== label) this.end();
    if (this.gesture || !this.selection.size || !this.mayChange()) return;
    if (this.split) this.setSplit(0);
    this.panel.stopMeasuring();
    this.gesture = new Gesture(this, label);
    this.panel.request();
  }

  end() {
    const { gesture } = this;
    this.gesture = null;
    gesture?.end();
    if (gesture?.timer && this.selection.size) this.reportPlace(gesture.label);
    this.refresh();
  }

  cancel() {
    this.gesture?.cancel();
    this.gesture = null;
  }

  /** Lets each click add to the selection, or not. */
  setAdding(isOn) {
    this.adding = isOn;
    this.refresh();
  }

  setTool(tool) {
    this.endKeys();
    this.tool = tool;
    this.refresh();
  }

  showLayers(count) {
    this.layerLimit = count >= this.drawing.layers.length ? Infinity : Math.max(count, 1);
    this.refresh();
  }

  setSplit(split) {
    this.split = Math.min(Math.max(split, 0), 100);
    this.refresh();
  }

  setShow(show) {
    if (show === "residual" && !this.meter) return;
    this.show = show;
    this.refresh();
  }

  /** Takes the colour under the pointer for the brush and for the selection. */
  pickColor(point) {
    const fill = this.stage.colorAt(...point);
    if (!fill) return;
    this.brush.fill = fill;
    this.editor.each("Recolour", (item) => Object.assign(item, painted(item, { fill })), true);
    this.refresh();
  }

  addStroke(points) {
    if (!this.mayChange()) return;
    const { fill, opacity, width, layer } = this.brush;
    layer.visible = true;
    this.showLayers(Math.max(this.shownCount, this.drawing.layers.indexOf(layer) + 1));
    this.editor.add(strokeOutline(points, width), fill, opacity, layer);
    this.say("Path added");
  }

  undo() {
    if (window.desk?.undo?.() || !this.mayChange()) return;
    this.cancel();
    const label = this.commands.undo();
    this.say(label ? `Undone: ${label}` : "Nothing to undo");
  }

  redo() {
    if (!this.mayChange()) return;
    this.cancel();
    const label = this.commands.redo();
    this.say(label ? `Redone: ${label}` : "Nothing to redo");
  }

  save() {
    this.endKeys();
    const text = writeDrawing(this.drawing);
    if (window.desk?.save) {
      window.desk.save(text);
      return;
    }
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([text], { type: "image/svg+xml" }));
    link.download = `${this.data.name}-edited.svg`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
    this.edited = false;
    this.say(`Saved ${link.download}, ${formatBytes(text.length)}`);
  }

  say(text) {
    this.panel.say(text);
  }

  onView() {
    this.panel.showView();
  }
}
