/* A picture on this page: its file, what the server knows of it, and its drawing. */

// Longest side of the picture that the drawing is compared with, as in files of `warpvec run --report`.
const PHOTO_SIDE = 2048;

const STATUS_WORDS = {
  loading: "loading", waiting: "waiting", fitting: "drawing", done: "done", stopped: "stopped", failed: "failed", idle: "",
};

class Picture {
  constructor(name, blob, settings) {
    Object.assign(this, { name, blob, id: null, width: 0, height: 0, status: "loading", place: 0 });
    Object.assign(this, { photo: null, text: null, frame: null, figures: {}, history: [], mode: null, reason: null });
    // The number of the fit whose result `text` is, and whether that has been saved.
    Object.assign(this, { fit: null, isSaved: false });
    this.settings = { ...settings };
    this.message = "";
    // Paths that the user has deleted: what they show does not come back.
    this.erased = [];
  }

  get isBusy() {
    return this.status === "waiting" || this.status === "fitting";
  }

  /** The newest drawing: the present frame of a fit, or the result of the last one. */
  get newest() {
    return this.frame?.svg ?? this.text;
  }

  /** Shows the list entry in words. */
  get state() {
    if (this.status === "waiting" && this.place > 0) return `waiting, ${this.place} before`;
    if (this.status === "fitting" && this.frame) return `${Math.round(progressOf(this.frame) * 100)} %`;
    return STATUS_WORDS[this.status];
  }

  /** Loads the image to compare with by `load`: that of the file, or the server's copy, if this browser cannot read it.
   * Without a server there may be none. */
  async prepare(load, copyUrl) {
    if (this.photo) return;
    const url = this.blob && (await reducedUrl(this.blob).catch(() => null));
    if (url) this.photo = await load(url).catch(() => null);
    if (url) URL.revokeObjectURL(url);
    this.photo ??= await load(copyUrl).catch(() => null);
  }
}

function progressOf({ iteration, iterations }) {
  return iterations ? iteration / iterations : 0;
}

/** Returns the address of an image, at most PHOTO_SIDE long, over white. Fails if this browser cannot read it. */
async function reducedUrl(blob) {
  const bitmap = await createImageBitmap(blob);
  const scale = Math.min(PHOTO_SIDE / Math.max(bitmap.width, bitmap.height), 1);
  const canvas = new OffscreenCanvas(Math.round(bitmap.width * scale), Math.round(bitmap.height * scale));
  const context = canvas.getContext("2d", { willReadFrequently: true });
  context.imageSmoothingQuality = "high";
  context.drawImage(bitmap, 0, 0, canvas.width, canvas.height);
  bitmap.close();
  if (scale === 1 && (blob.type === "image/jpeg" || isOpaque(context, canvas))) return URL.createObjectURL(blob);
  context.globalCompositeOperation = "destination-over";
  context.fillStyle = "#ffffff";
  context.fillRect(0, 0, canvas.width, canvas.height);
  return URL.createObjectURL(await canvas.convertToBlob({ type: "image/png" }));
}

function isOpaque(context, { width, height }) {
  const { data } = context.getImageData(0, 0, width, height);
  for (let i = 3; i < data.length; i += 4) if (data[i] < 255) return false;
  return true;
}

function emptyDrawing({ width, height }) {
  return `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}"/>`;
}
