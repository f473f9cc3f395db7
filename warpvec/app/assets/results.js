/* What the server says of the fits of pictures: their state, frames and results, and what becomes of edits then. */

import { setControl } from "app/parts.js";

// A stage that may take so long says so.
const LONG_SECONDS = 5;

function stageText({ words, seconds }) {
  return seconds >= LONG_SECONDS ? `${words}, up to some ${Math.ceil(seconds)} s` : words;
}

export class Results {
  constructor(desk) {
    this.desk = desk;
  }

  /** Takes news of a fit. Those of one that another has replaced may still be on their way. */
  update(picture, kind, facts) {
    if (facts.fit !== picture.asked.fit) return;
    const isShown = this.desk.sheet.shows(picture);
    if (kind === "stage") picture.stage = stageText(facts);
    if (kind === "status") this.setStatus(picture, facts.status);
    if (kind === "mode") {
      // A fit of a kind that was found before does not say why again.
      const known = facts.mode === picture.mode ? picture.reason : null;
      Object.assign(picture, { mode: facts.mode, reason: facts.reason ?? known });
      if (picture === this.desk.current) this.desk.panel.show(picture.positions, picture.mode, picture.reason);
    }
    if (kind === "frame") {
      if (isShown && !picture.newest) setControl("split", 0);
      picture.frame = facts;
      if (isShown) this.desk.sheet.showFrameSoon();
    }
    if (kind === "done") this.finish(picture, facts);
    if (kind === "failed") {
      Object.assign(picture, { frame: null, message: facts.message });
      this.giveUp(picture);
    }
  }

  setStatus(picture, status) {
    picture.status = status;
    if (status !== "fitting") picture.stage = "";
    if (!picture.isBusy) picture.isStopping = false;
    if (status !== "stopped") return;
    // A fit that was stopped before it began leaves the last frame of the one that it was to replace.
    if (picture.frame) this.finish(picture, { ...picture.frame, fit: picture.asked.fit, psnr: undefined });
    else if (picture.asked.positions !== picture.result?.positions) this.giveUp(picture);
  }

  /** Lets the drawing from before a fit without a result stand, with its settings. */
  giveUp(picture) {
    if (!this.desk.sheet.shows(picture)) return;
    this.desk.view.endDrawing();
    this.desk.follow(true);
  }

  finish(picture, facts) {
    // The stream has been interrupted, and tells again what is known: the drawing may have been edited since.
    if (picture.fit === facts.fit) return;
    // The last frame of a fit that was ended has not been measured as a file.
    const result = { ...facts, positions: picture.asked.positions, psnr: "mode" in facts ? facts.psnr : undefined };
    Object.assign(picture, { frame: null, isSaved: false, fit: facts.fit, result, isUnseen: true });
    if (this.desk.sheet.shows(picture)) this.show(picture);
  }

  /** Shows a result, or keeps the drawing with the edits for which the result has no place, until the user decides. */
  show(picture) {
    const { result } = picture;
    const erasing = result.left ? null : this.desk.sheet.eraseFrom(picture);
    if (erasing) this.desk.attempt(() => this.showErased(picture, result, erasing));
    else {
      picture.isUnseen = false;
      picture.proposal = this.desk.sheet.finish(picture);
      if (picture.proposal) this.desk.follow(true);
    }
  }

  /** Shows a result as soon as the server has erased from it what was erased before, if it is still wanted then. */
  async showErased(picture, result, erasing) {
    result.left = new Map();
    picture.message = "Erasing …";
    try {
      result.left = await erasing;
    } finally {
      picture.message = "";
      const isWanted = picture.result === result && picture.isUnseen && result.fit === picture.asked.fit;
      if (isWanted && this.desk.sheet.shows(picture)) this.show(picture);
    }
  }

  /** Takes the new drawing, without the edits that it has no place for, or keeps the user's own. */
  decide(isNew) {
    const picture = this.desk.current;
    if (isNew && picture.proposal) this.desk.sheet.finish(picture, true);
    picture.proposal = "";
    this.desk.refresh();
  }
}
