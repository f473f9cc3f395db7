/* The drawing in the viewer's page: whose it is, the frames and results of its fits, and what the user has changed. */

import { find } from "viewer/dom.js";
import { hasShapes, shapesText } from "app/erased.js";
import { setControl } from "app/parts.js";
import { emptyDrawing } from "app/picture.js";

export class Sheet {
  // The picture whose drawing the page shows, and the one whose photo is being loaded to be shown next.
  picture = null;
  opening = null;

  constructor(view) {
    this.view = view;
  }

  /** Shows a picture as soon as its photo is loaded; without one, if this cannot be. Returns whether it is shown now. */
  async open(picture, findCopy) {
    this.opening = this.shows(picture) ? null : picture;
    if (!this.opening) return false;
    await picture.prepare((address) => this.view.loadPhoto(address), findCopy);
    if (this.opening !== picture) return false;
    this.keepEdits();
    this.put(picture);
    return true;
  }

  /** Shows a picture whose photo is loaded. */
  put(picture) {
    const { name, photo, kept, result } = picture;
    if (!kept) picture.isUnseen = false;
    const svg = result?.svg ?? emptyDrawing(picture);
    [this.picture, this.opening] = [picture, null];
    this.view.show({ svg, name, photo, kept, facts: result ? factsOf(picture, result) : { positions: null } });
    setControl("split", picture.newest ? 0 : 100);
    find("png-width").value = picture.width;
    if (picture.frame) this.view.showDrawing(picture.frame.svg);
  }

  clear() {
    [this.picture, this.opening] = [null, null];
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

  /** Returns a promise of what is left of shapes of the result without what has been erased; null for nothing erased. */
  eraseFrom(picture) {
    const { result, asked } = picture;
    if (asked.edits !== "again" || !this.view.isEdited) return null;
    return this.view.eraseFrom({ svg: result.svg, facts: factsOf(picture, result) });
  }

  /** Shows the result of a fit in place of its frames, with the edits of the drawing before.
   *
   * Returns in words the edits for which it has no place: then the drawing before stays, unless `isForced`. */
  finish(picture, isForced = false) {
    const { result } = picture;
    const { edits } = picture.asked;
    // A drawing that was fitted again has lost no more than the one before, and one that was cut out may have.
    const before = this.view.facts.notKept ?? [];
    if (picture.asked.more.cuts) result.not_kept = [...new Set([...before, ...(result.not_kept ?? [])])];
    result.not_kept ??= before;
    const left = this.view.finishDrawing({ svg: result.svg, facts: factsOf(picture, result), edits, isForced, left: result.left });
    if (!left && !this.view.isEdited) this.view.markSaved(); // as far as edits go; see `isSaved` of the picture
    return left;
  }

  /** Keeps the drawing of the shown picture with its edits and undo steps, before another is shown. */
  keepEdits() {
    const { picture, view } = this;
    if (!picture) return;
    if (view.state.live) view.endDrawing();
    Object.assign(picture, { kept: view.keep(), isSaved: picture.isSaved && !view.state.edited });
  }

  /** Returns the drawing to go on from, without edits, and the shapes that the user has deleted: all, and the new ones. */
  present(picture) {
    if (!this.shows(picture)) return picture.sent;
    if (!picture.newest) return {};
    const { view } = this;
    const text = !view.state.live && view.isEdited ? view.unedited() : this.exactText(view.drawingText());
    // Erased areas are filled in from around them in photos. Of flat art, the shapes below show there.
    const erased = view.deleted().filter(({ isArea }) => !isArea || picture.mode === "photo");
    const filled = erased.filter(({ isNew }) => isNew);
    picture.sent = {
      start: hasShapes(text) ? text : null, erased: shapesText(erased, picture), filled: shapesText(filled, picture),
    };
    return picture.sent;
  }

  /** Returns the file of the last fit instead of `text`, the drawing as the page writes it, if it has not been edited. */
  exactText(text) {
    const { written, text: exact } = this.view.facts;
    return exact && text === written ? exact : text;
  }
}

/** Returns the facts of a result that belong to its drawing. */
function factsOf({ asked, mode, reason }, result) {
  const { svg, text, history, psnr, bytes, gzip_bytes, segments, layers, not_kept: notKept, isByHand } = result;
  const figures = { bytes, gzip_bytes, segments, ...(psnr === undefined ? {} : { psnr }) };
  const known = Object.fromEntries(Object.entries(figures).filter(([, value]) => value !== undefined));
  const own = { history: history ?? [], text: text ?? svg, layers, notKept, isByHand };
  return { figures: known, ...own, mode, reason, positions: asked.positions };
}
