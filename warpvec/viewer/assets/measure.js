/* Compares the drawing, as this browser draws it, with the photo. */

import { paintDrawing } from "viewer/painted.js";
import { newCanvas, paintBackground, painting, PLAIN, runUntil, signatures, windowOf } from "viewer/raster.js";

// Colours of |difference| from 0 to 255 / RESIDUAL_GAIN: black, red, yellow, white.
const RESIDUAL_GAIN = 4;
const RESIDUAL_COLORS = [[0, 0, 4], [86, 16, 110], [187, 55, 84], [249, 142, 9], [252, 255, 164]];

// Numbers that are compared in a step: about a millisecond's work.
const COMPARED_PER_STEP = 2 ** 19;

export async function loadPhoto(url) {
  const image = new Image();
  image.src = url;
  await image.decode();
  return image;
}

export class Meter {
  constructor(image) {
    const [width, height] = [image.naturalWidth, image.naturalHeight];
    const { canvas, context } = newCanvas(width, height);
    context.drawImage(image, 0, 0);
    this.photo = canvas;
    this.pixels = context.getImageData(0, 0, width, height).data;
    this.own = newCanvas(width, height);
    this.measured = new Map();
    this.map = newCanvas(width, height);
    this.mapped = null;
  }

  /** Returns the matrix from the user units of a drawing to pixels of the photo.
   *
   * @returns {[number, number, number, number, number, number]} */
  matrixOf({ box: [x, y, width, height] }) {
    const [scaleX, scaleY] = [this.photo.width / width, this.photo.height / height];
    return [scaleX, 0, 0, scaleY, -x * scaleX, -y * scaleY];
  }

  /** Measures the picture of the first layer, of the first two, and so on, in steps. */
  *measuring(drawing, layers) {
    const { canvas, context } = this.own;
    const keys = keysOf(drawing, layers);
    const matrix = this.matrixOf(drawing);
    if (keys.every((key) => this.measured.has(key))) return;
    if (this.measured.size > 1000) this.measured.clear();
    context.setTransform(...matrix);
    paintBackground(context, drawing, PLAIN);
    for (const [i, { items }] of layers.entries()) {
      yield* painting(context, items, PLAIN, windowOf(canvas, matrix));
      if (!this.measured.has(keys[i])) this.measured.set(keys[i], yield* comparing(this.drawn(), this.pixels));
    }
  }

  drawn() {
    const { canvas, context } = this.own;
    return context.getImageData(0, 0, canvas.width, canvas.height).data;
  }

  /** Returns the PSNR in dB of the picture of `layers` if it has been measured already. */
  known(drawing, layers) {
    return this.measured.get(keysOf(drawing, layers).at(-1));
  }

  /** Returns a canvas that shows the largest channel difference of each pixel. */
  residual(drawing, layers) {
    const key = keysOf(drawing, layers).at(-1);
    if (this.mapped === key) return this.map.canvas;
    this.mapped = key;
    const { canvas, context } = this.own;
    runUntil(paintDrawing(context, drawing, layers.flatMap(({ items }) => items), PLAIN, this.matrixOf(drawing)), Infinity);
    const drawn = this.drawn();
    const image = this.map.context.createImageData(canvas.width, canvas.height);
    const target = new Uint32Array(image.data.buffer);
    const table = residualTable();
    for (let i = 0, j = 0; j < target.length; i += 4, j++) {
      const red = Math.abs(drawn[i] - this.pixels[i]);
      const green = Math.abs(drawn[i + 1] - this.pixels[i + 1]);
      const blue = Math.abs(drawn[i + 2] - this.pixels[i + 2]);
      target[j] = table[Math.max(red, green, blue)];
    }
    this.map.context.putImageData(image, 0, 0);
    return this.map.canvas;
  }
}

/** Returns keys of the picture of the first layer, of the first two, and so on. */
function keysOf({ background, box }, layers) {
  const paper = [background?.fill, background?.opacity, ...box].join(" ");
  return signatures(layers, PLAIN).slice(1).map((key) => `${paper} ${key}`);
}

/** Returns the PSNR over the colour channels of two arrays of RGBA pixels, in steps. */
function* comparing(a, b) {
  let squares = 0;
  for (let start = 0; start < a.length; start += COMPARED_PER_STEP) {
    const end = Math.min(start + COMPARED_PER_STEP, a.length);
    for (let i = start; i < end; i += 4) {
      const red = a[i] - b[i];
      const green = a[i + 1] - b[i + 1];
      const blue = a[i + 2] - b[i + 2];
      squares += red * red + green * green + blue * blue;
    }
    yield;
  }
  return squares ? 10 * Math.log10((255 * 255 * 0.75 * a.length) / squares) : Infinity;
}

/** Returns packed RGBA for every difference from 0 to 255, in the machine's byte order. */
function residualTable() {
  const bytes = new Uint8ClampedArray(4 * 256);
  for (let level = 0; level < 256; level++) {
    const color = rampColor(RESIDUAL_COLORS, Math.min((level * RESIDUAL_GAIN) / 255, 1));
    bytes.set([...color, 255], 4 * level);
  }
  return new Uint32Array(bytes.buffer);
}

/** Returns the colour at `share` in [0, 1] of a ramp, interpolated between its two nearest stops. */
export function rampColor(stops, share) {
  const place = share * (stops.length - 1);
  const index = Math.min(Math.floor(place), stops.length - 2);
  return stops[index].map((level, c) => level + (place - index) * (stops[index + 1][c] - level));
}
