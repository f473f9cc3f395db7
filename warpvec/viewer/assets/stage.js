/* The view of the picture in the middle: zoom, pan, and when the canvases are drawn. */

import { Art } from "viewer/art.js";
import { Marks } from "viewer/marks.js";
import { transformedBox } from "viewer/paths.js";
import { IDENTITY } from "viewer/read.js";

const SETTLE_MS = 120;
const MARGIN = 28;
const MAX_ZOOM = 64;

export class Stage {
  // Of the canvas, in CSS pixels.
  width = 0;
  height = 0;

  constructor(app, art, overlay) {
    this.app = app;
    this.art = new Art(app, art);
    this.marks = new Marks(app, this, overlay);
    this.canvases = [art, overlay];
    // From user units to CSS pixels of the stage.
    this.view = { scale: 1, x: 0, y: 0 };
    this.fitted = true;
    this.band = null;
    this.stroke = null;
    new ResizeObserver(() => this.resize()).observe(art.parentElement);
  }

  resize() {
    const { width, height } = this.canvases[0].parentElement.getBoundingClientRect();
    this.ratio = window.devicePixelRatio || 1;
    for (const canvas of this.canvases) {
      canvas.width = Math.max(Math.round(width * this.ratio), 1);
      canvas.height = Math.max(Math.round(height * this.ratio), 1);
    }
    this.art.forget();
    [this.width, this.height] = [width, height];
    if (this.fitted) this.fit();
    this.draw();
  }

  fit() {
    const [x, y, width, height] = this.app.drawing.box;
    const scale = Math.max(Math.min((this.width - 2 * MARGIN) / width, (this.height - 2 * MARGIN) / height), 1e-3);
    const place = (side, low, extent) => (side - scale * extent) / 2 - scale * low;
    this.view = { scale, x: place(this.width, x, width), y: place(this.height, y, height) };
    this.fitted = true;
    this.settle();
  }

  /** Zooms by `factor` around the point x, y of the stage. */
  zoom(factor, x = this.width / 2, y = this.height / 2) {
    const scale = Math.min(Math.max(this.view.scale * factor, 0.02), MAX_ZOOM);
    const change = scale / this.view.scale;
    this.view = { scale, x: x - change * (x - this.view.x), y: y - change * (y - this.view.y) };
    this.unsettle();
  }

  pan(dx, dy) {
    this.view = { ...this.view, x: this.view.x + dx, y: this.view.y + dy };
    this.unsettle();
  }

  /** While the view moves the last picture is moved; it is drawn anew when the view rests. */
  unsettle() {
    this.app.endKeys();
    this.fitted = false;
    this.moving = true;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.settle(), SETTLE_MS);
    this.request();
  }

  settle() {
    clearTimeout(this.timer);
    this.moving = false;
    this.request();
  }

  toUser(x, y) {
    return [(x - this.view.x) / this.view.scale, (y - this.view.y) / this.view.scale];
  }

  toStage(x, y) {
    return [x * this.view.scale + this.view.x, y * this.view.scale + this.view.y];
  }

  /** The view in pixels of the canvas. */
  get matrix() {
    const { scale, x, y } = this.view;
    return [scale * this.ratio, 0, 0, scale * this.ratio, x * this.ratio, y * this.ratio];
  }

  request() {
    if (this.pending || !this.ratio) return;
    this.pending = true;
    requestAnimationFrame(() => this.draw());
  }

  draw() {
    this.pending = false;
    if (this.app.gesture) this.settleNow();
    const isUnfinished = this.art.draw(this.matrix, this.moving);
    this.marks.draw();
    this.app.onView();
    if (isUnfinished) this.request();
  }

  /** Gestures need the picture at its final place. */
  settleNow() {
    clearTimeout(this.timer);
    this.moving = false;
  }

  /** Returns the box of the selection in CSS pixels of the stage. */
  selectionBox() {
    const { app } = this;
    const box = transformedBox(app.selectionBox, app.gesture?.matrix ?? IDENTITY);
    const { scale, x, y } = this.view;
    return transformedBox(box, [scale, 0, 0, scale, x, y]);
  }

  /** Returns the visible colour "#rrggbb" at x, y of the stage; null outside the picture. */
  colorAt(x, y) {
    return this.art.colorAt(x * this.ratio, y * this.ratio);
  }
}
