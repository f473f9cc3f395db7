/* Draws on canvases. A raster keeps the picture after each layer, so that a change redraws only the layers above. */

const KEPT_BYTES = 128 * 2 ** 20;
const PAPER = "#ffffff";

/** Makes a canvas in main memory: its pixels are read back, and drawing costs the same on every machine. */
function newCanvas(width, height) {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [width, height];
  return { canvas, context: canvas.getContext("2d", { willReadFrequently: true }) };
}

/** Draws the `items` that overlap `window`, a box in user units, with the context's transform. */
function paintItems(context, items, palette, window) {
  for (const item of items) {
    if (window && !boxesMeet(item.shape.box, window)) continue;
    context.globalAlpha = item.opacity;
    const color = palette.colorOf(item);
    if (item.fill) fillPath(context, path2dOf(item.shape), item.rule, color ?? item.fill);
    if (item.stroke) {
      context.strokeStyle = color ?? item.stroke.color;
      const { width, cap, join, limit } = item.stroke;
      Object.assign(context, { lineWidth: width, lineCap: cap, lineJoin: join, miterLimit: limit });
      context.stroke(path2dOf(item.shape));
    }
  }
  context.globalAlpha = 1;
}

/** Draws white paper and the drawing's background. */
function paintBackground(context, drawing, palette) {
  const [x, y, width, height] = drawing.box;
  context.fillStyle = palette.paper ?? PAPER;
  context.fillRect(x, y, width, height);
  if (!drawing.background || palette.paper) return;
  context.globalAlpha = drawing.background.opacity;
  context.fillStyle = drawing.background.fill;
  context.fillRect(x, y, width, height);
  context.globalAlpha = 1;
}

class Raster {
  constructor() {
    Object.assign(this, newCanvas(1, 1));
    this.kept = new Map();
    this.shown = null;
    this.matrix = [1, 0, 0, 1, 0, 0];
  }

  /** Sets the size of the canvas in pixels, and the matrix from user units to pixels. */
  resize(width, height, matrix) {
    const same = this.canvas.width === width && this.canvas.height === height;
    if (same && this.matrix.every((value, i) => value === matrix[i])) return;
    if (!same) [this.canvas.width, this.canvas.height] = [width, height];
    this.matrix = matrix;
    this.kept.clear();
    this.shown = null;
  }

  /** The visible part of the canvas, as a box in user units. */
  get window() {
    const [scaleX, , , scaleY, x, y] = this.matrix;
    return [-x / scaleX, -y / scaleY, (this.canvas.width - x) / scaleX, (this.canvas.height - y) / scaleY];
  }

  /** Draws `layers` in the colours of `palette`, and returns the canvas. */
  draw(drawing, layers, palette) {
    const keys = signatures(layers, palette);
    const last = keys.length - 1;
    if (this.shown === keys[last]) return this.canvas;
    let index = last;
    while (index >= 0 && !this.kept.has(keys[index])) index--;
    this.begin(drawing, palette, keys[index]);
    const window = this.window;
    while (index < last) {
      // The first signature stands for the background alone.
      if (++index > 0) paintItems(this.context, layers[index - 1].items, palette, window);
      this.keep(keys[index]);
    }
    this.shown = keys[last];
    return this.canvas;
  }

  begin(drawing, palette, key) {
    const { context, canvas } = this;
    context.setTransform(1, 0, 0, 1, 0, 0);
    if (key === undefined) {
      context.clearRect(0, 0, canvas.width, canvas.height);
      context.setTransform(...this.matrix);
      paintBackground(context, drawing, palette);
      return;
    }
    context.globalCompositeOperation = "copy";
    context.drawImage(this.kept.get(key), 0, 0);
    context.globalCompositeOperation = "source-over";
    context.setTransform(...this.matrix);
  }

  /** Keeps a copy of the canvas; it replaces the oldest copy if the memory is used up. */
  keep(key) {
    const { width, height } = this.canvas;
    const limit = Math.min(Math.max(Math.floor(KEPT_BYTES / (4 * width * height)), 2), MAX_LAYERS + 1);
    let copy = null;
    if (this.kept.size >= limit) {
      const [oldest, canvas] = this.kept.entries().next().value;
      this.kept.delete(oldest);
      copy = { canvas, context: canvas.getContext("2d") };
    }
    copy ??= newCanvas(width, height);
    copy.context.globalCompositeOperation = "copy";
    copy.context.drawImage(this.canvas, 0, 0);
    this.kept.set(key, copy.canvas);
  }
}

/** Returns keys of the picture after the background and after each of `layers`. */
function signatures(layers, palette) {
  const keys = [palette.name];
  for (const { key, version } of layers) keys.push(`${keys.at(-1)} ${key}:${version}`);
  return keys;
}
