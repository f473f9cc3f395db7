/* The page for other scripts: `window.warpvecView`, on which a page that runs fits is built.
 *
 *   open({svg, name, photo, history, figures})
 *       Shows another document and forgets all edits, undo steps and the selection. Resolves when it is shown. `photo` is
 *       the address of an image (data: or blob:), or null. `history` and `figures` may be missing.
 *   loadPhoto(address), show({svg, name, photo, history, figures, facts, kept})
 *       The same in two parts, of which the second one takes no time in between: `photo` is what the first one resolves
 *       to, or null. `kept` is a drawing with its undo steps from `keep()`, in place of `svg`. `facts` are more facts of
 *       the file.
 *   keep()
 *       Returns the drawing with its undo steps, for `show`.
 *   packed(kept), unpacked(text)
 *       Returns a drawing with its undo steps as text, and makes it of the text again. Without `kept` it is the one that is
 *       shown; during frames that from before them. `marks` are values of which one changes whenever that text does.
 *   showDrawing(svgText)
 *       Shows a frame of a running fit. View, hidden layers and, by their places, the selected paths are kept. Until
 *       `finishDrawing` or `endDrawing` nothing can be edited, and nothing is measured, which would take time from the
 *       fit. It costs about as much as parsing and drawing once; call it with the newest frame only.
 *   eraseFrom({svg, facts})
 *       Resolves to what is left of shapes of a result without the parts that were erased of the drawing before; null, and
 *       no promise, if nothing is to be erased. It is the argument `left` of `finishDrawing`.
 *   finishDrawing({svg, facts, label, edits, isForced, left})
 *       Ends the frames with a result, in one undo step named `label`. `facts` are {figures, history} of the file, and
 *       whatever else belongs to the drawing: undo restores all together. `edits` says what becomes of the edits of the
 *       drawing before: "again" applies them to the result, "included" says that it has them, and "dropped" drops them.
 *       Returns "", or in words the edits for which the result has no place. Then the drawing from before the frames
 *       returns, unless `isForced`.
 *   endDrawing()
 *       Ends the frames, and the drawing from before them returns.
 *   facts, note({...})  the facts of the drawing; changes some of them
 *   isEdited            whether the drawing differs from the file of its fit
 *   unedited()          the SVG text of the drawing without the edits, but without the deleted shapes too
 *   deleted()           what the user has deleted: {d, rule, box, isNew} of each shape; the box is that of its user units,
 *                       and it is new if the last fit did not know of it
 *   figures             the figures that the page shows: those of the file, or what is measured of the edited drawing
 *   drawingText()       the SVG text of the drawing as edited, the same that "Save" writes
 *   shownText()         the same, during frames of the drawing from before them
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
 *       paths in it, in document order from 0, not counting the background: those of locked layers, and the edited
 *       ones if these are to stay as they are.
 *   window.desk.save(svgText)
 *       Ctrl+S and the button "Save SVG", instead of a download.
 *   window.desk.reshape(to, svgTexts)
 *       "Stroke to outline" and the like, which are hidden without it; `to` is "outline", "stroke", "circle", "ellipse" or
 *       "rect". Resolves to {svg, distance} or {refused} for each text, which has one shape on a canvas of its own. With
 *       "cut" each shape is followed by the area to take out, and the answer may also be {gone} or {same}.
 *   window.desk.undo(), window.desk.canUndo()
 *       Whether the last thing that was done is no change of the drawing, and can be undone; undoes it, and returns whether
 *       it was. */

import { multiply, scaling, translation } from "viewer/basics.js";
import { capture } from "viewer/commands.js";
import { editsInWords } from "viewer/edit_words.js";
import { applyEdits, deletedItems, editsOf, isPristine, itemsOf } from "viewer/edits.js";
import { eraseAgain, mustErase } from "viewer/erasing.js";
import { loadPhoto, Meter } from "viewer/measure.js";
import { pack, unpack } from "viewer/packing.js";
import { writeShape } from "viewer/paths.js";
import { newLayer, readDrawing } from "viewer/read.js";
import { replaceDrawing } from "viewer/replacing.js";
import { decimalsFor, writeDrawing } from "viewer/save.js";

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
    const meter = data.photo ? new Meter(data.photo) : null;
    [this.opening, this.before] = [null, null];
    this.app.open({ name: "drawing", ...data }, meter);
  }

  keep() {
    const { app } = this;
    app.endKeys();
    return { drawing: app.drawing, commands: app.commands };
  }

  packed(kept = null) {
    const { app, before } = this;
    const { drawing, commands } = kept ?? app;
    const stands = new Map(!kept && before ? [[drawing, before.frame.state]] : []);
    return pack({ drawing, done: commands.done, undone: commands.undone }, stands);
  }

  unpacked(text) {
    const { drawing, done, undone } = unpack(text);
    return { drawing, commands: Object.assign(this.app.newCommands(), { done, undone }) };
  }

  get marks() {
    const { app: { commands, edited }, shown: { layers, facts } } = this;
    const last = commands.done.at(-1);
    const looks = layers.map(({ visible, isLocked }) => (visible ? 1 : 0) + (isLocked ? 2 : 0)).join("");
    return [layers, facts, edited, looks, last, last?.after, commands.done.length, commands.undone.length];
  }

  get isOn() {
    return this.before !== null;
  }

  showDrawing(svgText) {
    const { app } = this;
    app.endKeys();
    app.cancel();
    this.before ??= capture([], [], app.drawing);
    this.replace(readDrawing(svgText));
  }

  eraseFrom({ svg, facts }) {
    const old = this.shown;
    const next = drawingOf(svg, facts);
    return mustErase(old, next) ? eraseAgain(old, next, unitsBetween(old.box, next.box)) : null;
  }

  finishDrawing({ svg, facts, label = "Fit", edits = "dropped", isForced = false, left: rests = new Map() }) {
    const { app } = this;
    const next = drawingOf(svg, facts);
    app.endKeys();
    app.cancel();
    this.before ??= capture([], [], app.drawing);
    const { before } = this;
    const old = before.frame.state;
    const made = edits === "dropped" ? [] : editsOf(old);
    const left = edits === "again" ? applyEdits(made, next, unitsBetween(old.box, next.box), rests) : [];
    if (left.length && !isForced) {
      this.endDrawing();
      return editsInWords(left);
    }
    next.past = edits === "included" ? made : [];
    next.erased = edits === "dropped" ? [] : erasedOf(old).map((area) => ({ ...area, isNew: false }));
    this.before = null;
    this.replace(next);
    // Before the first drawing there is nothing to go back to.
    if (old.base.items.length || app.commands.done.length) app.commands.push(label, before);
    else app.setSplit(0);
    return "";
  }

  endDrawing() {
    const { app, before } = this;
    if (!before) return;
    this.before = null;
    Object.assign(app.drawing, before.frame.state);
    app.select([]);
  }

  replace(next) {
    const { app } = this;
    app.panel.stopMeasuring();
    replaceDrawing(app, next);
    app.refresh();
  }

  get facts() {
    return this.shown.facts;
  }

  /** The drawing that the user has: from before the frames, if there are any. */
  get shown() {
    return this.before?.frame.state ?? this.app.drawing;
  }

  note(facts) {
    const { app, shown } = this;
    shown.facts = { ...shown.facts, ...facts };
    app.panel.request();
  }

  unedited() {
    const { shown } = this;
    const gone = new Set(deletedItems(shown));
    const layers = shown.base.layers.map(({ layer, name }) => ({ ...layer, name, items: [] }));
    const places = new Map(shown.base.layers.map(({ layer }, i) => [layer, layers[i]]));
    for (const origin of shown.base.items) if (!gone.has(origin)) places.get(origin.layer).items.push(origin);
    return writeDrawing({ ...shown, layers, background: shown.base.background });
  }

  get figures() {
    return this.app.figures.all;
  }

  get isEdited() {
    return !isPristine(this.shown);
  }

  deleted() {
    return erasedOf(this.shown);
  }

  drawingText() {
    this.app.endKeys();
    return writeDrawing(this.app.drawing);
  }

  shownText() {
    return writeDrawing(this.shown);
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

/** Returns what is deleted of a drawing, and of those that it came from. */
function erasedOf(drawing) {
  const decimals = decimalsFor(drawing.box);
  const box = drawing.box.join(" ");
  const gone = deletedItems(drawing).map(({ shape, rule }) => ({ d: writeShape(shape, decimals), rule, box, isNew: true }));
  return [...drawing.erased, ...gone];
}

/** Returns the matrix from the user units of one box to those of another one around the same picture. */
function unitsBetween(from, to) {
  const scale = scaling(to[2] / from[2], to[3] / from[3], 0, 0);
  return multiply(translation(to[0], to[1]), multiply(scale, translation(-from[0], -from[1])));
}

/** Returns the drawing of a file with its `facts`. A short file has no layers: the facts name them, with their counts.
 *
 * @param {string} svg
 * @param {any} facts */
export function drawingOf(svg, facts) {
  const drawing = readDrawing(svg);
  const written = writeDrawing(drawing);
  if (facts?.layers) divideLayers(drawing, facts.layers);
  if (facts?.isByHand) drawing.past = [{ kind: "opened" }];
  drawing.facts = { figures: {}, history: [], written: facts?.layers ? writeDrawing(drawing) : written, ...facts };
  return drawing;
}

function divideLayers(drawing, stated) {
  const items = itemsOf(drawing);
  if (items.length !== stated.reduce((sum, { count }) => sum + count, 0)) return;
  let place = 0;
  drawing.layers = stated.map(({ name, count }, index) => {
    const layer = { ...newLayer(null, index), name, items: items.slice(place, place + count) };
    for (const item of layer.items) item.layer = item.origin.layer = layer;
    place += count;
    return layer;
  });
  drawing.base.layers = drawing.layers.map((layer) => ({ layer, name: layer.name }));
}
