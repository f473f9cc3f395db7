/* The figures of the drawing. All places of the page show these: those of the file if nothing has been edited since,
 * else what the page itself measures of the drawing that it would save. */

import { isPristine, itemsOf } from "viewer/edits.js";
import { PLAIN, signatures } from "viewer/raster.js";
import { writeDrawing } from "viewer/save.js";

export class Figures {
  constructor(app) {
    this.app = app;
    this.sizes = new Map();
    this.state = { key: "", isPristine: true };
  }

  get key() {
    const { layers, background, width, height } = this.app.drawing;
    return [signatures(layers, PLAIN).at(-1), background?.fill, background?.opacity, width, height].join(" ");
  }

  /** Whether the drawing is the file that it was read from. */
  get isPristine() {
    const { drawing } = this.app;
    const { key, state } = this;
    if (state.key !== key || state.drawing !== drawing.base) {
      this.state = { key, drawing: drawing.base, isPristine: isPristine(drawing) };
    }
    return this.state.isPristine;
  }

  /** Returns {psnr, bytes, gzip_bytes, segments, ssim}: numbers, undefined while they are measured; others are missing. */
  get all() {
    const { drawing, meter } = this.app;
    const { figures } = drawing.facts;
    if (this.isPristine) {
      const psnr = "psnr" in figures ? { psnr: figures.psnr ?? Infinity } : meter ? { psnr: meter.known(drawing, drawing.layers) } : {};
      return { ...figures, ...psnr };
    }
    const segments = itemsOf(drawing).reduce((sum, { shape }) => sum + segmentCount(shape), 0);
    return { bytes: this.sizes.get(this.key), segments, ...(meter && { psnr: meter.known(drawing, drawing.layers) }) };
  }

  /** Returns the PSNR of the picture of `layers`: undefined while it is measured, or without a photo. */
  psnrOf(layers) {
    const { drawing, meter } = this.app;
    const isWhole = layers.length === drawing.layers.length && layers.every((layer, i) => layer === drawing.layers[i]);
    return isWhole ? this.all.psnr : meter?.known(drawing, layers);
  }

  /** Measures what is not known yet of the drawing and of its shown `layers`, in steps. */
  *measuring(layers) {
    const { drawing, meter } = this.app;
    if (meter) {
      yield* meter.measuring(drawing, layers);
      yield* meter.measuring(drawing, drawing.layers);
    }
    if (this.isPristine || this.sizes.has(this.key)) return;
    this.sizes.clear();
    this.sizes.set(this.key, new TextEncoder().encode(writeDrawing(drawing)).length);
  }
}

function segmentCount({ subpaths }) {
  return subpaths.reduce((sum, { points }) => sum + (points.length - 2) / 6, 0);
}
