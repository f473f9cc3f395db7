/* The desk: pictures come in, the server draws them, and the viewer's page shows and edits the drawing. */

const byId = (id) => document.getElementById(id);

// Time after the last move of a slider until the fit goes on with it.
const SETTLE_MS = 250;

class Desk {
  constructor(view) {
    this.view = view;
    this.pictures = [];
    this.current = null;
    this.shownText = null;
    this.list = new PictureList(byId("pictures"), (picture) => this.open(picture), (picture) => this.remove(picture));
    this.panel = new SettingsPanel((settings, name) => this.changeSettings(settings, name));
    this.server = new Server((kind, facts) => this.receive(kind, facts), () => this.lose(), () => this.find());
    this.saver = new Saver(this.server);
    this.connect();
    this.refresh();
  }

  connect() {
    for (const id of ["choose", "choose-first"]) byId(id).addEventListener("click", () => byId("files").click());
    byId("files").addEventListener("change", () => {
      this.add([...byId("files").files]);
      byId("files").value = "";
    });
    byId("stop").addEventListener("click", () => this.attempt(() => this.server.stop(this.current.id)));
    byId("restart").addEventListener("click", () => {
      this.current.erased = [];
      this.requestFit(this.current, {});
    });
    byId("folder").addEventListener("change", () => this.addFromFolder(byId("folder").value));
    for (const input of document.getElementsByName("side")) input.addEventListener("change", () => showSide(input.value));
    for (const button of document.querySelectorAll("[data-format]")) {
      button.addEventListener("click", () => this.save(this.view.drawingText(), button.dataset.format));
    }
    connectDropping((files) => this.add(files));
  }

  // Pictures

  add(files) {
    for (const file of files) {
      const picture = new Picture(file.name.replace(/\.[^.]+$/, "") || "picture", file, this.panel.settings);
      this.pictures.push(picture);
      this.uploading = (this.uploading ?? Promise.resolve()).then(() => this.begin(picture));
    }
    this.refresh();
  }

  async addFromFolder(name) {
    byId("folder").selectedIndex = 0;
    if (!name) return;
    await this.attempt(async () => this.add([new File([await this.server.fromFolder(name)], name)]));
  }

  /** Sends a new picture and asks for its drawing. */
  async begin(picture) {
    try {
      await this.upload(picture);
      await this.requestFit(picture, {});
      if (!this.current || !this.pictures.some((other) => other !== picture && other.isBusy)) await this.open(picture);
    } catch (error) {
      Object.assign(picture, { status: "failed", message: error.message });
      if (!this.current || this.current.status === "failed") this.current = picture; // so that its message is seen
    }
    this.refresh();
  }

  async upload(picture) {
    const { id, width, height } = await this.server.upload(picture.blob, picture.name);
    Object.assign(picture, { id, width, height });
  }

  async open(picture) {
    this.keepEdits();
    this.current = picture;
    this.panel.show(picture.settings, picture.mode, picture.reason);
    this.refresh();
    if (!picture.width) return;
    await picture.prepare(() => this.server.previewUrl(picture.id));
    if (this.current !== picture) return;
    const { name, photo, history, figures } = picture;
    const svg = picture.text ?? emptyDrawing(picture);
    this.box = boxOf(svg);
    await this.view.open({ svg, name, photo, history, figures });
    setControl("split", picture.newest ? 0 : 100);
    byId("png-width").value = picture.width;
    this.shownText = picture.text && this.view.drawingText();
    if (picture.frame) this.view.showDrawing(picture.frame.svg);
    this.refresh();
  }

  /** Keeps the edited drawing of the present picture, before another is shown. */
  keepEdits() {
    const { current, view } = this;
    if (!current?.text || view.state.live || view.drawingText() === this.shownText) return;
    this.present(current); // notes what has been deleted
    current.text = view.drawingText();
  }

  async remove(picture) {
    this.pictures = this.pictures.filter((other) => other !== picture);
    if (picture.id && this.server.isOnline) await this.server.remove(picture.id).catch(() => {});
    if (this.current === picture) {
      this.current = null;
      if (this.pictures.length) await this.open(this.pictures.at(-1));
      else await this.view.open({ name: "warpvec" });
    }
    this.refresh();
  }

  // Fits

  changeSettings(settings, name) {
    const picture = this.current;
    if (!picture) return;
    picture.settings = settings;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      const { filled, start, ...erased } = this.present(picture);
      this.requestFit(picture, name === "mode" ? erased : { start, ...erased });
    }, SETTLE_MS);
  }

  /** Returns the drawing to go on from, and the shapes that the user has deleted from it: all, and the new ones. */
  present(picture) {
    const isShown = picture === this.current && picture.newest;
    const text = isShown ? this.exactText(this.view.drawingText()) : picture.newest;
    if (!text) return {};
    const isEdited = isShown && !this.view.state.live && this.shownText && text !== picture.text;
    const lost = isEdited ? lostPaths(this.shownText, text) : [];
    const known = new Set(lost.map(({ d }) => d));
    picture.erased = [...stillLost(picture.erased, text).filter(({ d }) => !known.has(d)), ...lost];
    const start = /<path/.test(text) ? text : null;
    return { start, erased: shapesText(picture.erased, picture), filled: shapesText(lost, picture) };
  }

  /** Returns the file of the last fit instead of `text`, the drawing as the page writes it, if it has not been edited. */
  exactText(text) {
    const { current, view } = this;
    return current?.text && !view.state.live && text === this.shownText ? current.text : text;
  }

  async requestFit(picture, more) {
    if (!picture) return;
    const request = { settings: settingsForServer(picture.settings), ...more };
    await this.attempt(async () => {
      if (!picture.id) await this.upload(picture);
      Object.assign(picture, { status: "waiting", message: "" });
      this.refresh();
      await this.server.fit(picture.id, request).catch(async (error) => {
        if (error.status !== 404 || !picture.blob) throw error;
        await this.upload(picture); // the server has forgotten it
        await this.server.fit(picture.id, request);
      });
    });
    this.refresh();
  }

  /** Fits the edited drawing again; the paths at `locked` stay, and deleted ones are filled in. */
  async fitAgain(text, locked) {
    if (!this.current?.newest) {
      this.view.say("There is no drawing to fit again yet");
      return;
    }
    await this.requestFit(this.current, { ...this.present(this.current), start: text, locked, keepsPaths: true });
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
    const isCurrent = picture === this.current;
    if (kind === "status") picture.status = facts.status;
    if (kind === "mode") {
      Object.assign(picture, { mode: facts.mode, reason: facts.reason });
      if (isCurrent) this.panel.show(picture.settings, picture.mode, picture.reason);
    }
    if (kind === "frame") {
      if (isCurrent && !picture.newest) setControl("split", 0);
      picture.frame = facts;
      if (isCurrent) this.showFrameSoon();
    }
    if (kind === "done") this.finish(picture, facts);
    if (kind === "failed") {
      Object.assign(picture, { frame: null, message: facts.message });
      if (isCurrent) this.view.endDrawing(null);
    }
  }

  /** Shows the newest frame when the browser draws next: frames that came in between are left out. */
  showFrameSoon() {
    if (this.pending) return;
    this.pending = requestAnimationFrame(() => {
      this.pending = null;
      const { frame } = this.current ?? {};
      if (frame) this.view.showDrawing(frame.svg);
    });
  }

  finish(picture, facts) {
    const { svg, history, psnr, bytes, gzip_bytes, segments } = facts;
    const figures = { psnr, bytes, gzip_bytes, segments };
    Object.assign(picture, { frame: null, text: svg, history: history ?? [], figures, result: facts });
    if (picture !== this.current || !picture.photo) return;
    if (boxOf(svg) !== this.box) {
      // Other user units: what was measured before, and earlier edits, are in the old ones.
      this.open(picture);
      return;
    }
    this.view.showDrawing(svg);
    this.view.endDrawing("Fit");
    this.view.showFigures(Object.fromEntries(Object.entries(figures).filter(([, value]) => value !== undefined)));
    this.view.markSaved();
    this.shownText = this.view.drawingText();
  }

  /** Learns which pictures the server has, and gives it back those that it has lost: it was started again, or this
   * page did not answer for a while, as when the computer slept. */
  greet({ pictures }) {
    const known = new Set(pictures.map(({ id }) => id));
    for (const facts of pictures) {
      if (this.pictures.some(({ id }) => id === facts.id)) continue;
      const picture = Object.assign(new Picture(facts.name, null, DEFAULT_SETTINGS), facts);
      this.pictures.push(picture);
      if (!this.current) this.open(picture);
    }
    const isFirst = !this.hasMet;
    this.hasMet = true;
    if (isFirst) return;
    for (const picture of this.pictures.filter(({ id, blob }) => id && blob && !known.has(id))) {
      picture.id = null;
      if (picture.isBusy) this.requestFit(picture, { ...this.present(picture), filled: null });
    }
  }

  async meet(facts) {
    this.saver.setUp(facts);
    byId("folder-field").hidden = !facts.folder;
    if (!facts.folder) return;
    const names = await this.server.folder();
    byId("folder").replaceChildren(new Option("Open from the folder …", ""), ...names.map((name) => new Option(name)));
  }

  lose() {
    byId("lost").textContent =
      "The server has ended. The drawing stays on this page and can be saved as SVG. Run warpvec app again to go on: this page finds it by itself.";
    byId("lost").hidden = false;
    this.refresh();
  }

  find() {
    byId("lost").hidden = true;
    this.refresh();
  }

  // Saving

  async save(text, format = "svg") {
    if (!this.current?.newest) {
      this.view.say("There is no drawing to save yet");
      return;
    }
    await this.attempt(async () => {
      const name = this.current?.name ?? "drawing";
      const written = this.exactText(text);
      this.view.say(await this.saver.save(written, name, format, byId("png-width").valueAsNumber || 1024));
      this.view.markSaved();
    });
  }

  /** Runs an action that the server may refuse; its words are shown. */
  async attempt(action) {
    try {
      await action();
    } catch (error) {
      if (this.current?.status === "waiting") this.current.status = "failed";
      if (this.current) this.current.message = error.message;
      this.view.say(error.message);
    }
    this.refresh();
  }

  // The panel

  refresh() {
    const { current, server } = this;
    this.list.show(this.pictures, current);
    byId("empty").hidden = this.pictures.length > 0;
    showStatus(current);
    byId("stop").disabled = !current?.isBusy || !server.isOnline;
    byId("restart").disabled = !current?.width || !server.isOnline || current.status === "waiting";
    const canSave = Boolean(current?.newest);
    for (const button of document.querySelectorAll("[data-format]")) {
      button.disabled = !canSave || (!server.isOnline && !["svg", "svgz"].includes(button.dataset.format));
    }
  }
}

function startDesk() {
  document.querySelector("header").after(byId("lost"), byId("sides"), byId("desk"));
  byId("stage").append(byId("empty"));
  showSide("make");
  const desk = new Desk(window.warpvecView);
  window.desk = {
    fitAgain: (text, locked) => desk.fitAgain(text, locked),
    save: (text) => desk.save(text),
  };
  document.body.dataset.desk = "ready";
}

/** Waits until the viewer's page has started. */
function whenReady(action) {
  if (document.body.dataset.ready) action();
  else new MutationObserver((_, observer) => {
    if (!document.body.dataset.ready) return;
    observer.disconnect();
    action();
  }).observe(document.body, { attributes: true });
}

whenReady(startDesk);
