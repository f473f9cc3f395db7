/* Does what a user does on the page, step after step, and looks after each step for what must always hold.
 *
 * Call `run(steps)` with some of STEPS. It returns what was wrong, as sentences. The shapes that it edits are those of
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
  const end = performance.now() + 60_000;
  while (!isTrue()) {
    if (performance.now() > end) throw new Error(`waited for ${what} in vain`);
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

class Model {
  done = [];
  undone = [];
  isCut = false;

  push(command) {
    this.done.push({ ...command, cutBefore: this.isCut });
    this.undone = [];
    if ("isCut" in command) this.isCut = command.isCut;
  }

  get edits() {
    return new Set(this.done.flatMap(({ edit }) => edit ?? []));
  }
}

const STEPS = {
  setting: async (model) => {
    await fitting(() => $("set-cutout").click());
    model.push({ isCut: !model.isCut });
  },
  fit: async (model) => {
    await fitting(() => $("fit-again").click());
    model.push({});
  },
  edit: async (model) => {
    const edit = EDITS.find((each) => !model.edits.has(each));
    if (!edit) return;
    edit.make();
    model.push({ edit });
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
    if (app.commands.done.length > count) model.push({ isCut: !model.isCut });
  },
};

async function look(model) {
  await frames();
  await until(() => !/measuring/.test($("summary").textContent + $("shown-psnr").textContent), "figures");
  for (const edit of EDITS) {
    if (edit.isSeen() !== model.edits.has(edit)) model.faults.push(`${edit.name}: ${model.edits.has(edit) ? "lost" : "not undone"}`);
  }
  const states = { control: $("set-cutout").checked, drawing: Boolean(app.drawing.settings.cutout), model: model.isCut };
  if (new Set(Object.values(states)).size > 1) model.faults.push(`cut out: ${JSON.stringify(states)}`);
  const numbers = ["summary", "shown-psnr", "figures", "fit-figures"].map((id) => $(id).textContent.match(/[\d.∞]+ dB/)?.[0]);
  if (new Set(numbers).size > 1) model.faults.push(`figures differ: ${numbers}`);
  if (!$("proposal").hidden) model.faults.push($("proposal-text").textContent);
}

window.run = async (steps) => {
  const model = new Model();
  model.faults = [];
  const first = view.drawingText();
  for (const [i, step] of steps.entries()) {
    await STEPS[step](model);
    const known = model.faults.length;
    await look(model);
    model.faults = model.faults.map((fault, at) => (at < known ? fault : `after step ${i + 1}, ${step}: ${fault}`));
  }
  const stated = parseFloat($("summary").textContent.match(/([\d.]+) dB/)[1]);
  const text = view.drawingText();
  while (!$("undo").disabled) {
    await STEPS.undo(model);
    await frames();
  }
  await look(model);
  if (view.drawingText() !== first) model.faults.push("undo does not lead back to the first drawing");
  return { faults: model.faults, stated, text };
};
