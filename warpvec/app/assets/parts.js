/* Small parts of the panel: what the present fit says, dropping and pasting files, and which side is shown. */

import { formatBytes, formatDb } from "viewer/charts.js";
import { fillTable, find, setText } from "viewer/dom.js";
import { progressOf } from "app/picture.js";

const PSNR_HINT = "How close the drawing is to the picture: 30 is good, at 40 they look the same";

export function showSide(name) {
  document.body.dataset.side = name;
}

/** Sets a control of the viewer's page as a user does. */
export function setControl(id, value) {
  find(id).value = value;
  find(id).dispatchEvent(new Event("input", { bubbles: true }));
}

/** Says how the fit of a picture goes on; while it `isOpening`, its drawing is not there yet. */
export function showStatus(picture, isOpening) {
  setText("fit-status", isOpening && !picture.isBusy ? "Opening …" : statusText(picture));
  const frame = picture?.isBusy ? picture.frame : null;
  find("fit-progress").hidden = !picture?.isBusy;
  if (frame) find("fit-progress").value = progressOf(frame);
  else find("fit-progress").removeAttribute("value");
  const rows = figureRows(frame ?? (picture?.isBusy ? null : picture?.result), Boolean(frame));
  find("fit-figures").hidden = !rows.length;
  fillTable(find("fit-figures"), rows);
}

function statusText(picture) {
  if (!picture) return "Drop a picture, paste one, or choose one.";
  if (picture.message) return picture.message;
  const words = {
    loading: "Loading …", idle: "", failed: "The drawing failed.", done: "The drawing is done.",
    waiting: picture.place ? `Waiting for ${picture.place} other ${picture.place === 1 ? "drawing" : "drawings"} …` : "Starting …",
    fitting: "Drawing …",
    stopped: picture.newest ? "Stopped: this is the best drawing so far." : "Stopped before there was a drawing.",
  };
  return words[picture.status];
}

function figureRows(facts, isRunning) {
  if (!facts) return [];
  const rows = [["Paths", facts.paths.toLocaleString("en")], ["File size", formatBytes(facts.bytes)]];
  if (facts.psnr !== null) rows.push(["PSNR", formatDb(facts.psnr), PSNR_HINT]);
  const seconds = isRunning ? facts.left : facts.seconds;
  if (seconds !== null && seconds !== undefined) rows.push([isRunning ? "Time left" : "Time", formatSeconds(seconds)]);
  return rows;
}

function formatSeconds(seconds) {
  return seconds < 90 ? `${Math.ceil(seconds)} s` : `${Math.ceil(seconds / 60)} min`;
}

/** Takes pictures that are dropped anywhere on the page or pasted, and says what it does not take. */
export function connectDropping(add, say) {
  const pictures = (list) => [...(list ?? [])].filter(({ type }) => !type || type.startsWith("image/"));
  addEventListener("dragover", (event) => {
    event.preventDefault();
    document.body.classList.add("dropping");
  });
  addEventListener("dragleave", (event) => {
    if (!event.relatedTarget) document.body.classList.remove("dropping");
  });
  addEventListener("drop", (event) => {
    event.preventDefault();
    document.body.classList.remove("dropping");
    const { files, items } = event.dataTransfer ?? {};
    if ([...(items ?? [])].some((item) => item.webkitGetAsEntry?.()?.isDirectory)) {
      say("A folder cannot be dropped: drop the pictures in it, or run warpvec app FOLDER");
      return;
    }
    const found = pictures(files);
    if (files?.length && !found.length) say("This is not a picture: drop a PNG, JPEG, WebP, TIFF, BMP or GIF file");
    add(found);
  });
  addEventListener("paste", (event) => {
    const files = pictures(event.clipboardData?.files);
    if (files.length) event.preventDefault();
    add(files);
  });
}
