/* The node tool: it chooses and moves nodes, handles and ends of the gradient of the one selected path.
 *
 * A point is {kind, index, x, y}: a "node", its handle "before" or "after", or a "gradient" end. A circle, an ellipse or
 * a rectangle has no nodes but points of the kind "form", which change its numbers. */

import { distance } from "viewer/brush.js";
import { formPoints, moveFormPoint } from "viewer/formpoints.js";
import { FORM_NAMES, shapeOfForm } from "viewer/forms.js";
import { paintOf, withPaint } from "viewer/gradients.js";
import {
  addNode, cornerNodes, moveHandle, moveNodes, nearestPlace, neighbours, nodesOf, removeNodes, smoothNodes,
  switchLines,
} from "viewer/nodes.js";
import { gradientPoints, moveGradientPoint } from "viewer/paints.js";
import { boxContains, formatNumber } from "viewer/paths.js";

// More points than this cannot be told apart on a screen, and would take longer than a frame.
export const MAX_SHOWN_POINTS = 1500;

export class NodeTool {
  constructor(app) {
    this.app = app;
    this.item = null;
    this.chosen = new Set();
    this.current = null;
  }

  /** The path whose nodes are shown; null with another tool, or if not exactly one path is selected. */
  get path() {
    const { app } = this;
    const item = app.tool === "node" && app.selection.size === 1 ? [...app.selection][0] : null;
    if (item !== this.item) [this.item, this.chosen, this.current] = [item, new Set(), null];
    const count = item && !item.shape.form ? nodesOf(item.shape).length : 0;
    this.chosen = new Set([...this.chosen].filter((index) => index < count));
    const isGone = this.current?.kind === "form" ? !item?.shape.form : this.current?.index >= count;
    if (this.current?.kind !== "gradient" && isGone) this.current = null;
    return item;
  }

  /** The nodes of the path; a form has none. */
  get nodes() {
    const { shape } = this.path;
    return shape.form ? [] : nodesOf(shape);
  }

  get form() {
    return this.path?.shape.form ?? null;
  }

  /** Returns all points in the order in which keys step through them. Handles that lie on their node are left out. */
  points() {
    const { path } = this;
    if (!path) return [];
    const of = (node, kind) => {
      const place = kind === "node" ? [node.x, node.y] : node[kind];
      const isHidden = !place || (kind !== "node" && distance(place, [node.x, node.y]) < 1e-6);
      return isHidden ? [] : [{ kind, index: node.index, x: place[0], y: place[1] }];
    };
    const ofNodes = this.nodes.flatMap((node) => ["node", "before", "after"].flatMap((kind) => of(node, kind)));
    const ofForm = this.form ? formPoints(this.form).map(({ x, y }, index) => ({ kind: "form", index, x, y })) : [];
    const points = [...ofNodes, ...ofForm];
    return [...points, ...gradientPoints(paintOf(path)).map(([x, y], index) => ({ kind: "gradient", index, x, y }))];
  }

  /** Returns the points that are drawn: handles only of chosen nodes and of the one under the keys. */
  shownPoints() {
    const isShown = ({ kind, index }) => !HANDLES.has(kind) || this.chosen.has(index) || this.current?.index === index;
    return this.points().filter(isShown).slice(0, MAX_SHOWN_POINTS);
  }

  /** Returns the shown point nearest to x, y of the stage within `reach`; handles come before nodes. */
  pointAt([x, y], reach) {
    const { stage } = this.app;
    const far = (point) => distance(stage.toStage(point.x, point.y), [x, y]) + (point.kind === "node" ? 1 : 0);
    const near = this.shownPoints().filter((point) => far(point) <= reach).sort((a, b) => far(a) - far(b));
    return near[0] ?? null;
  }

  /** The current point where it is now; null without one. */
  get currentPoint() {
    const { current } = this;
    return (current && this.points().find(({ kind, index }) => kind === current.kind && index === current.index)) ?? null;
  }

  choose(point, isAdded = false) {
    this.current = point;
    if (point.kind === "node") {
      const wasChosen = this.chosen.has(point.index);
      if (!isAdded && !wasChosen) this.chosen = new Set();
      if (isAdded && wasChosen) this.chosen.delete(point.index);
      else this.chosen.add(point.index);
    }
    this.app.refresh();
    this.app.say(this.describe());
  }

  chooseIn(box, isAdded) {
    const inside = this.nodes.filter(({ x, y }) => boxContains(box, [x, y, x, y])).map(({ index }) => index);
    this.chosen = new Set(isAdded ? [...this.chosen, ...inside] : inside);
    this.current = null;
    this.app.refresh();
  }

  chooseAll() {
    this.chooseIn([-Infinity, -Infinity, Infinity, Infinity], false);
  }

  clear() {
    const hadPoints = this.chosen.size > 0 || this.current !== null;
    [this.chosen, this.current] = [new Set(), null];
    this.app.refresh();
    return hadPoints;
  }

  /** Chooses the next point (1) or the one before (-1). */
  step(by) {
    const points = this.points();
    if (!points.length) return;
    const { current } = this;
    const at = points.findIndex(({ kind, index }) => kind === current?.kind && index === current?.index);
    const point = points[at < 0 ? (by > 0 ? 0 : points.length - 1) : (at + by + points.length) % points.length];
    if (point.kind === "node") this.chosen = new Set();
    this.choose(point);
  }

  describe() {
    if (!this.path) return "Select one path to see its nodes";
    const count = this.nodes.length;
    const point = this.currentPoint;
    if (!point && this.form) return `A ${FORM_NAMES[this.form.element]}: drag its handles`;
    if (!point) return this.chosen.size ? `${this.chosen.size} of ${count} nodes` : `${count} nodes`;
    const place = `at ${formatNumber(point.x, 2)}, ${formatNumber(point.y, 2)}`;
    if (point.kind === "gradient") return `${point.index ? "End" : "Start"} of the gradient ${place}`;
    if (point.kind === "form") return `${formPoints(this.form)[point.index].name} ${place}`;
    const node = `node ${point.index + 1} of ${count}`;
    if (point.kind !== "node") return `Handle ${point.kind} ${node} ${place}`;
    return `N${node.slice(1)}, ${this.nodes[point.index].isSmooth ? "smooth" : "corner"}, ${place}`;
  }

  /** Moves a point of the path as it was at the start of the gesture. */
  drag(point, dx, dy) {
    const { app } = this;
    app.begin(LABELS[point.kind]);
    if (app.gesture) app.gesture.reshape(this.moved(app.gesture.before.items.get(this.path), point, dx, dy));
  }

  /** Moves the current point, or all chosen nodes, by a key. */
  nudge(dx, dy) {
    const { app, path } = this;
    const point = this.current ?? (this.chosen.size ? { kind: "node", index: [...this.chosen][0] } : null);
    if (!path || !point) return false;
    app.begin(LABELS[point.kind]);
    app.gesture?.reshape(this.moved(path, point, dx, dy));
    app.gesture?.endSoon();
    app.panel.request();
    return true;
  }

  moved(item, { kind, index }, dx, dy) {
    const { shape } = item;
    if (kind === "gradient") return withPaint(item, moveGradientPoint(paintOf(item), index, dx, dy));
    if (kind === "form") return { shape: shapeOfForm(moveFormPoint(shape.form, index, dx, dy)) };
    if (kind === "node") return { shape: moveNodes(shape, new Set([...this.chosen, index]), dx, dy) };
    const [x, y] = nodesOf(shape)[index][kind];
    return { shape: moveHandle(shape, index, kind, x + dx, y + dy) };
  }

  /** Puts the "x" or "y" of the current point to a place of the drawing. */
  put(axis, value) {
    const { app } = this;
    app.endKeys();
    const by = value - this.currentPoint?.[axis];
    if (!by) return;
    this.nudge(axis === "x" ? by : 0, axis === "y" ? by : 0);
    app.endKeys();
  }

  /** Runs a change of the chosen nodes as one command. */
  change(label, change) {
    const { app, path } = this;
    if (!path || !this.chosen.size) return;
    app.endKeys();
    const shape = change(path.shape, this.chosen);
    if (shape.subpaths.length) app.commands.record(label, [path], [], () => (path.shape = shape));
    else app.editor.remove();
    app.say(path.shape === shape ? `${label}: ${this.describe()}` : label);
  }

  smooth() {
    this.change("Smooth", smoothNodes);
  }

  corner() {
    this.change("Corner", cornerNodes);
  }

  switchLine() {
    this.change("Line or curve", switchLines);
  }

  toggleSmooth() {
    if (!this.path || !this.chosen.size) return;
    const isSmooth = [...this.chosen].every((index) => this.nodes[index].isSmooth);
    if (isSmooth) this.corner();
    else this.smooth();
  }

  remove() {
    const chosen = this.chosen;
    this.change("Delete nodes", removeNodes);
    if (chosen.size) this.clear();
  }

  /** Says that a form has no nodes; returns whether the path is one. */
  refuses() {
    const { form, app } = this;
    if (form) app.say(`A ${FORM_NAMES[form.element]} has no nodes. "To path" gives it some`);
    return Boolean(form);
  }

  /** Adds a node in the middle of the segment after the chosen one. */
  add() {
    if (this.refuses()) return;
    const node = this.path && this.nodes[this.current?.index ?? [...this.chosen][0] ?? 0];
    if (!node) return;
    const segment = neighbours(this.path.shape.subpaths[node.loop], node.node)[1];
    if (segment !== null) this.addAt({ loop: node.loop, segment, t: 0.5 });
  }

  addAt({ loop, segment, t }) {
    const { app, path } = this;
    app.endKeys();
    app.commands.record("Add node", [path], [], () => (path.shape = addNode(path.shape, loop, segment, t)));
    const added = this.nodes.find((node) => node.loop === loop && node.node === segment + 1);
    this.chosen = new Set();
    if (added) this.choose({ kind: "node", index: added.index });
  }

  /** Adds a node where the outline is near x, y of the stage; returns whether it did. */
  addNear([x, y], reach) {
    if (!this.path) return false;
    const place = nearestPlace(this.path.shape, ...this.app.stage.toUser(x, y));
    const isNear = place.distance * this.app.stage.view.scale <= reach;
    if (isNear && this.refuses()) return false;
    if (isNear) this.addAt(place);
    return isNear;
  }
}

const HANDLES = new Set(["before", "after"]);
const LABELS = { form: "Change form", node: "Move node", before: "Move handle", after: "Move handle", gradient: "Move gradient" };
