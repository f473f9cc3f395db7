/* Undo and redo. A command stores the items' states and the layers' item lists that it changed, before and after. */

const MAX_COMMANDS = 500;
// Repeats of one command within this time are one undo step, as for held arrow keys.
const MERGE_MS = 800;

export class Commands {
  /** `mayChange` says whether a command may run now; `onChange` is called after each change. */
  constructor(mayChange, onChange) {
    this.done = [];
    this.undone = [];
    this.mayChange = mayChange;
    this.onChange = onChange;
  }

  /** Runs `mutate` as the command `label`. It may change only `items`, `layers`, and `drawing` itself if it is given. */
  record(label, items, layers, mutate, merge = false, drawing = null) {
    if (!this.mayChange()) return;
    const before = capture(items, layers, drawing);
    mutate();
    this.push(label, before, merge);
  }

  /** Records the changes since `before`, a result of `capture`. */
  push(label, before, merge = false) {
    const after = capture([...before.items.keys()], [...before.lists.keys()], before.frame?.drawing);
    const last = this.done.at(-1);
    const now = performance.now();
    const touched = new Set([...before.lists.keys(), ...layersOf(before), ...layersOf(after)]);
    if (merge && last?.label === label && now - last.time < MERGE_MS && sameKeys(last.before.items, before.items)) {
      Object.assign(last, { after, time: now });
    } else {
      this.done.push({ label, before, after, touched, time: now, number: nextVersion() });
      if (this.done.length > MAX_COMMANDS) this.done.shift();
    }
    this.undone = [];
    this.finish(touched);
  }

  undo() {
    const command = this.done.pop();
    if (!command) return null;
    this.undone.push(command);
    return this.restore(command, command.before);
  }

  redo() {
    const command = this.undone.pop();
    if (!command) return null;
    this.done.push(command);
    command.number = nextVersion();
    return this.restore(command, command.after);
  }

  /** The number of the last change, which is larger than those of all changes before. */
  get lastNumber() {
    return this.done.at(-1)?.number ?? 0;
  }

  restore(command, { items, lists, frame }) {
    command.time = 0;
    if (frame) Object.assign(frame.drawing, frame.state);
    for (const [item, state] of items) Object.assign(item, state);
    for (const [layer, state] of lists) Object.assign(layer, state);
    this.finish(command.touched);
    return command.label;
  }

  finish(layers) {
    for (const layer of layers) layer.version = nextVersion();
    this.onChange();
  }
}

/** Saves the state of items and layers, and of the whole `drawing` if it is given. Shallow copies suffice: shapes, item
 * lists and the list of layers are replaced, never changed. */
export function capture(items, layers, drawing = null) {
  const states = new Map();
  for (const item of items) {
    const { layer, shape, fill, opacity, stroke, softness } = item;
    states.set(item, { layer, shape, fill, opacity, stroke, softness });
  }
  const frame = drawing && { drawing, state: { ...drawing } };
  const lists = new Map(layers.map((layer) => [layer, { items: layer.items, id: layer.id, name: layer.name }]));
  return { items: states, lists, frame };
}

function layersOf({ items }) {
  return [...items.values()].map(({ layer }) => layer);
}

function sameKeys(a, b) {
  return a.size === b.size && [...a.keys()].every((key) => b.has(key));
}

let lastVersion = 0;

/** Returns a new version. Versions never repeat, so a cached picture cannot be mistaken for another. */
export function nextVersion() {
  return ++lastVersion;
}

/** Lets versions go on after `version`, that of a page that was loaded again. */
export function goOnFrom(version) {
  lastVersion = Math.max(lastVersion, version);
}
