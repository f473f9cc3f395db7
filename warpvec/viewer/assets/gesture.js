/* A change in progress: the selected paths follow the pointer, keys or a slider, and the end of it makes one command. */

import { sameState } from "viewer/changes.js";
import { capture } from "viewer/commands.js";
import { painted, transformed } from "viewer/edit.js";
import { transformedBox, unionOfBoxes } from "viewer/paths.js";
import { reachOf } from "viewer/raster.js";
import { IDENTITY } from "viewer/read.js";

// Keys that follow each other within this time, as held arrow keys do, are one gesture.
const KEY_PAUSE_MS = 400;

export class Gesture {
  constructor(app, label) {
    this.app = app;
    this.label = label;
    this.matrix = IDENTITY;
    this.before = capture([...app.selection], []);
    this.timer = null;
  }

  get items() {
    return [...this.before.items.keys()];
  }

  /** Transforms the selection by `matrix`, from its position at the start. */
  place(matrix) {
    this.matrix = matrix;
    this.app.stage.request();
  }

  /** Changes the {fill}, {endFill}, {opacity} or {softness} of the selection. */
  paint(change) {
    for (const item of this.items) Object.assign(item, painted(item, change));
    this.repaint();
  }

  /** Replaces parts of the only selected item. */
  reshape(change) {
    Object.assign(this.items[0], change);
    this.repaint();
  }

  repaint() {
    this.isRepainted = true;
    this.app.stage.request();
  }

  /** Ends the gesture unless it goes on within a short time. */
  endSoon() {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.app.end(), KEY_PAUSE_MS);
  }

  /** Returns the box of the moving paths in user units, as they are now. */
  get reach() {
    return transformedBox(unionOfBoxes(this.items.map(reachOf)), this.matrix);
  }

  /** Records the command, if anything has changed. */
  end() {
    clearTimeout(this.timer);
    const { items, before } = this;
    if (this.matrix !== IDENTITY) for (const item of items) Object.assign(item, transformed(item, this.matrix));
    if (items.some((item) => !sameState(item, before.items.get(item)))) this.app.commands.push(this.label, before);
  }

  cancel() {
    clearTimeout(this.timer);
    for (const [item, state] of this.before.items) Object.assign(item, state);
    this.app.stage.request();
  }
}
