/* A cross on the drawing that keys move. It presses and drags as a mouse does, so that whatever a mouse can do on the
 * picture, keys can too. */

import { ARROWS } from "viewer/keys.js";
import { formatNumber } from "viewer/paths.js";

const CARET_STEP_PX = 10;
const FINE_STEP_PX = 1;

export class Caret {
  constructor(app) {
    this.app = app;
    this.isOn = false;
    this.isDown = false;
    this.at = [0, 0];
  }

  toggle() {
    if (this.isOn) this.leave();
    else this.enter();
  }

  /** Puts the cross on the middle of the selection, if it is in view, else of the stage. */
  enter() {
    const { stage, selection } = this.app;
    const [left, top, right, bottom] = selection.size ? stage.selectionBox() : [0, 0, stage.width, stage.height];
    const middle = [(left + right) / 2, (top + bottom) / 2];
    const isInView = middle[0] > 0 && middle[1] > 0 && middle[0] < stage.width && middle[1] < stage.height;
    this.at = isInView ? middle : [stage.width / 2, stage.height / 2];
    this.isOn = true;
    this.publish();
    this.app.say("Cross on: arrows move it, Enter clicks, Space presses and releases, Esc ends");
    this.app.refresh();
  }

  leave() {
    if (this.isDown) this.app.pointer.cancel();
    [this.isOn, this.isDown] = [false, false];
    this.app.say("Cross off");
    this.app.refresh();
  }

  /** Takes a key; returns whether it was one for the cross. */
  key(event) {
    const arrow = ARROWS[event.key];
    if (arrow) this.move(arrow, event);
    else if (event.key === "Enter") this.click(event);
    else if (event.key === " ") this.switch(event);
    else if (event.key === "Escape") this.leave();
    else return false;
    return true;
  }

  move([x, y], event) {
    const { stage, pointer } = this.app;
    const step = event.ctrlKey ? FINE_STEP_PX : CARET_STEP_PX * (event.shiftKey ? 5 : 1);
    const [width, height] = [stage.width, stage.height];
    this.at = [Math.min(Math.max(this.at[0] + x * step, 0), width), Math.min(Math.max(this.at[1] + y * step, 0), height)];
    pointer.move(this.event(event, false));
    this.publish();
    stage.request();
  }

  /** Tells tests where the cross is. */
  publish() {
    this.app.pointer.surface.dataset.caret = this.at.join(" ");
  }

  click(event) {
    if (this.isDown) return;
    this.app.pointer.down(this.event(event));
    this.app.pointer.up(this.event(event));
    this.report();
  }

  switch(event) {
    this.isDown = !this.isDown;
    if (this.isDown) this.app.pointer.down(this.event(event));
    else this.app.pointer.up(this.event(event));
    this.report();
  }

  report() {
    const { app } = this;
    const place = app.stage.toUser(...this.at).map((value) => formatNumber(value, 1)).join(", ");
    const chosen = app.nodes.path ? app.nodes.describe() : app.panel.editing.selectionText();
    app.say(`${this.isDown ? "Pressed" : "Released"} at ${place}: ${chosen}`);
  }

  /** Returns an event as of a mouse at the cross. Shift + arrows are large steps, so they do not count as Shift. */
  event({ shiftKey, altKey, ctrlKey }, withShift = true) {
    const { left, top } = this.app.pointer.surface.getBoundingClientRect();
    const [clientX, clientY] = [this.at[0] + left, this.at[1] + top];
    return { button: 0, clientX, clientY, shiftKey: withShift && shiftKey, altKey, ctrlKey, pointerId: null, pointerType: "keys" };
  }
}
