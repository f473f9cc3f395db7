/* A change in progress: the selected paths follow the pointer or a slider, and the end of it makes one command.
 *
 * The picture is split into moving planes and still planes below and above them. Still planes are drawn only once, so a
 * frame costs a few copies, however many paths there are. */

// More moving planes cost more copies per frame. Beyond these, the drawing order is wrong until the gesture ends.
const MAX_MOVING_PLANES = 4;
// A moving plane with more paths is moved as a picture, whose edges are blurred until the gesture ends.
const MAX_LIVE_PATHS = 200;

class Gesture {
  constructor(app, label) {
    this.app = app;
    this.label = label;
    this.matrix = IDENTITY;
    this.before = capture([...app.selection], []);
    this.planes = null;
  }

  /** Transforms the selection by `matrix`, from its position at the start. */
  place(matrix) {
    this.matrix = matrix;
    this.app.stage.request();
  }

  /** Changes the {fill}, {endFill} or {opacity} of the selection. */
  paint(change) {
    for (const item of this.before.items.keys()) Object.assign(item, painted(item, change));
    this.repainted = true;
    this.app.stage.request();
  }

  /** Makes the still and moving planes of what the stage shows. */
  prepare(raster, drawing, layers, palette) {
    if (this.planes) return;
    const items = layers.flatMap((layer) => layer.items);
    this.planes = planesOf(items, this.app.selection);
    for (const [i, plane] of this.planes.entries()) {
      plane.live = plane.moving && (this.repainted || plane.items.length <= MAX_LIVE_PATHS);
      if (!plane.live) plane.picture = drawPlane(plane.items, raster, palette, i === 0 ? drawing : null);
    }
  }

  /** Draws the planes on a canvas whose pixels are those of `raster`. */
  draw(context, raster, palette) {
    const view = raster.matrix;
    const onScreen = multiply(multiply(view, this.matrix), inverse(view));
    for (const plane of this.planes) {
      if (plane.live) {
        context.setTransform(...multiply(view, this.matrix));
        paintItems(context, plane.items, palette, null);
      } else {
        context.setTransform(...(plane.moving ? onScreen : IDENTITY));
        context.drawImage(plane.picture, 0, 0);
      }
    }
    context.setTransform(...IDENTITY);
  }

  /** Records the command, if anything has changed. */
  end() {
    const items = [...this.before.items.keys()];
    if (this.matrix !== IDENTITY) for (const item of items) Object.assign(item, transformed(item, this.matrix));
    const changed = items.some((item) => ["shape", "fill", "opacity", "stroke"].some((k) => item[k] !== this.before.items.get(item)[k]));
    if (changed) this.app.history.push(this.label, this.before);
  }

  cancel() {
    for (const [item, state] of this.before.items) Object.assign(item, state);
    this.app.stage.request();
  }
}

/** Returns runs of still and moving items in drawing order. The first run is still and may be empty. */
function planesOf(items, moving) {
  const planes = [{ moving: false, items: [] }];
  for (const item of items) {
    if (moving.has(item) !== planes.at(-1).moving) planes.push({ moving: moving.has(item), items: [] });
    planes.at(-1).items.push(item);
  }
  const count = () => planes.filter((plane) => plane.moving).length;
  while (count() > MAX_MOVING_PLANES) mergeNearest(planes);
  return planes;
}

/** Merges the two moving planes with the fewest still items between them; those items move below. */
function mergeNearest(planes) {
  let best = 2;
  for (let i = 2; i < planes.length - 1; i += 2) if (planes[i].items.length < planes[best].items.length) best = i;
  const [first, between, second] = planes.splice(best - 1, 3);
  planes[best - 2].items = planes[best - 2].items.concat(between.items);
  planes.splice(best - 1, 0, { moving: true, items: first.items.concat(second.items) });
}

/** Draws `items` into a new canvas, over the drawing's background if `drawing` is given. */
function drawPlane(items, raster, palette, drawing) {
  const { canvas, context } = newCanvas(raster.canvas.width, raster.canvas.height);
  context.setTransform(...raster.matrix);
  if (drawing) paintBackground(context, drawing, palette);
  paintItems(context, items, palette, raster.window);
  return canvas;
}

/** Returns the inverse of a matrix that only scales and translates. */
function inverse([a, , , d, e, f]) {
  return [1 / a, 0, 0, 1 / d, -e / a, -f / d];
}
