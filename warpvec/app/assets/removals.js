/* Removing pictures from the list: asked for before if the drawing is not saved, and undone by Undo. */

import { nextVersion } from "viewer/commands.js";
import { find, setText } from "viewer/dom.js";

export class Removals {
  constructor(desk) {
    this.desk = desk;
    this.asked = null;
    find("removal").addEventListener("close", () => {
      if (find("removal").returnValue === "remove" && this.asked) this.remove(this.asked);
      this.asked = null;
    });
  }

  /** Removes a picture, unless its drawing is not saved and the user wants to keep it. */
  ask(picture) {
    if (this.desk.isSaved(picture)) {
      this.remove(picture);
      return;
    }
    this.asked = picture;
    setText("removal-text", `The drawing of ${picture.name} is not saved.`);
    find("removal").returnValue = "";
    find("removal").showModal();
  }

  remove(picture) {
    const { desk } = this;
    if (!desk.pictures.includes(picture)) return;
    if (desk.sheet.shows(picture)) desk.sheet.keepEdits();
    desk.removed.push({ picture, id: picture.id, place: desk.pictures.indexOf(picture), number: nextVersion() });
    desk.pictures = desk.pictures.filter((other) => other !== picture);
    desk.arrivals.forget(picture);
    Object.assign(picture, { id: null, frame: null });
    if (desk.current === picture) {
      desk.current = null;
      if (desk.pictures.length) desk.open(desk.pictures.at(-1));
      else desk.sheet.clear();
    }
    desk.refresh();
    desk.view.app.panel.request(); // Undo can be used now
    desk.view.say(`Removed ${picture.name}; Undo brings it back`);
  }

  /** Whether the last removal is newer than the last change of the drawing. */
  get canUndo() {
    const last = this.desk.removed.at(-1);
    return Boolean(last) && last.number > this.desk.view.app.commands.lastNumber;
  }

  /** Brings the picture back that was removed last, if nothing else was done since; returns whether it was. */
  undo() {
    if (!this.canUndo) return false;
    const { desk } = this;
    const { picture, place } = desk.removed.pop();
    desk.pictures = desk.pictures.toSpliced(place, 0, picture);
    if (picture.status === "loading") desk.arrivals.begin(picture);
    else if (picture.isBusy) desk.requestFit(picture, picture.asked.more);
    desk.open(picture).then(() => desk.view.say(`Undone: ${picture.name} is back`));
    return true;
  }
}
