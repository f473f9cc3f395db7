/* Pictures come in: dropped, pasted or chosen files are read, sent, and drawn. */

import { find } from "viewer/dom.js";
import { PagePicture } from "app/picture.js";
import { pairs, read, take } from "app/reopening.js";

export class Arrivals {
  // The end of the last upload: one follows the other.
  turn = Promise.resolve();

  constructor(desk) {
    this.desk = desk;
  }

  /** Takes new pictures; the first of them is shown as soon as it has arrived. */
  add(files) {
    const { desk } = this;
    for (const [i, { name, file, drawing }] of pairs(files).entries()) {
      const picture = new PagePicture(name, file, desk.panel.positions);
      Object.assign(picture, { drawing, isFirst: i === 0 });
      desk.pictures.push(picture);
      this.turn = this.turn.then(() => this.begin(picture));
    }
    desk.refresh();
  }

  async addFromFolder(name) {
    const { desk } = this;
    find("folder").selectedIndex = 0;
    if (!name) return;
    await desk.attempt(async () => this.add([new File([await desk.server.fromFolder(name)], name)]));
  }

  /** Sends a new picture and asks for its drawing, once: those that were dropped before the server has said hello are
   * asked for then, too. */
  async begin(picture) {
    const { desk } = this;
    if (picture.isBeginning || picture.status !== "loading" || !desk.pictures.includes(picture)) return;
    picture.isBeginning = true;
    await this.bring(picture).finally(() => (picture.isBeginning = false));
  }

  async bring(picture) {
    const { desk } = this;
    try {
      const opened = picture.drawing && (await read(picture, desk.server));
      await this.upload(picture);
      if (opened) await take(picture, opened, desk.server);
    } catch (error) {
      if (!desk.pictures.includes(picture)) return; // Undo begins it again
      Object.assign(picture, { status: "failed", message: error.message });
      if (!desk.current || desk.current.status === "failed") desk.current = picture; // so that its message is seen
      desk.refresh();
      return;
    }
    if (!desk.pictures.includes(picture)) return; // it was removed in the meantime
    if (picture.drawing) picture.drawing = null;
    else await desk.requestFit(picture, {}, "again");
    if (picture.isFirst || !desk.current) await desk.open(picture);
  }

  /** Sends a picture, only once however many requests wait for it. */
  async upload(picture) {
    const { desk } = this;
    picture.arriving ??= desk.server.upload(picture);
    try {
      const { id, run, number, width, height } = await picture.arriving;
      Object.assign(picture, { id, run, number, width, height });
    } finally {
      picture.arriving = null;
    }
    if (!desk.pictures.includes(picture)) this.forget(picture);
  }

  /** Returns the address of the server's copy of a picture, which the server may have lost. */
  async previewUrl(picture) {
    if (!picture.id) await this.upload(picture);
    return this.desk.server.previewUrl(picture.id);
  }

  forget(picture) {
    clearTimeout(picture.timer);
    const { server } = this.desk;
    if (picture.id && server.isOnline) server.remove(picture.id).catch(() => {}); // it is gone in any case
  }
}
