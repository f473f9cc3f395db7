/* Pointer tools: select, move, scale, turn, edit nodes, paint, pick a colour, pan. */

import { rotation, scaling, translation } from "viewer/basics.js";
import { distance } from "viewer/brush.js";
import { MAX_OUTLINES } from "viewer/marks.js";
import { boxContains, boxesMeet } from "viewer/paths.js";
import { Pinch } from "viewer/pinch.js";

const DRAG_PX = 4;
const HANDLE_REACH_PX = 9;
// A finger hides what it points at.
const TOUCH_REACH_PX = 20;
const TURN_STEP = Math.PI / 12;
const BRUSH_STEP_PX = 2;
// Tools that follow the pointer.
const STROKES = new Set(["brush", "lasso", "eraser"]);

export class Pointer {
  constructor(app, surface) {
    this.app = app;
    this.surface = surface;
    this.drag = null;
    this.pinch = new Pinch(app.stage);
    surface.addEventListener("pointerdown", (event) => this.down(event));
    surface.addEventListener("pointermove", (event) => this.move(event));
    surface.addEventListener("pointerup", (event) => this.up(event));
    surface.addEventListener("pointercancel", (event) => {
      this.pinch.up(event);
      this.cancel();
    });
    surface.addEventListener("dblclick", (event) => app.nodes.addNear(this.at(event), HANDLE_REACH_PX));
    surface.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
  }

  at(event) {
    const { left, top } = this.surface.getBoundingClientRect();
    return [event.clientX - left, event.clientY - top];
  }

  down(event) {
    const start = this.at(event);
    if (this.pinch.down(event, start)) this.cancel();
    if (this.drag || this.pinch.isOn || event.button > 1) return;
    this.app.endKeys();
    if (event.pointerId !== null) {
      this.surface.focus({ preventScroll: true });
      this.surface.setPointerCapture(event.pointerId);
    }
    const { kind, point } = this.kindOf(event, start);
    this.drag = { start, last: start, event, kind, point, moved: false };
    if (kind === "point") this.app.nodes.choose(point, event.shiftKey || this.app.adding);
    if (STROKES.has(kind)) this.app.stage.stroke = [this.app.stage.toUser(...start)];
    if (this.drag.kind === "pick") this.app.pickColor(start);
    this.app.stage.request();
  }

  /** Returns the kind of action that a press starts, and the point of the path that it takes, if it does.
   *
   * On a selected path a press moves the selection, elsewhere it spans a band. */
  kindOf(event, start) {
    const { app } = this;
    const reach = event.pointerType === "touch" ? TOUCH_REACH_PX : HANDLE_REACH_PX;
    if (event.button === 1 || app.panning) return { kind: "pan" };
    if (app.tool === "node") {
      const point = app.nodes.pointAt(start, reach);
      return { kind: point ? "point" : "band", point };
    }
    if (app.tool !== "select") return { kind: app.tool };
    if (app.selection.size && !event.shiftKey) {
      const handle = app.stage.marks.handles().find(({ x, y }) => distance([x, y], start) < reach);
      if (handle) return { kind: handle.corner };
      if (app.pathsAt(start).some((item) => app.selection.has(item))) return { kind: "move" };
    }
    return { kind: "band" };
  }

  move(event) {
    const { drag, app } = this;
    const now = this.at(event);
    this.pinch.move(event, now);
    if (!drag) {
      if (event.pointerType === "mouse") this.hover(event);
      return;
    }
    if (!drag.moved && distance(now, drag.start) < DRAG_PX) return;
    drag.moved = true;
    if (drag.kind === "pan") app.stage.pan(now[0] - drag.last[0], now[1] - drag.last[1]);
    else if (drag.kind === "band") this.stretchBand(now);
    else if (STROKES.has(drag.kind)) this.extendStroke(event);
    else if (drag.kind === "pick") app.pickColor(now);
    else if (drag.kind === "point") this.movePoint(drag, event, now);
    else this.transform(event, now);
    drag.last = now;
  }

  hover(event) {
    const { app, surface } = this;
    const cursors = { select: "default", node: "default", pan: "grab" };
    let cursor = cursors[app.panning ? "pan" : app.tool] ?? "crosshair";
    if (app.tool === "select" && app.selection.size && app.selection.size <= MAX_OUTLINES) {
      const { kind } = this.kindOf(event, this.at(event));
      if (typeof kind === "number") cursor = kind % 2 ? "nesw-resize" : "nwse-resize";
      else if (kind === "move") cursor = "move";
      else if (kind === "turn") cursor = "grab";
    }
    surface.style.cursor = cursor;
  }

  stretchBand(now) {
    const { start } = this.drag;
    const low = [0, 1].map((axis) => Math.min(start[axis], now[axis]));
    const high = [0, 1].map((axis) => Math.max(start[axis], now[axis]));
    this.app.stage.band = [...low, ...high];
    this.app.stage.request();
  }

  extendStroke(event) {
    const { stage } = this.app;
    const { left, top } = this.surface.getBoundingClientRect();
    const events = event.getCoalescedEvents?.() ?? [];
    for (const { clientX, clientY } of events.length ? events : [event]) {
      const point = stage.toUser(clientX - left, clientY - top);
      if (distance(point, stage.stroke.at(-1)) * stage.view.scale >= BRUSH_STEP_PX) stage.stroke.push(point);
    }
    stage.request();
  }

  /** Moves a node, a handle or an end of a gradient; Shift keeps it on one axis. */
  movePoint({ start, point }, event, now) {
    const { scale } = this.app.stage.view;
    const by = [(now[0] - start[0]) / scale, (now[1] - start[1]) / scale];
    if (event.shiftKey) by[Math.abs(by[0]) < Math.abs(by[1]) ? 0 : 1] = 0;
    this.app.nodes.drag(point, ...by);
  }

  /** Moves, scales or turns the selection. Shift keeps a move on one axis, frees the proportions of a scale, and turns in
   * steps of 15 degrees. */
  transform(event, now) {
    const { drag, app } = this;
    const label = { move: "Move", turn: "Turn" }[drag.kind] ?? "Scale";
    app.begin(label);
    if (!app.gesture) return;
    drag.from ??= app.stage.toUser(...drag.start);
    const to = app.stage.toUser(...now);
    if (drag.kind === "turn") {
      app.gesture.place(turnBetween(app.selectionBox, drag.from, to, event.shiftKey));
      return;
    }
    if (drag.kind === "move") {
      const by = [to[0] - drag.from[0], to[1] - drag.from[1]];
      if (event.shiftKey) by[Math.abs(by[0]) < Math.abs(by[1]) ? 0 : 1] = 0;
      app.gesture.place(translation(...by));
    } else {
      app.gesture.place(scaleFrom(app.selectionBox, drag.kind, to, event.shiftKey));
    }
  }

  up(event) {
    const { drag, app } = this;
    this.pinch.up(event);
    if (!drag) return;
    this.drag = null;
    if (drag.kind === "band") this.finishBand(drag, event);
    else if (STROKES.has(drag.kind)) this.finishStroke(drag.kind);
    else if (app.gesture) app.end();
    else if (!drag.moved && drag.kind === "move") this.click(drag, event);
  }

  finishBand(drag, event) {
    const { app } = this;
    const band = app.stage.band;
    app.stage.band = null;
    if (!band) {
      this.click(drag, event);
      return;
    }
    const box = [...app.stage.toUser(band[0], band[1]), ...app.stage.toUser(band[2], band[3])];
    if (app.nodes.path) {
      app.nodes.chooseIn(box, event.shiftKey || app.adding);
      return;
    }
    const meets = event.altKey ? boxesMeet : boxContains;
    const found = app.pickable.filter((item) => meets(box, item.shape.box));
    app.select(event.shiftKey || app.adding ? [...app.selection, ...found] : found);
  }

  /** Selects the topmost path under the pointer. Shift adds or removes it, Alt selects the one below. */
  click({ start }, event) {
    const { app } = this;
    const found = app.pathsAt(start);
    if (app.nodes.path && (!found.length || app.selection.has(found[0])) && !event.altKey) {
      app.nodes.clear();
      return;
    }
    if ((event.shiftKey || app.adding) && app.tool !== "node") {
      const [top] = found;
      const rest = [...app.selection].filter((item) => item !== top);
      app.select(rest.length < app.selection.size || !top ? rest : [...rest, top]);
      return;
    }
    const current = found.findIndex((item) => app.selection.has(item));
    const next = event.altKey ? (current + 1) % Math.max(found.length, 1) : 0;
    app.select(found.slice(next, next + 1));
  }

  finishStroke(kind) {
    const { app } = this;
    const { stroke } = app.stage;
    app.stage.stroke = null;
    if (kind === "brush") app.addStroke(stroke);
    else app.eraser.run(kind, stroke);
  }

  /** Cancels the current action. */
  cancel() {
    const { app, drag } = this;
    this.drag = null;
    app.stage.band = app.stage.stroke = null;
    app.cancel();
    app.stage.request();
    return Boolean(drag);
  }

  wheel(event) {
    event.preventDefault();
    const { stage } = this.app;
    if (event.shiftKey) stage.pan(-(event.deltaY || event.deltaX), 0);
    else stage.zoom(Math.exp(-Math.sign(event.deltaY) * Math.min(Math.abs(event.deltaY), 120) * 0.0018), ...this.at(event));
  }
}

/** Returns the matrix that moves corner `handle` of `box` to the point `to` and keeps the opposite corner. */
function scaleFrom(box, handle, to, free) {
  const right = handle === 1 || handle === 2;
  const below = handle >= 2;
  const [x, y] = [right ? box[0] : box[2], below ? box[1] : box[3]];
  const [cornerX, cornerY] = [right ? box[2] : box[0], below ? box[3] : box[1]];
  const factor = (from, fixed, now) => Math.max((now - fixed) / (from - fixed || 1e-9), 0.01);
  let [sx, sy] = [factor(cornerX, x, to[0]), factor(cornerY, y, to[1])];
  if (!free) sx = sy = Math.max(sx, sy);
  return scaling(sx, sy, x, y);
}

/** Returns the rotation around the middle of `box` from one point to another. */
function turnBetween(box, from, to, inSteps) {
  const [x, y] = [(box[0] + box[2]) / 2, (box[1] + box[3]) / 2];
  const angle = Math.atan2(to[1] - y, to[0] - x) - Math.atan2(from[1] - y, from[0] - x);
  return rotation(inSteps ? TURN_STEP * Math.round(angle / TURN_STEP) : angle, x, y);
}
