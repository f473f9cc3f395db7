/* The drawing in the viewer's page: whose it is, the frames and results of its fits, and what the user has changed. */

import { find } from "viewer/dom.js";
import { boxOf, hasShapes, lostPaths, shapesText, stillLost } from "app/erased.js";
import { setControl } from "app/parts.js";
import { emptyDrawing } from "app/picture.js";

export class Sheet {
  // The picture whose drawing the page shows, and the one whose photo is being loaded to be shown next.
  picture = null;
  opening = null;
  // The drawing as the page has written it when it was opened, and its user units.
  text = null;
  box = "";

  constructor(view) {
    this.view = view;
  }

  /** Shows a picture as soon as its photo is loaded; without one, if this cannot be. */
  async open(picture, previewUrl) {
    this.opening = this.shows(picture) ? null : picture;
    if (!this.opening) return;
    await picture.prepare((address) => this.view.loadPhoto(address), previewUrl);
    if (this.opening !== picture) return;
    this.keepEdits();
    this.put(picture);
  }

  /** Shows a picture whose photo is loaded. */
  put(picture) {
    const { name, photo, history, figures } = picture;
    const svg = picture.text ?? emptyDrawing(picture);
    [this.picture, this.opening, this.box] = [picture, null, boxOf(svg)];
    this.view.show({ svg, name, photo, history, figures });
    setControl("split", picture.newest ? 0 : 100);
    find("png-width").value = picture.width;
    this.text = picture.text && this.view.drawingText();
    if (picture.frame) this.view.showDrawing(picture.frame.svg);
  }

  clear() {
    [this.picture, this.opening, this.text] = [null, null, null];
    this.view.show({ name: "warpvec" });
  }

  shows(picture) {
    return Boolean(picture) && this.picture === picture;
  }

  /** Shows the newest frame when the browser draws next: frames that came in between are left out. */
  showFrameSoon() {
    this.pending ??= requestAnimationFrame(() => {
      this.pending = null;
      const { frame } = this.picture ?? {};
      if (frame) this.view.showDrawing(frame.svg);
    });
  }

  /** Shows the result of a fit in place of its frames. */
  finish(picture) {
    if (boxOf(picture.text) !== this.box) {
      // Other user units: what was measured before, and earlier edits, are in the old ones.
      this.put(picture);
      return;
    }
    this.view.showDrawing(picture.text);
    this.view.endDrawing("Fit");
    this.view.showFigures(Object.fromEntries(Object.entries(picture.figures).filter(([, value]) => value !== undefined)));
    this.view.markSaved(); // as far as edits go; see `isSaved` of the picture
    this.text = this.view.drawingText();
  }

  /** Keeps the edited drawing of the shown picture, before another is shown. */
  keepEdits() {
    const { picture, view } = this;
    if (!picture?.text || view.state.live) return;
    const text = view.drawingText();
    if (text === this.text) return;
    this.present(picture); // notes what has been deleted
    Object.assign(picture, { text, isSaved: !view.state.edited });
  }

  /** Returns the drawing to go on from, and the shapes that the user has deleted from it: all, and the new ones. */
  present(picture) {
    const isShown = this.shows(picture) && picture.newest;
    const text = isShown ? this.exactText(this.view.drawingText()) : picture.newest;
    if (!text) return {};
    const isEdited = isShown && !this.view.state.live && this.text && text !== picture.text;
    const lost = isEdited ? lostPaths(this.text, text) : [];
    const known = new Set(lost.map(({ d }) => d));
    picture.erased = [...stillLost(picture.erased, text).filter(({ d }) => !known.has(d)), ...lost];
    const start = hasShapes(text) ? text : null;
    return { start, erased: shapesText(picture.erased, picture), filled: shapesText(lost, picture) };
  }

  /** Returns the file of the last fit instead of `text`, the drawing as the page writes it, if it has not been edited. */
  exactText(text) {
    const { picture, view } = this;
    return picture?.text && !view.state.live && text === this.text ? picture.text : text;
  }
}
