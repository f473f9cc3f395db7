/* Keyboard shortcuts. They work unless the focused control uses the key itself. */

const STEP = 1;
const BIG_STEP = 10;

const KEYS = [
  ["V  B  I  H", "select, brush, pick a colour, pan"],
  ["Space + drag, middle button", "pan"],
  ["Wheel, + and −", "zoom; Shift + wheel pans"],
  ["0", "show the whole picture"],
  ["[  and  ]", "select the previous or next path"],
  ["Ctrl+A, Esc", "select all paths, or none"],
  ["Arrows, Shift + arrows", "move by 1 or 10 units"],
  ["<  and  >", "scale to 90 % or 110 %"],
  ["Page Up, Page Down", "raise or lower the selection"],
  ["Home, End", "bring to the front or back of the level"],
  ["Delete", "delete the selection"],
  ["Ctrl+Z, Ctrl+Shift+Z", "undo, redo"],
  ["Ctrl+S", "save the SVG"],
  ["D  G  R", "show the drawing, generations, residual"],
  [",  and  .", "fewer or more levels of detail"],
  ["P", "show or hide the photo on the left half"],
];

const USED_BY_CONTROLS = /^(Arrow|Home|End|Page|Enter| )/;
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

function connectKeys(app) {
  fillTable(find("keys"), KEYS);
  addEventListener("keydown", (event) => {
    if (find("help").open || (app.pointer.drag && event.key !== "Escape")) return;
    if (event.key === "Escape") app.endKeys();
    const taken = event.ctrlKey || event.metaKey ? commandKey(app, event) : plainKey(app, event);
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

function commandKey(app, event) {
  const key = event.key.toLowerCase();
  const inText = event.target.matches("input[type=number]");
  if (key === "s") app.save();
  else if (key === "z" && !inText) event.shiftKey ? app.redo() : app.undo();
  else if (key === "y" && !inText) app.redo();
  else if (key === "a" && !inText) app.selectAll();
  else return false;
  return true;
}

/** Runs the action of a key, unless the focused control uses it (arrows in a slider, letters in a list). */
function plainKey(app, event) {
  if (event.altKey || event.target.matches("input[type=number], select")) return false;
  if (event.target.matches("input, button, summary") && USED_BY_CONTROLS.test(event.key)) return false;
  const arrow = ARROWS[event.key];
  if (arrow) {
    const step = event.shiftKey ? BIG_STEP : STEP;
    app.editor.move(arrow[0] * step, arrow[1] * step);
    return app.selection.size > 0;
  }
  const action = plainActions(app)[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  action?.();
  return Boolean(action);
}

function plainActions(app) {
  const { editor, stage } = app;
  return {
    v: () => app.setTool("select"), b: () => app.setTool("brush"), i: () => app.setTool("pick"), h: () => app.setTool("pan"),
    d: () => app.setShow("drawing"), g: () => app.setShow("generations"), r: () => app.setShow("residual"),
    p: () => app.setSplit(app.split ? 0 : 50), ",": () => app.setLevel(app.level - 1), ".": () => app.setLevel(app.level + 1),
    "[": () => app.selectNext(-1), "]": () => app.selectNext(1),
    "<": () => editor.scale(0.9), ">": () => editor.scale(1.1),
    "+": () => stage.zoom(1.4), "=": () => stage.zoom(1.4), "-": () => stage.zoom(1 / 1.4), 0: () => stage.fit(),
    Delete: () => editor.remove(), Backspace: () => editor.remove(),
    Home: () => editor.reorder("front"), End: () => editor.reorder("back"),
    PageUp: () => editor.reorder("raise"), PageDown: () => editor.reorder("lower"),
    Escape: () => app.pointer.cancel() || app.select([]), "?": () => find("help").showModal(),
    " ": () => (app.panning = true),
  };
}
