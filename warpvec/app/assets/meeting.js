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
  greet({ pictures }) {
    const isFirst = !this.hasMet;
    this.hasMet = true;
    if (isFirst) {
      // This page was loaded again. The state of each picture follows its drawing.
      for (const { status, ...facts } of pictures) {
        if (this.desk.pictures.some(({ id }) => id === facts.id)) continue; // it was dropped before the server was found
        this.desk.pictures.push(Object.assign(new PagePicture(facts.name, null, DEFAULT_POSITIONS), facts, { status: "idle" }));
      }
      if (this.desk.pictures.length && !this.desk.current) this.desk.open(this.desk.pictures[0]);
      return;
    }
    const known = new Set(pictures.map(({ id }) => id));
    for (const picture of this.desk.pictures.filter(({ id }) => id)) {
      if (!known.has(picture.id)) this.giveBack(picture);
      else if (picture.isBusy && picture.isStopping) this.desk.stop(picture); // the server may not have heard it
    }
  }

  /** Lets a fit that the server has lost begin again, unless the user has stopped it in the meantime. */
  giveBack(picture) {
    if (!picture.blob) return;
    picture.id = null;
    if (!picture.isBusy) return;
    if (picture.isStopping) this.desk.results.setStatus(picture, "stopped");
    else this.desk.requestFit(picture, { ...this.desk.sheet.present(picture), filled: null });
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
