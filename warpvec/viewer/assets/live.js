/* The page for other scripts: `window.warpvecView`, on which a page that runs fits is built.
 *
 *   open({svg, name, photo, history, figures})
 *       Shows another document and forgets all edits, undo steps and the selection. Resolves when it is shown. `photo` is
 *       the address of an image (data: or blob:), or null. `history` and `figures` may be missing.
 *   loadPhoto(address), show({svg, name, photo, history, figures})
 *       The same in two parts, of which the second one takes no time in between: `photo` is what the first one resolves
 *       to, or null.
 *   showDrawing(svgText)
 *       Shows a frame of a running fit. View, hidden layers and, by their places, the selected paths are kept. Until
 *       `endDrawing` nothing can be edited, and nothing is measured, which would take time from the fit. It costs about
 *       as much as parsing and drawing once; call it with the newest frame only.
 *   endDrawing(label = "Fit")
 *       Ends the frames: the last one is the drawing from now on, in one undo step named `label`. If it is `null`, the
 *       drawing from before the frames returns.
 *   showFigures({psnr, bytes, ...})
 *       Replaces some of the figures of the file that the page shows; null removes one.
 *   drawingText()       the SVG text of the drawing as edited, the same that "Save" writes
 *   markSaved()         says that the present drawing is saved
 *   say(text)           shows a line below the picture, which screen readers announce
 *   state               {paths, edited, live, selected}, numbers and booleans
 *   onChange            set a function here: it is called after edits, undo, redo, and changes of the selection
 *
 * Text of an SVG is as warpvec/svg/sanitize.py returns it, or as warpvec writes it. It is parsed and never inserted.
 *
 * The page itself calls, where they exist:
 *   window.desk.fitAgain(svgText, lockedIndices)
 *       The button "Fit again", which is hidden without it. `svgText` is `drawingText()`; `lockedIndices` are places of
 *       paths in it, in document order from 0, not counting the background: the edited paths if they are to stay as
 *       they are, else none.
 *   window.desk.save(svgText)
 *       Ctrl+S and the button "Save SVG", instead of a download.
 *   window.desk.reshape(to, svgTexts)
 *       "Stroke to outline" and the like, which are hidden without it; `to` is "outline", "stroke", "circle", "ellipse" or
 *       "rect". Resolves to {svg, distance} or {refused} for each text, which has one shape on a canvas of its own. */

import { capture } from "viewer/commands.js";
import { loadPhoto, Meter } from "viewer/measure.js";
import { readDrawing } from "viewer/read.js";
import { writeDrawing } from "viewer/save.js";

export const EMPTY = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 300 200"/>';

export class Live {
  constructor(app) {
    this.app = app;
    this.before = null;
    this.onChange = null;
  }

  async open(data) {
    const opening = (this.opening = {});
    const photo = data.photo ? await this.loadPhoto(data.photo) : null;
    // Else another document was opened while the photo was loaded.
    if (this.opening === opening) this.show({ ...data, photo });
  }

  loadPhoto(address) {
    return loadPhoto(address);
  }

  show(data) {
    const { box } = readDrawing(data.svg ?? EMPTY);
    const meter = data.photo ? new Meter(data.photo, box) : null;
    [this.opening, this.before] = [null, null];
    this.app.open({ name: "drawing", history: [], figures: {}, ...data }, meter);
  }

  get isOn() {
    return this.before !== null;
  }

  showDrawing(svgText) {
    const { app } = this;
    app.endKeys();
    app.cancel();
    app.panel.stopMeasuring();
    const next = readDrawing(svgText);
    this.before ??= capture([], [], app.drawing);
    const { box } = app.drawing;
    replaceDrawing(app, next);
    if (!sameBox(box, next.box)) app.stage.fit();
    app.refresh();
  }

  endDrawing(label = "Fit") {
    const { app, before } = this;
    if (!before) return;
    this.before = null;
    if (label !== null) {
      app.commands.push(label, before);
      return;
    }
    const { box } = app.drawing;
    Object.assign(app.drawing, before.frame.state);
    if (!sameBox(box, app.drawing.box)) app.stage.fit();
    app.select([]);
  }

  showFigures(figures) {
    const { app } = this;
    const known = Object.entries({ ...app.data.figures, ...figures }).filter(([, value]) => value !== null);
    app.data = { ...app.data, figures: Object.fromEntries(known) };
    app.panel.request();
  }

  drawingText() {
    this.app.endKeys();
    return writeDrawing(this.app.drawing);
  }

  markSaved() {
    this.app.edited = false;
    this.app.panel.request();
  }

  say(text) {
    this.app.say(text);
  }

  get state() {
    const { app } = this;
    return { paths: app.pathCount, edited: app.edited, live: this.isOn, selected: app.selection.size };
  }
}

function sameBox(a, b) {
  return a.every((value, i) => value === b[i]);
}

/** Puts the content of `next` into the app's drawing; hidden layers and the selection are found again by place. */
function replaceDrawing(app, next) {
  const places = new Map(app.drawing.layers.map((layer) => [layer.name, layer]));
  const chosen = [];
  for (const layer of next.layers) {
    const old = places.get(layer.name);
    if (!old) continue;
    layer.visible = old.visible;
    old.items.forEach((item, i) => {
      if (app.selection.has(item) && layer.items[i]) chosen.push(layer.items[i]);
    });
  }
  Object.assign(app.drawing, next);
  app.selection = new Set(chosen);
}
