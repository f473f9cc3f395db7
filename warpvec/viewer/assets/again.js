/* "Fit again": hands the edited drawing to the page that runs fits, if there is one; see live.js. Paths of locked layers
 * stay as they are, and so do edited ones if the user wants that. */

import { sameState } from "viewer/changes.js";
import { find, setText } from "viewer/dom.js";
import { writeShape } from "viewer/paths.js";
import { decimalsFor, writeDrawing } from "viewer/save.js";

export class FitAgain {
  constructor(app) {
    this.app = app;
    // Path data of paths that stayed as edited in an earlier fit: they count as edited afterwards.
    this.kept = new Set();
    find("fit-again").addEventListener("click", () => this.run());
  }

  get items() {
    return this.app.drawing.layers.flatMap(({ items }) => items);
  }

  isEdited(item) {
    return !item.origin || !sameState(item, item.origin) || this.kept.has(item.shape.d);
  }

  run() {
    const { app } = this;
    if (!app.mayChange()) return;
    const text = writeDrawing(app.drawing);
    const isKept = (item) => find("keep-edited").checked && this.isEdited(item);
    const isLocked = (item) => item.layer.isLocked || isKept(item);
    const decimals = decimalsFor(app.drawing.box);
    this.kept = new Set(this.items.filter(isKept).map(({ shape }) => writeShape(shape, decimals)));
    window.desk.fitAgain(text, this.items.flatMap((item, index) => (isLocked(item) ? [index] : [])));
  }

  show() {
    const { app } = this;
    find("fit-again-box").hidden = !window.desk?.fitAgain;
    if (find("fit-again-box").hidden) return;
    const count = this.items.filter((item) => this.isEdited(item)).length;
    find("fit-again").disabled = app.live.isOn;
    setText("edited-count", count ? `${count.toLocaleString("en")} edited` : "No path is edited");
  }
}
