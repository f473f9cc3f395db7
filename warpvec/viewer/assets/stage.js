/* The picture in the middle, zoomed and panned, with the marks of the selection above it. */

const SETTLE_MS = 120;
const MARGIN = 28;
const MAX_ZOOM = 64;
const MAX_OUTLINES = 300;
const MAX_OUTLINES_MOVING = 40;
const HANDLE_RADIUS = 4.5;

class Stage {
  constructor(app, art, overlay) {
    this.app = app;
    this.art = art;
    this.overlay = overlay;
    this.context = art.getContext("2d");
    this.marks = overlay.getContext("2d");
    this.raster = new Raster();
    // From user units to CSS pixels of the stage.
    this.view = { scale: 1, x: 0, y: 0 };
    this.fitted = true;
    this.band = null;
    this.stroke = null;
    new ResizeObserver(() => this.resize()).observe(art.parentElement);
  }

  resize() {
    const { width, height } = this.art.parentElement.getBoundingClientRect();
    this.ratio = window.devicePixelRatio || 1;
    for (const canvas of [this.art, this.overlay]) {
      canvas.width = Math.max(Math.round(width * this.ratio), 1);
      canvas.height = Math.max(Math.round(height * this.ratio), 1);
    }
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
    this.drawArt();
    this.drawMarks();
    this.app.onView();
  }

  drawArt() {
    const { context, app, art } = this;
    const [x, y, width, height] = app.drawing.box;
    context.setTransform(...IDENTITY);
    context.clearRect(0, 0, art.width, art.height);
    context.save();
    context.setTransform(...this.matrix);
    context.beginPath();
    context.rect(x, y, width, height);
    context.clip();
    if (app.show === "residual" && app.meter && !app.gesture) this.drawScaled(app.meter.residual(app.drawing, app.shownLayers));
    else this.drawPicture();
    this.drawPhoto();
    context.restore();
  }

  drawPicture() {
    const { context, app, raster, art } = this;
    const [layers, palette] = [app.shownLayers, app.palette];
    context.setTransform(...IDENTITY);
    if (!this.moving) raster.resize(art.width, art.height, this.matrix);
    if (app.gesture) {
      if (this.moving) this.settle();
      app.gesture.prepare(raster, app.drawing, layers, palette);
      app.gesture.draw(context, raster, palette);
      return;
    }
    const picture = raster.draw(app.drawing, layers, palette);
    context.setTransform(...multiply(this.matrix, inverse(raster.matrix)));
    context.drawImage(picture, 0, 0);
  }

  /** Draws the photo left of the split. */
  drawPhoto() {
    const { context, app } = this;
    if (!app.meter || app.split <= 0) return;
    const [x, y, width, height] = app.drawing.box;
    context.setTransform(...this.matrix);
    context.beginPath();
    context.rect(x, y, (width * app.split) / 100, height);
    context.clip();
    this.drawScaled(app.meter.photo);
  }

  drawScaled(canvas) {
    const [x, y, width, height] = this.app.drawing.box;
    this.context.setTransform(...this.matrix);
    this.context.imageSmoothingEnabled = this.view.scale * width < 3 * canvas.width;
    this.context.imageSmoothingQuality = "high";
    this.context.drawImage(canvas, x, y, width, height);
    this.context.imageSmoothingEnabled = true;
  }

  drawMarks() {
    const { marks, overlay, app } = this;
    marks.setTransform(...IDENTITY);
    marks.clearRect(0, 0, overlay.width, overlay.height);
    this.accent = getComputedStyle(overlay).color;
    if (app.selection.size) this.drawSelection();
    marks.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    if (this.band) this.drawBand();
    if (this.stroke) this.drawStroke();
  }

  drawSelection() {
    const { marks, app } = this;
    const placed = multiply(this.matrix, app.gesture?.matrix ?? IDENTITY);
    if (app.selection.size <= (app.gesture ? MAX_OUTLINES_MOVING : MAX_OUTLINES)) {
      for (const [width, color] of [[3, "rgb(255 255 255 / 0.75)"], [1.4, this.accent]]) {
        marks.setTransform(...placed);
        marks.lineWidth = (width * this.ratio) / Math.hypot(placed[0], placed[1]);
        marks.strokeStyle = color;
        for (const item of app.selection) marks.stroke(path2dOf(item.shape));
      }
    }
    marks.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    const [left, top, right, bottom] = this.selectionBox();
    this.strokeTwice(() => marks.strokeRect(left, top, right - left, bottom - top), [4, 3]);
    for (const [x, y] of this.handles()) {
      marks.beginPath();
      marks.arc(x, y, HANDLE_RADIUS, 0, 2 * Math.PI);
      marks.fillStyle = "#fff";
      marks.fill();
      marks.stroke();
    }
  }

  strokeTwice(stroke, dash) {
    const { marks } = this;
    [marks.lineWidth, marks.strokeStyle] = [3, "rgb(255 255 255 / 0.6)"];
    stroke();
    marks.setLineDash(dash);
    [marks.lineWidth, marks.strokeStyle] = [1.4, this.accent];
    stroke();
    marks.setLineDash([]);
  }

  /** Returns the box of the selection in CSS pixels of the stage. */
  selectionBox() {
    const { app } = this;
    const [a, , , d, e, f] = app.gesture?.matrix ?? IDENTITY;
    const [left, top, right, bottom] = app.selectionBox;
    const corners = [this.toStage(a * left + e, d * top + f), this.toStage(a * right + e, d * bottom + f)];
    return [0, 1].map((axis) => Math.min(...corners.map((c) => c[axis])))
      .concat([0, 1].map((axis) => Math.max(...corners.map((c) => c[axis]))));
  }

  /** Returns the corners of the selection's box: left top, right top, right bottom, left bottom. */
  handles() {
    const [left, top, right, bottom] = this.selectionBox();
    return [[left, top], [right, top], [right, bottom], [left, bottom]];
  }

  drawBand() {
    const [left, top, right, bottom] = this.band;
    this.marks.fillStyle = `color-mix(in srgb, ${this.accent} 14%, transparent)`;
    this.marks.fillRect(left, top, right - left, bottom - top);
    this.strokeTwice(() => this.marks.strokeRect(left, top, right - left, bottom - top), []);
  }

  drawStroke() {
    const { marks, app } = this;
    Object.assign(marks, { lineWidth: app.brush.width * this.view.scale, lineCap: "round", lineJoin: "round" });
    marks.strokeStyle = app.brush.fill;
    marks.globalAlpha = app.brush.opacity;
    marks.beginPath();
    for (const point of this.stroke) marks.lineTo(...this.toStage(...point));
    if (this.stroke.length === 1) marks.lineTo(...this.toStage(...this.stroke[0]));
    marks.stroke();
    marks.globalAlpha = 1;
  }

  /** Returns the visible colour "#rrggbb" at x, y of the stage; null outside the picture. */
  colorAt(x, y) {
    this.probe ??= newCanvas(1, 1).context;
    this.probe.clearRect(0, 0, 1, 1);
    this.probe.drawImage(this.art, -Math.floor(x * this.ratio), -Math.floor(y * this.ratio));
    const pixel = this.probe.getImageData(0, 0, 1, 1).data;
    return pixel[3] ? hexColor([...pixel.slice(0, 3)]) : null;
  }
}
