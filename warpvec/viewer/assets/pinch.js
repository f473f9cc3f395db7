/* Two fingers zoom and move the view. */

import { distance } from "viewer/brush.js";

export class Pinch {
  constructor(stage) {
    this.stage = stage;
    this.fingers = new Map();
  }

  /** Notes a finger; returns whether there are two now. */
  down({ pointerId, pointerType }, point) {
    if (pointerType === "touch") this.fingers.set(pointerId, point);
    return this.isOn;
  }

  get isOn() {
    return this.fingers.size > 1;
  }

  move({ pointerId }, point) {
    if (!this.fingers.has(pointerId)) return;
    const before = this.grip();
    this.fingers.set(pointerId, point);
    if (!before) return;
    const after = this.grip();
    this.stage.pan(after.x - before.x, after.y - before.y);
    this.stage.zoom(after.gap / before.gap, after.x, after.y);
  }

  up({ pointerId }) {
    this.fingers.delete(pointerId);
  }

  /** Returns the middle and the distance of the first two fingers. */
  grip() {
    const [a, b] = [...this.fingers.values()];
    return b && { x: (a[0] + b[0]) / 2, y: (a[1] + b[1]) / 2, gap: Math.max(distance(a, b), 1) };
  }
}
