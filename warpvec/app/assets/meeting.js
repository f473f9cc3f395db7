/* Finds the server, loses it and finds it again: which pictures each side has then, and what the user is told. */

import { find } from "viewer/dom.js";
import { DEFAULT_POSITIONS } from "app/controls.js";
import { PagePicture } from "app/picture.js";

const LOST_TEXT =
  "The server has ended. The drawing stays on this page and can be saved as SVG. " +
  "Run warpvec app again to go on: this page then connects to it.";

const OTHER_TEXT =
  "Another server answers at this address. The drawing stays on this page and can be saved as SVG. " +
  "To go on, open the address that warpvec app has printed.";

export class Meeting {
  constructor(desk) {
    this.desk = desk;
  }

  /** Learns which pictures the server has, and gives it back those that it has lost: it was started again, or this
   * page did not answer for a while, as when the computer slept. */
  greet({ run, count, pictures }) {
    const { desk } = this;
    const isFirst = !this.hasMet;
    this.hasMet = true;
    if (isFirst && !desk.memory.knows) this.addUnknown(pictures);
    const known = new Map(pictures.map((facts) => [facts.id, facts]));
    for (const { id } of desk.removed) if (known.has(id)) desk.server.remove(id).catch(() => {}); // it did not hear of that
    for (const picture of desk.pictures.filter(({ id }) => id)) {
      // It has come, or is asked for, since the server wrote this.
      if (picture.asking || (picture.run === run && picture.number > count)) continue;
      const theirs = known.get(picture.id);
      // The server may not have heard of the fit before the page was loaded again, or of the wish to stop.
      if (!theirs) this.giveBack(picture);
      else if (isFirst && theirs.fit !== picture.asked.fit) this.fitOnceMore(picture);
      else if (picture.isBusy && picture.isStopping) desk.stop(picture);
    }
    if (!isFirst) return;
    for (const picture of desk.pictures) this.goOn(picture);
    if (desk.pictures.length && !desk.current) desk.open(desk.wanted ?? desk.pictures[0]);
  }

  /** Lists the pictures of a page that was loaded again without what it should have kept: the storage is blocked. The
   * state of each picture follows its drawing. */
  addUnknown(pictures) {
    for (const { status, fit, ...facts } of pictures) {
      if (this.desk.pictures.some(({ key }) => key === facts.key)) continue; // it was dropped before the server was found
      const picture = new PagePicture(facts.name, null, DEFAULT_POSITIONS);
      this.desk.pictures.push(Object.assign(picture, facts, { status: "idle", asked: { ...picture.asked, fit } }));
    }
  }

  /** Lets what was under way begin again when the page was loaded again. */
  goOn(picture) {
    if (picture.status === "loading" && (picture.blob || picture.drawing)) this.desk.arrivals.begin(picture);
    else if (picture.moved && !picture.isBusy) this.desk.fitWithSettings(picture);
  }

  giveBack(picture) {
    if (!picture.blob) return;
    picture.id = null;
    this.fitOnceMore(picture);
  }

  /** Asks for a fit that was under way, unless the user has stopped it in the meantime: from the last frame if that is
   * shown, but an edited drawing from its start. */
  fitOnceMore(picture) {
    if (!picture.isBusy) return;
    if (picture.isStopping) {
      this.desk.results.setStatus(picture, "stopped");
      return;
    }
    const { more } = picture.asked;
    const goesOn = this.desk.sheet.shows(picture) && !more.keepsPaths;
    this.desk.requestFit(picture, goesOn ? { ...this.desk.sheet.present(picture), filled: null } : more);
  }

  async meet(facts) {
    this.desk.saver.setUp(facts);
    this.desk.making.setUp(facts);
    find("folder-field").hidden = !facts.folder;
    if (!facts.folder) return;
    await this.desk.attempt(async () => {
      const names = await this.desk.server.folder();
      // Without a value of its own, an option has its text, in which line breaks are spaces.
      const options = names.map((name) => new Option(name, name));
      find("folder").replaceChildren(new Option("Open from the folder …", ""), ...options);
    });
  }

  lose(isOther) {
    find("lost").textContent = isOther ? OTHER_TEXT : LOST_TEXT;
    find("lost").hidden = false;
    this.desk.refresh();
  }

  find() {
    find("lost").hidden = true;
    this.desk.refresh();
  }
}
