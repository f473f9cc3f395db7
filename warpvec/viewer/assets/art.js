/* Shows the picture, and what a gesture makes of it, on the lower canvas of the stage. */

import { multiply } from "viewer/basics.js";
import { hexColor } from "viewer/colors.js";
import { inBox, keyOf, PaintedDrawing, pixelBox, placeOf } from "viewer/painted.js";
import { path2dOf, unionOfBoxes } from "viewer/paths.js";
import { inverse, Planes } from "viewer/planes.js";
import { newCanvas } from "viewer/raster.js";

// Part of a frame of 16.7 ms in which pictures and planes are drawn in advance.
const FRAME_WORK_MS = 7;
// Planes are drawn in advance for a selection that rests, not while keys step through paths.
const REST_MS = 150;
// Many separate paths on a large screen take more memory; their planes are drawn when a gesture needs them.
const MAX_AHEAD_BYTES = 128 * 2 ** 20;

export class Art {
  // What is shown, its place on the canvas, and what the planes are for.
  shown = null;
  region = null;
  planesFor = "";
  // A canvas of one pixel, from which colours are read.
  probe = null;

  constructor(app, canvas) {
    this.app = app;
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.picture = new PaintedDrawing();
    this.planes = null;
    this.forget();
  }

  /** Makes the next frame draw everything. */
  forget() {
    [this.shown, this.region, this.planesFor] = [null, null, ""];
  }

  /** Draws a frame for a view in pixels; returns whether another one is needed. `isMoving` keeps the picture as it is. */
  draw(view, isMoving) {
    const { app, canvas } = this;
    const deadline = performance.now() + FRAME_WORK_MS;
    const isLate = isMoving && this.picture.shown;
    const matrix = isLate ? this.picture.matrix : view;
    const { drawing, shownLayers: layers, palette } = app;
    const wanted = { drawing, layers, palette, width: canvas.width, height: canvas.height, matrix };
    if (app.gesture && !isLate) return this.drawGesture(wanted, deadline);
    this.region = null;
    if (this.isResidual) {
      this.drawAll(view, () => this.drawScaled(view, app.meter.residual(app.drawing, app.shownLayers)));
      return false;
    }
    if (app.show === "outlines") {
      this.drawAll(view, () => this.drawLines(view));
      return false;
    }
    return this.drawPicture(wanted, view, deadline) || (!isMoving && this.drawAhead(wanted, deadline));
  }

  /** Draws the outlines of all paths, those of hidden layers too, on white. */
  drawLines(view) {
    const { context, app } = this;
    const [x, y, width, height] = app.drawing.box;
    context.setTransform(...view);
    context.fillStyle = "#ffffff";
    context.fillRect(x, y, width, height);
    Object.assign(context, { lineWidth: 1 / view[0], strokeStyle: "#1b1c1e", lineJoin: "round", lineCap: "butt" });
    for (const { shape } of app.drawing.layers.flatMap(({ items }) => items)) context.stroke(path2dOf(shape));
  }

  get isResidual() {
    return this.app.show === "residual" && this.app.meter;
  }

  drawPicture(wanted, view, deadline) {
    const { app, picture } = this;
    const frame = [...view, app.split, ...app.drawing.box].join(" ");
    const isDone = picture.update(wanted, deadline, this.planes);
    const key = `${frame} ${picture.shown?.key}`;
    // An unfinished picture leaves the last frame in place, which may show the end of a gesture.
    if (this.shown?.key !== key && (isDone || this.shown?.frame !== frame)) {
      this.drawAll(view, () => {
        this.context.setTransform(...multiply(view, inverse(picture.matrix)));
        this.context.drawImage(picture.canvas, 0, 0);
      });
      this.shown = { frame, key };
    }
    return !isDone;
  }

  /** Prepares the planes of the selection while nothing else is to be done. */
  drawAhead(wanted, deadline) {
    const { selection } = this.app;
    const key = `${keyOf(wanted)} ${identityOf(selection)}`;
    if (this.planesFor !== key) {
      [this.planesFor, this.planesDue] = [key, performance.now() + REST_MS];
      if (!selection.size) this.planes = null;
    }
    if (!selection.size || performance.now() < this.planesDue) return selection.size > 0;
    if (this.planesDue > 0) this.ownPlanes(wanted);
    this.planesDue = 0;
    return this.planes.byteCount <= MAX_AHEAD_BYTES && !this.planes.work(deadline);
  }

  ownPlanes(wanted) {
    const { selection } = this.app;
    if (!this.planes?.isFor(wanted, selection)) this.planes = new Planes(wanted, selection, this.planes);
  }

  /** Draws the planes, only where the gesture has changed something. */
  drawGesture(wanted, deadline) {
    const { app, context } = this;
    const { gesture } = app;
    if (gesture.planes?.place !== placeOf(wanted)) {
      this.ownPlanes(wanted);
      gesture.planes = this.planes;
      [this.region, this.shown, this.planesFor] = [null, null, ""];
    }
    const { planes } = gesture;
    if (gesture.isRepainted) planes.paintLive();
    if (!planes.work(deadline)) return true;
    const touched = pixelBox(gesture.reach, wanted.matrix, wanted);
    const region = this.region ? unionOfBoxes([this.region, touched]) : [0, 0, wanted.width, wanted.height];
    this.region = touched;
    inBox(context, region, () => {
      this.clipToDrawing(wanted.matrix);
      planes.draw(context, gesture.matrix, wanted.palette);
    });
    return false;
  }

  drawAll(view, draw) {
    const { context, canvas } = this;
    this.shown = null;
    inBox(context, [0, 0, canvas.width, canvas.height], () => {
      this.clipToDrawing(view);
      draw();
      this.drawPhoto(view);
    });
  }

  clipToDrawing(view) {
    const { context, app } = this;
    context.setTransform(...view);
    context.beginPath();
    context.rect(...app.drawing.box);
    context.clip();
  }

  /** Draws the photo left of the split. */
  drawPhoto(view) {
    const { context, app } = this;
    if (!app.meter || app.split <= 0) return;
    const [x, y, width, height] = app.drawing.box;
    context.setTransform(...view);
    context.beginPath();
    context.rect(x, y, (width * app.split) / 100, height);
    context.clip();
    this.drawScaled(view, app.meter.photo);
  }

  drawScaled(view, canvas) {
    const { context } = this;
    const [x, y, width, height] = this.app.drawing.box;
    context.setTransform(...view);
    context.imageSmoothingEnabled = view[0] * width < 3 * canvas.width;
    context.imageSmoothingQuality = "high";
    context.drawImage(canvas, x, y, width, height);
    context.imageSmoothingEnabled = true;
  }

  /** Returns the visible colour "#rrggbb" at a pixel; null outside the picture. */
  colorAt(x, y) {
    this.probe ??= newCanvas(1, 1).context;
    this.probe.clearRect(0, 0, 1, 1);
    this.probe.drawImage(this.canvas, -Math.floor(x), -Math.floor(y));
    const pixel = this.probe.getImageData(0, 0, 1, 1).data;
    return pixel[3] ? hexColor([...pixel.slice(0, 3)]) : null;
  }
}

const identities = new WeakMap();
let lastIdentity = 0;

/** Returns a number that no other object has. */
function identityOf(object) {
  if (!identities.has(object)) identities.set(object, ++lastIdentity);
  return identities.get(object);
}
