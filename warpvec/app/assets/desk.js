/* The desk: pictures come in, the server draws them, and the viewer's page shows and edits the drawing. */

import { find, findAll, findNamed } from "viewer/dom.js";
import { ControlPanel, DEFAULT_POSITIONS, settingsForServer } from "app/controls.js";
import { connectDropping, setControl, showSide, showStatus } from "app/parts.js";
import { PagePicture } from "app/picture.js";
import { PictureList } from "app/queue.js";
import { Saver } from "app/saving.js";
import { Server } from "app/server.js";
import { Sheet } from "app/sheet.js";

// Time after the last move of a slider until the fit goes on with it.
const SETTLE_MS = 250;

const LOST_TEXT =
  "The server has ended. The drawing stays on this page and can be saved as SVG. " +
  "Run warpvec app again to go on: this page then connects to it.";

const OTHER_TEXT =
  "Another server answers at this address. The drawing stays on this page and can be saved as SVG. " +
  "To go on, open the address that warpvec app has printed.";

export class Desk {
  constructor(view) {
    this.view = view;
    this.sheet = new Sheet(view);
    this.pictures = [];
    this.current = null;
    this.list = new PictureList(find("pictures"), (picture) => this.open(picture), (picture) => this.remove(picture));
    this.panel = new ControlPanel((positions, name) => this.changeSettings(positions, name));
    this.server = new Server((kind, facts) => this.receive(kind, facts), (isOther) => this.lose(isOther), () => this.find());
    this.saver = new Saver(this.server);
    this.connect();
    this.refresh();
  }

  connect() {
    for (const id of ["choose", "choose-first"]) find(id).addEventListener("click", () => find("files").click());
    find("files").addEventListener("change", () => {
      this.add([...find("files").files]);
      find("files").value = "";
    });
    find("stop").addEventListener("click", () => this.attempt(() => this.server.stop(this.current.id)));
    find("restart").addEventListener("click", () => {
      this.current.erased = [];
      this.requestFit(this.current, {});
    });
    find("folder").addEventListener("change", () => this.addFromFolder(find("folder").value));
    for (const input of findNamed("side")) input.addEventListener("change", () => showSide(input.value));
    for (const button of findAll("[data-format]")) {
      button.addEventListener("click", () => this.save(this.view.drawingText(), button.dataset.format));
    }
    connectDropping((files) => this.add(files), (words) => this.view.say(words));
    addEventListener("beforeunload", (event) => {
      if (this.pictures.some((picture) => picture.newest && !picture.isSaved)) event.preventDefault();
    });
  }

  // Pictures

  add(files) {
    for (const file of files) {
      const picture = new PagePicture(file.name.replace(/\.[^.]+$/, "") || "picture", file, this.panel.positions);
      this.pictures.push(picture);
      this.uploading = (this.uploading ?? Promise.resolve()).then(() => this.begin(picture));
    }
    this.refresh();
  }

  async addFromFolder(name) {
    find("folder").selectedIndex = 0;
    if (!name) return;
    await this.attempt(async () => this.add([new File([await this.server.fromFolder(name)], name)]));
  }

  /** Sends a new picture and asks for its drawing. */
  async begin(picture) {
    if (!this.pictures.includes(picture)) return;
    try {
      await this.upload(picture);
    } catch (error) {
      Object.assign(picture, { status: "failed", message: error.message });
      if (!this.current || this.current.status === "failed") this.current = picture; // so that its message is seen
      this.refresh();
      return;
    }
    if (!this.pictures.includes(picture)) return; // it was removed in the meantime
    await this.requestFit(picture, {});
    if (!this.current || !this.pictures.some((other) => other !== picture && other.isBusy)) await this.open(picture);
  }

  /** Sends a picture, only once however many requests wait for it. */
  async upload(picture) {
    picture.arriving ??= this.server.upload(picture.blob, picture.name);
    try {
      const { id, width, height } = await picture.arriving;
      Object.assign(picture, { id, width, height, fit: null });
    } finally {
      picture.arriving = null;
    }
    if (!this.pictures.includes(picture)) this.forget(picture);
  }

  forget(picture) {
    clearTimeout(picture.timer);
    if (picture.id && this.server.isOnline) this.server.remove(picture.id).catch(() => {}); // it is gone in any case
  }

  async open(picture) {
    this.current = picture;
    this.panel.show(picture.positions, picture.mode, picture.reason);
    const opened = picture.width ? this.sheet.open(picture, this.server.previewUrl(picture.id)) : null;
    this.refresh();
    await this.attempt(() => opened);
  }

  async remove(picture) {
    this.pictures = this.pictures.filter((other) => other !== picture);
    this.forget(picture);
    if (this.current === picture) {
      this.current = null;
      if (this.pictures.length) await this.open(this.pictures.at(-1));
      else this.sheet.clear();
    }
    this.refresh();
  }

  // Fits

  changeSettings(positions, name) {
    const picture = this.current;
    if (!picture) return;
    picture.positions = positions;
    clearTimeout(picture.timer);
    if (picture.status === "loading") return; // its first fit will have them
    picture.timer = setTimeout(() => {
      const { filled, start, ...erased } = this.sheet.present(picture);
      this.requestFit(picture, name === "mode" ? erased : { start, ...erased });
    }, SETTLE_MS);
  }

  async requestFit(picture, more) {
    if (!picture) return;
    clearTimeout(picture.timer);
    const request = { settings: settingsForServer(picture.positions), ...more };
    await this.attempt(async () => {
      if (!picture.id) await this.upload(picture);
      if (!this.pictures.includes(picture)) return;
      Object.assign(picture, { status: "waiting", message: "" });
      this.refresh();
      await this.server.fit(picture.id, request).catch(async (error) => {
        if (error.status !== 404 || !picture.blob) throw error;
        await this.upload(picture); // the server has forgotten it
        await this.server.fit(picture.id, request);
      });
    }, picture);
  }

  /** Fits the edited drawing again; the paths at `locked` stay, and deleted ones are filled in. */
  async fitAgain(text, locked) {
    if (!this.current?.newest || !this.sheet.shows(this.current)) {
      this.view.say("There is no drawing to fit again yet");
      return;
    }
    await this.requestFit(this.current, { ...this.sheet.present(this.current), start: text, locked, keepsPaths: true });
  }

  // Events

  receive(kind, facts) {
    if (kind === "hello") this.greet(facts);
    else if (kind === "server") this.meet(facts);
    else if (kind === "queue") for (const picture of this.pictures) picture.place = facts.places[picture.id] ?? 0;
    const picture = this.pictures.find(({ id }) => id && id === facts.id);
    if (picture) this.update(picture, kind, facts);
    this.refresh();
  }

  update(picture, kind, facts) {
    const isShown = this.sheet.shows(picture);
    if (kind === "status") picture.status = facts.status;
    // A fit that was stopped before it began leaves the last frame of the one that it was to replace.
    if (facts.status === "stopped" && picture.frame) this.finish(picture, { ...picture.frame, psnr: null });
    if (kind === "mode") {
      Object.assign(picture, { mode: facts.mode, reason: facts.reason });
      if (picture === this.current) this.panel.show(picture.positions, picture.mode, picture.reason);
    }
    if (kind === "frame") {
      if (isShown && !picture.newest) setControl("split", 0);
      picture.frame = facts;
      if (isShown) this.sheet.showFrameSoon();
    }
    if (kind === "done") this.finish(picture, facts);
    if (kind === "failed") {
      Object.assign(picture, { frame: null, message: facts.message });
      if (isShown) this.view.endDrawing(null);
    }
  }

  finish(picture, facts) {
    // The stream has been interrupted, and tells again what is known: the drawing may have been edited since.
    if (picture.fit === facts.fit) return;
    const { svg, history, psnr, bytes, gzip_bytes, segments } = facts;
    const figures = { psnr, bytes, gzip_bytes, segments };
    const result = { fit: facts.fit, text: svg, history: history ?? [], figures, result: facts };
    Object.assign(picture, { frame: null, isSaved: false, ...result });
    if (this.sheet.shows(picture)) this.sheet.finish(picture);
  }

  /** Learns which pictures the server has, and gives it back those that it has lost: it was started again, or this
   * page did not answer for a while, as when the computer slept. */
  greet({ pictures }) {
    const isFirst = !this.hasMet;
    this.hasMet = true;
    if (isFirst) {
      // This page was loaded again. The state of each picture follows its drawing.
      for (const { status, ...facts } of pictures) {
        if (this.pictures.some(({ id }) => id === facts.id)) continue; // it was dropped before the server was found
        this.pictures.push(Object.assign(new PagePicture(facts.name, null, DEFAULT_POSITIONS), facts, { status: "idle" }));
      }
      if (this.pictures.length && !this.current) this.open(this.pictures[0]);
      return;
    }
    const known = new Set(pictures.map(({ id }) => id));
    for (const picture of this.pictures.filter(({ id, blob }) => id && blob && !known.has(id))) {
      picture.id = null;
      if (picture.isBusy) this.requestFit(picture, { ...this.sheet.present(picture), filled: null });
    }
  }

  async meet(facts) {
    this.saver.setUp(facts);
    find("folder-field").hidden = !facts.folder;
    if (!facts.folder) return;
    await this.attempt(async () => {
      const names = await this.server.folder();
      find("folder").replaceChildren(new Option("Open from the folder …", ""), ...names.map((name) => new Option(name)));
    });
  }

  lose(isOther) {
    find("lost").textContent = isOther ? OTHER_TEXT : LOST_TEXT;
    find("lost").hidden = false;
    this.refresh();
  }

  find() {
    find("lost").hidden = true;
    this.refresh();
  }

  // Saving

  /** Saves `text`, the drawing that the page shows, or that of a picture that is still being opened. */
  async save(text, format = "svg") {
    const picture = this.current;
    if (!picture?.newest) {
      this.view.say("There is no drawing to save yet");
      return;
    }
    const { newest, name } = picture;
    const isShown = this.sheet.shows(picture);
    const written = isShown ? this.sheet.exactText(text) : newest;
    await this.attempt(async () => {
      this.view.say(await this.saver.save(written, name, format, find("png-width").valueAsNumber || 1024));
      if (picture.newest !== newest) return; // there is a newer drawing by now
      picture.isSaved = true;
      if (isShown && this.sheet.shows(picture) && this.view.drawingText() === text) this.view.markSaved();
    });
  }

  /** Runs an action that the server may refuse; its words are shown, and kept with the `picture` whose fit it is. */
  async attempt(action, picture = null) {
    try {
      await action();
    } catch (error) {
      if (picture) Object.assign(picture, { message: error.message }, picture.status === "waiting" && { status: "failed" });
      this.view.say(error.message);
    }
    this.refresh();
  }

  // The panel

  refresh() {
    const { current, server } = this;
    this.list.show(this.pictures, current);
    find("empty").hidden = this.pictures.length > 0;
    showStatus(current, Boolean(current) && this.sheet.opening === current);
    find("stop").disabled = !current?.isBusy || !server.isOnline;
    find("restart").disabled = !current?.width || !server.isOnline || current.status === "waiting";
    const canSave = Boolean(current?.newest);
    for (const button of findAll("[data-format]")) {
      button.disabled = !canSave || (!server.isOnline && !["svg", "svgz"].includes(button.dataset.format));
    }
  }
}
