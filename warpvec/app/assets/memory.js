/* What a page that is loaded again must know: its pictures with their drawings, undo steps and settings, those that were
 * removed, and what is chosen. Whatever has changed is written at once, so that a crash loses nothing either. */

import { goOnFrom, nextVersion } from "viewer/commands.js";
import { find, setChoice } from "viewer/dom.js";
import { pack, unpack } from "viewer/packing.js";
import { showSide } from "app/parts.js";
import { PagePicture } from "app/picture.js";
import { Store } from "app/store.js";

// Boxes of the page that no picture has as its own.
const BOXES = ["keep-edited"];
const LISTS = ["purpose"];

export class Memory {
  // What was last written of each record: values of which one changes whenever the record does.
  marks = new Map();
  isDue = false;
  // Whether the page was loaded again with all that it had.
  knows = false;
  /** @type {Promise<void> | null} */
  writing = null;

  constructor(store, records) {
    this.store = store;
    this.records = records;
  }

  /** Reads what is known of a page, or of the one that it is a `copy` of. The user may have blocked the storage: then nothing
   * is, and nothing will be. */
  static async open({ page, copy }) {
    try {
      const store = await Store.open(page, document.body.dataset.key);
      if (copy) await store.copyFrom(copy);
      return new Memory(store, await store.read());
    } catch {
      return new Memory(null, new Map());
    }
  }

  get isWritten() {
    return !this.store || (!this.isDue && !this.writing);
  }

  // Reading

  /** Gives the desk its pictures back. */
  restore(desk) {
    const text = this.textOf("desk");
    if (!text) return;
    this.knows = true;
    const { version, pictures, removed, current, positions, side, boxes, chosen } = unpack(text);
    goOnFrom(version);
    const again = (key) => this.pictureOf(key, desk.view);
    desk.pictures = pictures.map(again).filter(Boolean);
    desk.removed = removed.map(({ key, ...rest }) => ({ picture: again(key), ...rest })).filter(({ picture }) => picture);
    desk.wanted = desk.pictures.find(({ key }) => key === current) ?? null;
    setChoice("side", side);
    showSide(side);
    desk.panel.show(positions, null, null);
    BOXES.forEach((id, i) => (find(id).checked = boxes[i]));
    LISTS.forEach((id, i) => (find(id).selectedIndex = chosen[i] ?? 0));
    this.records.clear();
  }

  textOf(name) {
    const data = this.records.get(name);
    return data ? new TextDecoder().decode(data) : "";
  }

  pictureOf(key, view) {
    const text = this.textOf(`picture/${key}`);
    if (!text) return null;
    const { state, type, drawn } = unpack(text);
    const [blob, drawing] = [this.fileOf(`file/${key}`, state.name, type), this.fileOf(`drawing/${key}`, `${state.name}.svg`)];
    if (!blob && !drawing && state.status === "loading") return null; // its file had not been read
    return Object.assign(new PagePicture(state.name, blob, state.positions), state, { drawing, kept: drawn && view.unpacked(drawn) });
  }

  fileOf(record, name, type = "") {
    const bytes = this.records.get(record);
    if (!bytes) return null;
    const file = new File([bytes], name, { type });
    this.marks.set(record, [file]);
    return file;
  }

  // Writing

  /** Notes that something may have changed. */
  note(desk) {
    if (!this.store) return;
    this.isDue = true;
    this.writing ??= this.write(desk).finally(() => (this.writing = null));
  }

  async write(desk) {
    try {
      while (this.isDue) {
        await new Promise((resolve) => setTimeout(resolve)); // until what makes several changes has made all
        this.isDue = false;
        const changed = this.changes(desk);
        if (!changed.size) continue;
        const bytes = [...changed].map(async ([name, { content }]) => [name, await bytesOf(content())]);
        await this.store.write(new Map(/** @type {any} */ (await Promise.all(bytes))));
        for (const [name, { marks }] of changed) marks ? this.marks.set(name, marks) : this.marks.delete(name);
      }
    } catch (error) {
      desk.view.say(`This page could not be kept for the time after a reload: ${error.message}`);
    }
  }

  /** Returns what differs from the records: its marks, and what returns its content, by name. */
  changes(desk) {
    if (desk.view.app.gesture) return new Map(); // its end is another change
    const pictures = [...desk.pictures, ...desk.removed.map(({ picture }) => picture)];
    const all = new Map(pictures.flatMap((picture) => recordsOf(picture, desk)));
    const isSame = ({ marks }, known) => known?.length === marks.length && marks.every((mark, i) => mark === known[i]);
    const changed = [...all].filter(([name, record]) => !isSame(record, this.marks.get(name)));
    const gone = [...this.marks.keys()].filter((name) => name !== "desk" && !all.has(name));
    const facts = deskFacts(desk);
    const text = JSON.stringify(facts);
    // The version is larger than all in the other records.
    const own = { marks: [text], content: () => pack({ ...facts, version: nextVersion() }) };
    if (changed.length || gone.length || !isSame(own, this.marks.get("desk"))) changed.push(["desk", own]);
    return new Map([...changed, ...gone.map((name) => /** @type {any} */ ([name, { marks: null, content: () => null }]))]);
  }
}

/** Returns the records of a picture: its file, and all else. */
function recordsOf(picture, { view, sheet }) {
  const { key, blob, frame, photo, kept, arriving, asking, timer, isBeginning, drawing, ...state } = picture;
  const isShown = sheet.shows(picture);
  if (isShown) state.isSaved &&= !view.state.edited;
  const drawn = () => (isShown ? view.packed() : kept && view.packed(kept));
  const content = () => pack({ state: { key, ...state }, type: blob?.type, drawn: drawn() });
  const marks = [...Object.values(state), ...(isShown ? view.marks : [kept])];
  const files = Object.entries({ file: blob, drawing }).filter(([, file]) => file);
  return /** @type {any} */ ([
    [`picture/${key}`, { marks, content }],
    ...files.map(([kind, file]) => [`${kind}/${key}`, { marks: [file], content: () => file }]),
  ]);
}

function deskFacts({ pictures, removed, current, panel }) {
  return {
    pictures: pictures.map(({ key }) => key),
    removed: removed.map(({ picture, ...rest }) => ({ key: picture.key, ...rest })),
    current: current?.key ?? null,
    positions: panel.positions,
    side: document.body.dataset.side,
    boxes: BOXES.map((id) => find(id).checked),
    chosen: LISTS.map((id) => find(id).selectedIndex),
  };
}

/** Returns the bytes of a text or file; null for a file that cannot be read any more, as for nothing. */
async function bytesOf(content) {
  if (typeof content === "string") return new TextEncoder().encode(content);
  return content && content.arrayBuffer().catch(() => null);
}
