/* A picture on this page: its file, what the server knows of it, and its drawing. */

// Longest side of the picture that the drawing is compared with, as in files of `warpvec run --report`.
const PHOTO_SIDE = Number(document.body.dataset.photoSide);

const STATUS_WORDS = {
  loading: "loading", waiting: "waiting", fitting: "drawing", done: "done", stopped: "stopped", failed: "failed", idle: "",
};

export class PagePicture {
  // What the server knows: its name for the picture, the run of the server that gave it and the number in that run, the
  // size, and how many fits are before that of the picture.
  id = null;
  run = "";
  number = 0;
  width = 0;
  height = 0;
  status = "loading";
  place = 0;
  // The kind of picture that was found, and why.
  mode = null;
  reason = null;
  message = "";
  // What its fit is doing, in words.
  stage = "";
  // The present drawing of a running fit.
  frame = null;
  // The image to compare with.
  photo = null;
  // The result of the last fit, its number, and whether the drawing has been saved.
  result = null;
  fit = null;
  isSaved = false;
  // What the last fit was asked for: its number, the positions of the controls, and what is to become of the edits; see
  // live.js. While the request is under way, it is also `asking`.
  asked = { fit: 0, positions: null, edits: "dropped", more: {} };
  asking = null;
  // The drawing with its edits while another picture is shown, and whether a result has come since.
  kept = null;
  isUnseen = false;
  // A result that has no place for some edits, which are named: the user decides.
  proposal = "";
  // What was sent with the last fit, for a server that has forgotten it.
  sent = {};
  isStopping = false;
  // Whether it is the first of those that came together: it is shown at once.
  isFirst = false;
  // The upload that is under way, and the timer until changed settings take effect.
  arriving = null;
  timer = 0;
  // Whether its file is being read and sent.
  isBeginning = false;

  // Its name for this page, also after it is loaded again.
  key = crypto.randomUUID();
  // The file of its drawing that was opened, until it is read.
  drawing = null;
  // The control that has been moved last, until a fit is asked for with it.
  moved = null;

  constructor(name, blob, positions) {
    this.name = name;
    this.blob = blob;
    this.positions = { ...positions };
  }

  /** Whether its newest drawing is as the user has saved it, or there is none, while another picture is shown. */
  get isClean() {
    return !this.newest || this.isSaved;
  }

  get isBusy() {
    return this.status === "waiting" || this.status === "fitting";
  }

  /** The newest drawing: the present frame of a fit, or the result of the last one. */
  get newest() {
    return this.frame?.svg ?? this.result?.text ?? this.result?.svg ?? null;
  }

  /** Shows the list entry in words. */
  get state() {
    if (this.isStopping && this.isBusy) return "stopping";
    if (this.status === "waiting" && this.place > 0) return `waiting, ${this.place} before`;
    if (this.status === "fitting" && this.frame) return `${Math.round(progressOf(this.frame) * 100)} %`;
    return STATUS_WORDS[this.status];
  }

  /** Loads the image to compare with by `load`: that of the file, or the server's copy, if this browser cannot read it.
   * Without a server there may be none. */
  async prepare(load, findCopy) {
    if (this.photo) return;
    const url = this.blob && (await reducedUrl(this.blob).catch(() => null));
    if (url) this.photo = await load(url).catch(() => null);
    if (url) URL.revokeObjectURL(url);
    this.photo ??= await findCopy().then(load).catch(() => null);
  }
}

export function progressOf({ iteration, iterations }) {
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

export function emptyDrawing({ width, height }) {
  return `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}"/>`;
}
