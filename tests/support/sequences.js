/* Does what a user does on the page, step after step, and looks after each step for what must always hold.
 *
 * Call `takeStep` for each of some of STEPS, and `undoAll` at the end, which returns what was wrong, as sentences. The shapes that it edits are those of
 * `quick_desk.py`. Every edit is of another shape, so that a model of the undo list says which edits must be seen. */

const $ = (id) => document.getElementById(id);
const view = window.warpvecView;
const { app } = view;
const items = () => app.drawing.layers.flatMap((layer) => layer.items);
const frame = () => new Promise(requestAnimationFrame);
// A change is drawn in the next frame, and what follows from it in the one after.
const frames = async () => (await frame(), await frame());
const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

const GREEN = "#2e9b4f", ORANGE = "#ff8000", RED = "#c02030", YELLOW = "#f2c230";
// Each edit, and whether a drawing shows it.
const EDITS = [
  {
    name: "recolour",
    make: () => {
      app.select(items().filter(({ fill }) => fill === GREEN));
      $("fill").value = ORANGE;
      for (const type of ["input", "change"]) $("fill").dispatchEvent(new Event(type, { bubbles: true }));
    },
    isSeen: () => items().some(({ fill }) => fill === ORANGE) && !items().some(({ fill }) => fill === GREEN),
  },
  {
    name: "move",
    make: () => {
      app.select(items().filter(({ fill }) => fill === RED));
      app.editor.move(-60, -8);
      app.endKeys();
    },
    isSeen: () => items().find(({ fill }) => fill === RED).shape.box[0] < 100,
  },
  {
    name: "delete",
    make: () => {
      app.select(items().filter(({ fill }) => fill === YELLOW));
      app.editor.remove();
    },
    isSeen: () => !items().some(({ fill }) => fill === YELLOW),
  },
];

const isIdle = () => $("stop").disabled && !view.state.live && !/Starting|Drawing|Stopping/.test($("fit-status").textContent);

async function until(isTrue, what) {
  const end = performance.now() + 240_000;
  while (!isTrue()) {
    if (performance.now() > end) throw new Error(`waited for ${what} in vain: ${$("fit-status").textContent}, ${JSON.stringify(view.state)}`);
    await pause(5);
  }
}

/** Waits until a fit has begun since `act`, and has ended. */
async function fitting(act) {
  const count = window.statuses.length;
  act();
  await until(() => window.statuses.slice(count).some((text) => /Starting|Drawing|Stopping/.test(text)), "a fit");
  await until(isIdle, "the end of a fit");
}

/** What the user has done, as plain data that outlives the page: the commands done and undone, the edits that the drawing
 * had when it was opened, whether it is cut out, and what was wrong. */
const newModel = () => ({ done: [], undone: [], opened: [], isCut: false, faults: [] });

function push(model, command) {
  model.done.push({ ...command, cutBefore: model.isCut });
  model.undone = [];
  if ("isCut" in command) model.isCut = command.isCut;
}

const editsIn = ({ done, opened }) => new Set([...opened, ...done.flatMap(({ edit }) => edit ?? [])]);

/** Keeps the drawing if the page asks, as it may where the picture is drawn again in place of edits of an opened file. */
function keepsOwn({ opened, isCut }) {
  if ($("proposal").hidden || !opened.length || !isCut) return false;
  $("keep-mine").click();
  return true;
}

const STEPS = {
  setting: async (model) => {
    await fitting(() => $("set-cutout").click());
    if (!keepsOwn(model)) push(model, { isCut: !model.isCut });
  },
  fit: async (model) => {
    await fitting(() => $("fit-again").click());
    push(model, {});
  },
  edit: async (model) => {
    const edit = EDITS.find(({ name }) => !editsIn(model).has(name));
    if (!edit) return;
    edit.make();
    push(model, { edit: edit.name });
  },
  undo: async (model) => {
    $("undo").click();
    const command = model.done.pop();
    if (!command) return;
    model.undone.push({ ...command, cutAfter: model.isCut });
    model.isCut = command.cutBefore;
  },
  redo: async (model) => {
    $("redo").click();
    const command = model.undone.pop();
    if (!command) return;
    model.done.push(command);
    model.isCut = command.cutAfter;
  },
  // Undo brings the picture back.
  x: async () => {
    $("pictures").querySelector("button:not(.open)").click();
    if ($("removal").open) $("removal-yes").click();
    await until(() => !$("empty").hidden && !$("undo").disabled, "the removal");
    $("undo").click();
    await until(() => view.state.paths && isIdle(), "the picture");
  },
  // A fit that is stopped has a result, or none if it had not begun: then the settings go back.
  stop: async (model) => {
    const count = app.commands.done.length;
    await fitting(() => {
      $("set-cutout").click();
      const watch = setInterval(() => {
        if ($("stop").disabled) return;
        clearInterval(watch);
        $("stop").click();
        if (!$("fit-status").textContent.startsWith("Stopping")) model.faults.push("Stop does not say so at once");
      }, 1);
    });
    if (!keepsOwn(model) && app.commands.done.length > count) push(model, { isCut: !model.isCut });
  },
};

async function look(model) {
  await frames();
  const shown = ["summary", "shown-psnr", "figures", "fit-figures"];
  const isMeasured = (id) => /dB/.test($(id).textContent) && !/measuring/.test($(id).textContent);
  await until(() => shown.every(isMeasured), "figures");
  for (const edit of EDITS) {
    const isMade = editsIn(model).has(edit.name);
    if (edit.isSeen() !== isMade) model.faults.push(`${edit.name}: ${isMade ? "lost" : "not undone"}`);
  }
  const states = { control: $("set-cutout").checked, drawing: Boolean(app.drawing.settings.cutout), model: model.isCut };
  if (new Set(Object.values(states)).size > 1) model.faults.push(`cut out: ${JSON.stringify(states)}`);
  const numbers = shown.map((id) => $(id).textContent.match(/[\d.∞]+ dB/)?.[0]);
  if (new Set(numbers).size > 1) model.faults.push(`figures differ: ${numbers} of ${JSON.stringify(view.facts.figures)}`);
  if (!$("proposal").hidden) model.faults.push($("proposal-text").textContent);
}

/** Does a step, unless it is one of the test's own, and returns what has been done since the first one. */
window.takeStep = async (step, model = newModel()) => {
  await until(() => view.state.paths && isIdle(), "a drawing"); // the page may have been loaded again
  const known = model.faults.length;
  await STEPS[step]?.(model);
  await look(model);
  model.faults = model.faults.map((fault, i) => (i < known ? fault : `${step}: ${fault}`));
  return model;
};

/** Undoes all and returns what was wrong, with the text and the stated closeness of the drawing before. */
window.undoAll = async (model, first) => {
  const stated = parseFloat($("summary").textContent.match(/([\d.]+) dB/)[1]);
  const text = view.drawingText();
  while (app.commands.done.length) {
    await STEPS.undo(model);
    await frames();
  }
  await look(model);
  if (view.drawingText() !== first) model.faults.push("undo does not lead back to the first drawing");
  return { faults: model.faults, stated, text };
};
