/* The controls that change the selection, its paint, its place and its nodes. */

import { connectClicks, find, onInput, setText, setValue } from "viewer/dom.js";
import { endColors, isGradient, paintOf, withPaint } from "viewer/gradients.js";
import { MAX_SHOWN_POINTS } from "viewer/nodetool.js";
import { asKind } from "viewer/paints.js";
import { formatNumber, grownBox } from "viewer/paths.js";
import { removeBackground, useBrand } from "viewer/wholecolors.js";
import { selectAlike, selectAll, selectNext } from "viewer/selecting.js";

// The controls that a brush does not have.
const OF_PATHS_ALONE = new Set(["end", "softness"]);

// The blur at the end of the slider, in user units.
const MAX_SOFTNESS = 30;

export class EditPanel {
  constructor(app) {
    this.app = app;
    this.connectPaint();
    this.connectSelection();
    this.connectNodes();
    this.connectPlace();
  }

  show() {
    this.showSelection();
    this.showNodes();
    this.showPlace();
  }

  /** Lets the selection follow a dragged control; releasing it makes one command. */
  connectPaint() {
    const { app } = this;
    const follow = (id, label, read) => {
      onInput(id, (value) => {
        if (!OF_PATHS_ALONE.has(id)) Object.assign(app.brush, read(value));
        app.begin(label);
        app.gesture?.paint(read(value));
        app.panel.request();
      });
      find(id).addEventListener("change", () => app.end());
    };
    follow("fill", "Recolour", (fill) => ({ fill }));
    follow("end", "Recolour", (endFill) => ({ endFill }));
    follow("opacity", "Opacity", (value) => ({ opacity: Number(value) }));
    follow("softness", "Softness", (value) => ({ softness: Number(value) }));
    onInput("width", (value) => {
      app.brush.width = Number(value);
      app.panel.request();
    });
  }

  connectSelection() {
    const { app } = this;
    const { editor } = app;
    connectClicks({
      "select-all": () => selectAll(app), "select-none": () => app.select([]), adding: () => app.setAdding(!app.adding),
      "path-last": () => selectNext(app, -1), "path-next": () => selectNext(app, 1),
      "same-fill": () => selectAlike(app, "fill"), "same-layer": () => selectAlike(app, "layer"), delete: () => editor.remove(),
      front: () => editor.reorder("front"), raise: () => editor.reorder("raise"), lower: () => editor.reorder("lower"),
      back: () => editor.reorder("back"), "scale-apply": () => editor.scale(find("scale").valueAsNumber / 100),
      "turn-apply": () => editor.turn(find("turn").valueAsNumber), group: () => editor.group(), ungroup: () => editor.ungroup(),
      "layer-up": () => editor.moveLayer(1), "layer-down": () => editor.moveLayer(-1), caret: () => app.toggleCaret(),
      simplify: () => editor.simplify(find("tolerance").valueAsNumber),
      "remove-background": () => removeBackground(app), "brand-apply": () => useBrand(app, find("brand").value),
    });
  }

  connectNodes() {
    const { nodes } = this.app;
    connectClicks({
      "node-last": () => nodes.step(-1), "node-next": () => nodes.step(1), "node-add": () => nodes.add(),
      "node-delete": () => nodes.remove(), "node-smooth": () => nodes.smooth(), "node-corner": () => nodes.corner(),
      "node-line": () => nodes.switchLine(),
    });
    for (const axis of ["x", "y"]) {
      find(`node-${axis}`).addEventListener("change", () => nodes.put(axis, find(`node-${axis}`).valueAsNumber));
    }
  }

  connectPlace() {
    for (const name of ["x", "y", "width", "height"]) {
      const field = find(`box-${name}`);
      field.addEventListener("change", () => this.app.editor.place({ [name]: field.valueAsNumber }));
    }
    find("layer-name").addEventListener("change", () => this.app.editor.renameLayer(find("layer-name").value.trim()));
    onInput("kind", (kind) => {
      this.app.editor.each("Fill", (item) => Object.assign(item, withPaint(item, asKind(paintOf(item), kind, paintedBox(item)))));
    });
  }

  showSelection() {
    const { app } = this;
    const count = app.selection.size;
    const [first] = app.selection;
    const { fill, opacity } = first ? { fill: paintOf(first), opacity: first.opacity } : app.brush;
    const gradient = [...app.selection].map(paintOf).find(isGradient);
    if (document.activeElement !== find("layer-name")) find("layer-name").value = first?.layer.name ?? "";
    setText("selected", this.selectionText());
    find("kind-field").hidden = !first;
    if (first) find("kind").value = isGradient(fill) ? fill.kind : "flat";
    for (const [id, isOn] of [["adding", app.adding], ["caret", app.caret.isOn]]) find(id).setAttribute("aria-pressed", isOn);
    const [start] = endColors(fill);
    const [, end] = endColors(gradient ?? start);
    setValue("fill", start, start);
    setValue("end", end, end);
    find("end-field").hidden = !gradient;
    setValue("opacity", opacity, opacity.toFixed(2));
    const softness = first?.softness ?? 0;
    find("softness-field").hidden = !first;
    // A softer path than the slider reaches keeps its place on it.
    find("softness").max = String(Math.max(MAX_SOFTNESS, Math.ceil(softness)));
    setValue("softness", softness, `${formatNumber(softness, 1)} px`);
    setValue("width", app.brush.width, `${app.brush.width} px`);
    find("brush-layer").selectedIndex = app.drawing.layers.indexOf(app.brush.layer);
    find("filter").selectedIndex = app.drawing.layers.indexOf(app.filter) + 1;
    for (const id of ["arrange", "delete", "select-none"]) find(id).disabled = !count;
  }

  selectionText() {
    const { selection, pathCount } = this.app;
    const [first] = selection;
    const text = `${selection.size.toLocaleString("en")} of ${pathCount.toLocaleString("en")} paths selected`;
    return selection.size > 1 ? text : first ? `${text}: ${first.layer.name}` : "Nothing selected";
  }

  showNodes() {
    const { nodes, tool } = this.app;
    find("node-box").hidden = tool !== "node";
    // Tells tests where the points are, in user units.
    const points = nodes.points().slice(0, MAX_SHOWN_POINTS);
    find("surface").dataset.points = points.map(({ kind, index, x, y }) => `${kind} ${index} ${x} ${y}`).join(",");
    if (tool !== "node") return;
    setText("node-text", nodes.describe());
    const { path, currentPoint: point, chosen } = nodes;
    for (const axis of ["x", "y"]) {
      find(`node-${axis}`).disabled = !point;
      find(`node-${axis}`).value = point ? numberText(point[axis]) : "";
    }
    for (const id of ["delete", "smooth", "corner", "line"]) find(`node-${id}`).disabled = !chosen.size;
    for (const id of ["last", "next", "add"]) find(`node-${id}`).disabled = !path;
  }

  showPlace() {
    const { app } = this;
    const [left, top, right, bottom] = app.selectionBox;
    const values = { x: left, y: top, width: right - left, height: bottom - top };
    for (const [name, value] of Object.entries(values)) {
      const field = find(`box-${name}`);
      const text = app.selection.size ? numberText(value) : "";
      if (field.value !== text && document.activeElement !== field) field.value = text;
    }
  }
}

/** Returns the box that a fill covers, or a stroke without one. */
function paintedBox({ shape, fill, stroke }) {
  return fill || !stroke ? shape.box : grownBox(shape.box, stroke.width / 2);
}

/** Returns the text of a number for a field. One that is not finite, as of a path without a place, has none. */
function numberText(value) {
  return Number.isFinite(value) ? String(Number(value.toFixed(3))) : "";
}
