/* The desk: pictures come in, the server draws them, and the viewer's page shows and edits the drawing. */

import { nextVersion } from "viewer/commands.js";
import { find, findAll, findNamed, setText } from "viewer/dom.js";
import { Arrivals } from "app/arrivals.js";
import { ControlPanel, settingsForServer } from "app/controls.js";
import { MakePanel } from "app/making.js";
import { Meeting } from "app/meeting.js";
import { connectDropping, showSide, showStatus } from "app/parts.js";
import { PictureList } from "app/queue.js";
import { Removals } from "app/removals.js";
import { Results } from "app/results.js";
import { Saver } from "app/saving.js";
import { Server } from "app/server.js";
import { Sheet } from "app/sheet.js";

// Time after the last move of a slider until the fit goes on with it.
const SETTLE_MS = 250;

/** Tells whether the settings of a picture ask for its drawing, of flat art, without overlaps, and for nothing else.
 *
 * @param {any} picture
 * @param {any} positions those of the drawing */
function onlyCuts({ positions: wanted, mode, newest }, positions) {
  if (!newest || !positions || !mode || mode === "photo") return false;
  const [now, then] = [wanted, positions].map(settingsForServer);
  const isSame = (name) => now[name] === then[name] || (name === "mode" && ["auto", mode].includes(now.mode));
  return now.cutout && !then.cutout && Object.keys(now).every((name) => name === "cutout" || isSame(name));
}

export class Desk {
  constructor(view, page, memory) {
    this.view = view;
    this.memory = memory;
    this.sheet = new Sheet(view);
    this.pictures = [];
    this.current = null;
    // Those that Undo brings back, and the picture that was shown before the page was loaded again.
    this.removed = [];
    this.wanted = null;
    this.removals = new Removals(this);
    this.list = new PictureList(find("pictures"), (picture) => this.open(picture), (picture) => this.removals.ask(picture));
    this.arrivals = new Arrivals(this);
    this.results = new Results(this);
    this.meeting = new Meeting(this);
    this.panel = new ControlPanel((positions, name) => this.changeSettings(positions, name));
    const { meeting } = this;
    this.memory.restore(this);
    this.server = new Server(page, (kind, facts) => this.receive(kind, facts), (isOther) => meeting.lose(isOther), () => meeting.find());
    this.saver = new Saver(this.server);
    this.making = new MakePanel(this);
    this.connect();
    this.refresh();
  }

  connect() {
    for (const id of ["choose", "choose-first"]) find(id).addEventListener("click", () => find("files").click());
    find("files").addEventListener("change", () => {
      this.arrivals.add([...find("files").files]);
      find("files").value = "";
    });
    find("stop").addEventListener("click", () => this.stop(this.current));
    find("restart").addEventListener("click", () => this.requestFit(this.current, {}, "dropped"));
    find("keep-mine").addEventListener("click", () => this.results.decide(false));
    find("take-new").addEventListener("click", () => this.results.decide(true));
    this.view.onChange = () => this.follow();
    find("folder").addEventListener("change", () => this.arrivals.addFromFolder(find("folder").value));
    for (const input of findNamed("side")) input.addEventListener("change", () => showSide(input.value));
    for (const button of findAll("[data-format]")) {
      button.addEventListener("click", () => this.save(this.view.drawingText(), button.dataset.format));
    }
    find("save-for").addEventListener("click", () => this.save(this.view.drawingText(), this.saver.use.kind, this.saver.use.purpose));
    find("purpose").addEventListener("change", () => this.refresh());
    connectDropping((files) => this.arrivals.add(files), (words) => this.view.say(words));
    document.addEventListener("change", () => this.memory.note(this)); // boxes are no part of a drawing
    addEventListener("beforeunload", (event) => {
      if (!this.memory.isWritten || this.pictures.some((picture) => !this.isSaved(picture))) event.preventDefault();
    });
  }

  // Pictures

  async open(picture) {
    this.current = picture;
    this.panel.show(picture.positions, picture.mode, picture.reason);
    const opened = picture.width ? this.sheet.open(picture, () => this.arrivals.previewUrl(picture)) : null;
    this.refresh();
    await this.attempt(async () => {
      if ((await opened) && picture.isUnseen) this.results.show(picture);
    });
  }

  /** Tells whether the drawing of a picture has been saved with all edits; also if there is none. */
  isSaved(picture) {
    return picture.isClean && !(this.sheet.shows(picture) && this.view.state.edited);
  }

  // Fits

  changeSettings(positions, name) {
    this.making.show();
    const picture = this.current;
    if (!picture) return;
    Object.assign(picture, { positions, moved: name, proposal: "" });
    clearTimeout(picture.timer);
    if (picture.status === "loading") return; // its first fit will have them
    picture.timer = setTimeout(() => this.fitWithSettings(picture), SETTLE_MS);
  }

  /** Lets the drawing follow its settings; if these only ask to cut it out, then the drawing itself, with its edits. */
  fitWithSettings(picture) {
    if (this.sheet.shows(picture) && onlyCuts(picture, this.view.facts.positions)) {
      this.view.app.endKeys();
      const start = this.sheet.exactText(this.view.shownText());
      return this.requestFit(picture, { start, cuts: true }, "included");
    }
    const { filled, start, ...erased } = this.sheet.present(picture);
    return this.requestFit(picture, picture.moved === "mode" ? erased : { start, ...erased }, "again");
  }

  async requestFit(picture, more, edits = picture?.asked.edits) {
    if (!picture) return;
    clearTimeout(picture.timer);
    const asked = { fit: nextVersion(), positions: picture.positions, edits, more };
    Object.assign(picture, { proposal: "", isStopping: false, moved: null, asked, asking: asked });
    const settings = settingsForServer(picture.positions);
    // Its own drawing has shown what the picture is: a look at the picture alone may say otherwise.
    if ((more.keepsPaths || more.cuts) && picture.mode) settings.mode = picture.mode;
    const request = { fit: asked.fit, settings, ...more };
    const isWanted = () => picture.asked === asked && this.pictures.includes(picture);
    await this.attempt(async () => {
      if (!picture.id) await this.arrivals.upload(picture);
      if (!isWanted()) return;
      Object.assign(picture, { status: "waiting", message: "" });
      this.refresh();
      await this.server.fit(picture.id, request).catch(async (error) => {
        if (error.status !== 404 || !picture.blob) throw error;
        await this.arrivals.upload(picture); // the server has forgotten it
        if (isWanted()) await this.server.fit(picture.id, request);
      });
      if (isWanted() && picture.isStopping) await this.server.stop(picture.id); // the user did not wait for the answer
    }, picture);
    if (picture.asking === asked) picture.asking = null;
  }

  /** Fits the edited drawing again; the paths at `locked` stay, and deleted ones are filled in. */
  async fitAgain(text, locked) {
    const picture = this.current;
    if (!picture?.newest || !this.sheet.shows(picture)) {
      this.view.say("There is no drawing to fit again yet");
      return;
    }
    const before = this.view.unedited();
    const start = this.sheet.exactText(text);
    await this.requestFit(picture, { ...this.sheet.present(picture), start, before, locked, keepsPaths: true }, "included");
  }

  /** Ends the fit of a picture. A server that does not have the picture is told later; see `requestFit` and `Meeting`. */
  async stop(picture) {
    picture.isStopping = true;
    this.refresh();
    if (!picture.id) return;
    const isForgotten = (error) => error.status === 404;
    await this.attempt(() => this.server.stop(picture.id).catch((error) => isForgotten(error) || Promise.reject(error)));
  }

  /** Shows the settings of the drawing that the page shows: undo and redo bring back others. */
  follow(isSure = false) {
    const picture = this.sheet.picture;
    const { facts } = this.view;
    this.making.forget();
    const isOther = this.followed !== facts.text;
    this.followed = facts.text;
    if (picture && facts.positions && (isSure || (isOther && !picture.isBusy && !picture.moved)) && !this.view.state.live) {
      clearTimeout(picture.timer);
      Object.assign(picture, { positions: facts.positions, mode: facts.mode, reason: facts.reason });
      if (picture === this.current) this.panel.show(picture.positions, picture.mode, picture.reason);
    }
    this.refresh();
  }

  // Events

  receive(kind, facts) {
    if (kind === "hello") this.meeting.greet(facts);
    else if (kind === "server") this.meeting.meet(facts);
    else if (kind === "queue") for (const picture of this.pictures) picture.place = facts.places[picture.id] ?? 0;
    const picture = this.pictures.find(({ id }) => id && id === facts.id);
    if (picture) this.results.update(picture, kind, facts);
    this.refresh();
  }

  // Saving

  /** Saves `text`, the drawing that the page shows, or that of a picture that is still being opened. */
  async save(text, format = "svg", purpose = "") {
    const picture = this.current;
    if (!picture?.newest) {
      this.view.say("There is no drawing to save yet");
      return;
    }
    const { newest, name } = picture;
    const isShown = this.sheet.shows(picture);
    const written = isShown ? this.sheet.exactText(text) : newest;
    await this.attempt(async () => {
      this.view.say(await this.saver.save(written, name, format, find("png-width").valueAsNumber || 1024, purpose));
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
    const figures = this.sheet.shows(current) && !this.view.state.live ? this.view.figures : null;
    showStatus(current, Boolean(current) && this.sheet.opening === current, figures);
    find("proposal").hidden = !current?.proposal;
    setText("proposal-text", `The new drawing has no place for: ${current?.proposal}.`);
    find("stop").disabled = !current?.isBusy || current.isStopping || !server.isOnline;
    find("restart").disabled = !current?.width || !server.isOnline || current.status === "waiting";
    this.memory.note(this);
    this.making.show();
    const canSave = Boolean(current?.newest);
    this.saver.showUse(canSave ? this.view.app.panel.size.sizeIn("mm") : null);
    find("save").disabled = !canSave;
    const { kind, purpose } = this.saver.use;
    find("save-for").disabled = !canSave || (!server.isOnline && (kind !== "svg" || Boolean(purpose)));
    for (const button of findAll("[data-format]")) {
      button.disabled = !canSave || (!server.isOnline && !["svg", "svgz"].includes(button.dataset.format));
    }
  }
}
