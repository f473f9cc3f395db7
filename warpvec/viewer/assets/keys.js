/* Keyboard shortcuts. They work unless the focused control uses the key itself. */

import { fillTable, find } from "viewer/dom.js";
import { selectAlike, selectAll, selectNext } from "viewer/selecting.js";

const STEP = 1;
const BIG_STEP = 10;
const TURN_DEGREES = 5;

const KEYS = [
  ["V  N  B  O  E  I  H", "select, edit nodes, brush, lasso, eraser, pick a colour, pan"],
  ["C", "a cross on the drawing: arrows move it (Shift: far, Ctrl: finely), Enter clicks, Space presses and releases"],
  ["Space + drag, middle button", "pan; on a touch screen two fingers pan and zoom"],
  ["Wheel, + and −", "zoom; Shift + wheel pans"],
  ["0", "show the whole drawing"],
  ["[  and  ]", "select the previous or next path; with the node tool, node or handle"],
  ["Ctrl+A, Esc", "select all paths, or none"],
  ["K  and  L", "select all paths of the same fill, or of the same layer"],
  ["Arrows, Shift + arrows", "move by 1 or 10 units"],
  ["<  and  >", "scale to 90 % or 110 %"],
  ["(  and  )", "turn by 5 degrees left or right"],
  ["Page Up, Page Down", "raise or lower the selection"],
  ["Home, End", "bring to the front or back of the layer"],
  ["Ctrl+G, Ctrl+Shift+G", "make a layer of the selection, or merge its layer into the one below"],
  ["Delete", "delete the selection, or with the node tool the chosen nodes"],
  ["A  S  L", "with the node tool: add a node after the chosen one, smooth or corner, line or curve"],
  ["Ctrl+Z, Ctrl+Shift+Z", "undo, redo"],
  ["Ctrl+S", "save the SVG"],
  ["D  G  U  R", "show the drawing, its layers in colours, all paths as lines, or the differences"],
  [",  and  .", "fewer or more layers"],
  ["P", "show or hide the picture on the left half"],
];

const USED_BY_INPUTS = /^(Arrow|Home|End|Page|Enter| )/;
const USED_BY_BUTTONS = /^(Enter| )/;
export const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

export function connectKeys(app) {
  fillTable(find("keys"), KEYS);
  addEventListener("keydown", (event) => {
    const isDragging = app.pointer.drag && !app.caret.isOn;
    if (document.querySelector("dialog[open]") || (isDragging && event.key !== "Escape")) return;
    if (event.key === "Escape") app.endKeys();
    const taken = caretKey(app, event) || (event.ctrlKey || event.metaKey ? commandKey(app, event) : plainKey(app, event));
    if (taken) event.preventDefault();
  });
  addEventListener("keyup", (event) => {
    if (event.key === " ") app.panning = false;
  });
  addEventListener("blur", () => (app.panning = false));
  addEventListener("beforeunload", (event) => {
    if (app.edited) event.preventDefault();
  });
}

/** The cross takes keys while the picture has the focus. */
function caretKey(app, event) {
  return app.caret.isOn && event.target === app.pointer.surface && app.caret.key(event);
}

function commandKey(app, event) {
  const key = event.key.toLowerCase();
  const inText = isText(event.target);
  if (key === "s") app.save();
  else if (key === "z" && !inText) event.shiftKey ? app.redo() : app.undo();
  else if (key === "y" && !inText) app.redo();
  else if (key === "a" && !inText) selectAll(app);
  else if (key === "g" && !inText) event.shiftKey ? app.editor.ungroup() : app.editor.group();
  else return false;
  return true;
}

function isText(element) {
  return element.matches("input[type=number], input[type=text], input:not([type]), textarea");
}

/** Runs the action of a key, unless the focused control uses it (arrows in a slider, letters in a list). */
function plainKey(app, event) {
  if (event.altKey || isText(event.target) || event.target.matches("select")) return false;
  if (event.target.matches("input") && USED_BY_INPUTS.test(event.key)) return false;
  if (event.target.matches("button, summary") && USED_BY_BUTTONS.test(event.key)) return false;
  const arrow = ARROWS[event.key];
  if (arrow) {
    const step = event.shiftKey ? BIG_STEP : STEP;
    return app.nudge(arrow[0] * step, arrow[1] * step);
  }
  const name = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  const action = (app.nodes.path && nodeActions(app)[name]) || plainActions(app)[name];
  action?.();
  return Boolean(action);
}

function plainActions(app) {
  const { editor, stage } = app;
  return {
    v: () => app.setTool("select"), n: () => app.setTool("node"), b: () => app.setTool("brush"), i: () => app.setTool("pick"),
    o: () => window.desk?.reshape && app.setTool("lasso"), e: () => window.desk?.reshape && app.setTool("eraser"),
    h: () => app.setTool("pan"), c: () => app.toggleCaret(),
    d: () => app.setShow("drawing"), g: () => app.setShow("layers"), r: () => app.setShow("residual"), u: () => app.setShow("outlines"),
    p: () => app.setSplit(app.split ? 0 : 50), ",": () => app.showLayers(app.shownCount - 1), ".": () => app.showLayers(app.shownCount + 1),
    "[": () => selectNext(app, -1), "]": () => selectNext(app, 1), k: () => selectAlike(app, "fill"), l: () => selectAlike(app, "layer"),
    "<": () => editor.scale(0.9), ">": () => editor.scale(1.1),
    "(": () => editor.turn(-TURN_DEGREES), ")": () => editor.turn(TURN_DEGREES),
    "+": () => stage.zoom(1.4), "=": () => stage.zoom(1.4), "-": () => stage.zoom(1 / 1.4), 0: () => stage.fit(),
    Delete: () => editor.remove(), Backspace: () => editor.remove(),
    Home: () => editor.reorder("front"), End: () => editor.reorder("back"),
    PageUp: () => editor.reorder("raise"), PageDown: () => editor.reorder("lower"),
    Escape: () => app.pointer.cancel() || app.select([]), "?": () => find("help").showModal(),
    " ": () => (app.panning = true),
  };
}

function nodeActions(app) {
  const { nodes } = app;
  return {
    "[": () => nodes.step(-1), "]": () => nodes.step(1), a: () => nodes.add(), s: () => nodes.toggleSmooth(), l: () => nodes.switchLine(),
    ...(nodes.chosen.size && { Delete: () => nodes.remove(), Backspace: () => nodes.remove() }),
    Escape: () => app.pointer.cancel() || nodes.clear() || app.setTool("select"),
  };
}
