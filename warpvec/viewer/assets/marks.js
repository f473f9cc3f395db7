/* Draws marks above the picture: outlines of the selection, its handles, the rubber band, the stroke of the brush. */

import { multiply } from "viewer/basics.js";
import { path2dOf } from "viewer/paths.js";
import { IDENTITY } from "viewer/read.js";

export const MAX_OUTLINES = 300;
const MAX_OUTLINES_MOVING = 40;
const HANDLE_RADIUS = 4.5;
const TURN_HANDLE_PX = 26;
const CARET_PX = 11;
const ERASER_OPACITY = 0.7;

export class Marks {
  constructor(app, stage, canvas) {
    this.app = app;
    this.stage = stage;
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    const forget = () => (this.accent = null);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", forget);
    new MutationObserver(forget).observe(document.documentElement, { attributes: true });
  }

  draw() {
    const { context, canvas, app, stage } = this;
    context.setTransform(...IDENTITY);
    context.clearRect(0, 0, canvas.width, canvas.height);
    this.accent ??= getComputedStyle(canvas).color;
    if (app.selection.size) this.drawOutlines();
    context.setTransform(stage.ratio, 0, 0, stage.ratio, 0, 0);
    if (app.nodes.path) this.drawPoints();
    else if (app.selection.size && app.tool !== "node") this.drawBox();
    if (stage.band) this.drawBand();
    if (stage.stroke) this.drawStroke();
    if (app.caret.isOn) this.drawCaret();
  }

  drawOutlines() {
    const { context, app, stage } = this;
    if (app.selection.size > (app.gesture ? MAX_OUTLINES_MOVING : MAX_OUTLINES)) return;
    const placed = multiply(stage.matrix, app.gesture?.matrix ?? IDENTITY);
    for (const [width, color] of [[3, "rgb(255 255 255 / 0.75)"], [1.4, this.accent]]) {
      context.setTransform(...placed);
      context.lineWidth = (width * stage.ratio) / Math.hypot(placed[0], placed[1]);
      context.strokeStyle = color;
      for (const item of app.selection) context.stroke(path2dOf(item.shape));
    }
  }

  drawBox() {
    const [left, top, right, bottom] = this.stage.selectionBox();
    this.strokeTwice(() => this.context.strokeRect(left, top, right - left, bottom - top), [4, 3]);
    for (const { x, y } of this.handles()) this.drawDot(x, y);
  }

  drawDot(x, y, fill = "#fff") {
    const { context } = this;
    context.beginPath();
    context.arc(x, y, HANDLE_RADIUS, 0, 2 * Math.PI);
    context.fillStyle = fill;
    context.fill();
    context.stroke();
  }

  strokeTwice(stroke, dash) {
    const { context } = this;
    [context.lineWidth, context.strokeStyle] = [3, "rgb(255 255 255 / 0.6)"];
    stroke();
    context.setLineDash(dash);
    [context.lineWidth, context.strokeStyle] = [1.4, this.accent];
    stroke();
    context.setLineDash([]);
  }

  /** Returns the handles of the selection: the corners of its box, clockwise from the left top, and one to turn it. */
  handles() {
    const [left, top, right, bottom] = this.stage.selectionBox();
    const corners = [[left, top], [right, top], [right, bottom], [left, bottom]].map(([x, y], corner) => ({ x, y, corner }));
    const y = Math.max(top - TURN_HANDLE_PX, 2 * HANDLE_RADIUS);
    return [...corners, { x: (left + right) / 2, y, corner: "turn" }];
  }

  /** Draws nodes: round if they are smooth, else square; filled if they are chosen, with their handles. */
  drawPoints() {
    const { context, app, stage } = this;
    const { nodes, chosen, current } = app.nodes;
    [context.strokeStyle, context.lineWidth] = [this.accent, 1.4];
    for (const point of app.nodes.shownPoints()) {
      const [x, y] = stage.toStage(point.x, point.y);
      const isNode = point.kind === "node";
      const isCurrent = current?.kind === point.kind && current.index === point.index;
      if (point.kind === "before" || point.kind === "after") this.drawArm(nodes[point.index], x, y);
      const fill = isCurrent || (isNode && chosen.has(point.index)) ? this.accent : "#fff";
      if (isNode && !nodes[point.index].isSmooth) this.drawSquare(x, y, fill, 0);
      else if (point.kind === "gradient") this.drawSquare(x, y, fill, Math.PI / 4);
      else this.drawDot(x, y, fill);
    }
  }

  drawArm({ x, y }, handleX, handleY) {
    const { context, stage } = this;
    context.beginPath();
    context.moveTo(...stage.toStage(x, y));
    context.lineTo(handleX, handleY);
    context.stroke();
  }

  drawSquare(x, y, fill, angle) {
    const { context } = this;
    context.save();
    context.translate(x, y);
    context.rotate(angle);
    context.fillStyle = fill;
    context.fillRect(-HANDLE_RADIUS, -HANDLE_RADIUS, 2 * HANDLE_RADIUS, 2 * HANDLE_RADIUS);
    context.strokeRect(-HANDLE_RADIUS, -HANDLE_RADIUS, 2 * HANDLE_RADIUS, 2 * HANDLE_RADIUS);
    context.restore();
  }

  /** Draws the cross that keys move. */
  drawCaret() {
    const { context, app } = this;
    const [x, y] = app.caret.at;
    context.beginPath();
    for (const [dx, dy] of [[CARET_PX, 0], [0, CARET_PX]]) {
      context.moveTo(x - dx, y - dy);
      context.lineTo(x + dx, y + dy);
    }
    this.strokeTwice(() => context.stroke(), []);
  }

  drawBand() {
    const { context, stage } = this;
    const [left, top, right, bottom] = stage.band;
    context.fillStyle = `color-mix(in srgb, ${this.accent} 14%, transparent)`;
    context.fillRect(left, top, right - left, bottom - top);
    this.strokeTwice(() => context.strokeRect(left, top, right - left, bottom - top), []);
  }

  drawStroke() {
    const { context, app, stage } = this;
    if (app.tool === "lasso") {
      context.beginPath();
      for (const point of stage.stroke) context.lineTo(...stage.toStage(...point));
      context.closePath();
      this.strokeTwice(() => context.stroke(), [4, 3]);
      return;
    }
    Object.assign(context, { lineWidth: app.brush.width * stage.view.scale, lineCap: "round", lineJoin: "round" });
    const isEraser = app.tool === "eraser";
    context.strokeStyle = isEraser ? "#ffffff" : app.brush.fill;
    context.globalAlpha = isEraser ? ERASER_OPACITY : app.brush.opacity;
    context.beginPath();
    for (const point of stage.stroke) context.lineTo(...stage.toStage(...point));
    if (stage.stroke.length === 1) context.lineTo(...stage.toStage(...stage.stroke[0]));
    context.stroke();
    context.globalAlpha = 1;
  }
}
