/* Small parts of the panel: what the present fit says, dropping and pasting files, and which side is shown. */

import { formatBytes, formatDb, MEASURING } from "viewer/charts.js";
import { fillTable, find, setText } from "viewer/dom.js";
import { progressOf } from "app/picture.js";
import { isDrawing } from "app/reopening.js";

const CLOSENESS_HINT = "How close the drawing is to the picture: 30 is good, at 40 they look the same";

export function showSide(name) {
  document.body.dataset.side = name;
}

/** Sets a control of the viewer's page as a user does. */
export function setControl(id, value) {
  find(id).value = value;
  find(id).dispatchEvent(new Event("input", { bubbles: true }));
}

/** Says how the fit of a picture goes on; while it `isOpening`, its drawing is not there yet. `figures` are those of the
 * drawing that is shown, when no fit is running. */
export function showStatus(picture, isOpening, figures) {
  setText("fit-status", isOpening && !picture.isBusy ? "Opening …" : statusText(picture));
  const frame = picture?.isBusy ? picture.frame : null;
  find("fit-progress").hidden = !picture?.isBusy;
  if (frame) find("fit-progress").value = progressOf(frame);
  else find("fit-progress").removeAttribute("value");
  const rows = frame ? frameRows(frame) : picture?.isBusy || !picture?.result || !figures ? [] : resultRows(figures, picture.result);
  find("fit-figures").hidden = !rows.length;
  fillTable(find("fit-figures"), rows);
}

function statusText(picture) {
  if (!picture) return "Drop a picture, paste one, or choose one.";
  if (picture.isStopping && picture.isBusy) return "Stopping …";
  if (picture.message) return picture.message;
  if (picture.proposal && !picture.isBusy) return "Your drawing is kept.";
  const words = {
    loading: "Loading …", idle: "", failed: "The drawing failed.", done: "The drawing is done.",
    waiting: picture.place ? `Waiting for ${picture.place} other ${picture.place === 1 ? "drawing" : "drawings"} …` : "Starting …",
    fitting: picture.stage ? `Drawing: ${picture.stage} …` : "Drawing …",
    stopped: picture.newest ? "Stopped: this is the best drawing so far." : "Stopped before there was a drawing.",
  };
  return words[picture.status];
}

/** Returns the figures of a frame. Under a limit of bytes, its size is not that of the file, which is found at the end. */
function frameRows({ paths, psnr, left }) {
  const rows = paths === null ? [] : [["Paths", paths.toLocaleString("en")]];
  if (psnr !== null) rows.push(["Closeness", formatDb(psnr), CLOSENESS_HINT]);
  if (left !== null && left !== undefined) rows.push(["Time left", formatSeconds(left)]);
  return rows;
}

/** Returns the figures of the drawing, as everywhere on the page, and the time that its fit took. */
function resultRows({ bytes, psnr }, { seconds }) {
  const rows = [["File size", bytes === undefined ? MEASURING : formatBytes(bytes)]];
  rows.push(["Closeness", psnr === undefined ? MEASURING : formatDb(psnr), CLOSENESS_HINT]);
  if (seconds !== undefined) rows.push(["Time", formatSeconds(seconds)]);
  return rows;
}

function formatSeconds(seconds) {
  return seconds < 90 ? `${Math.ceil(seconds)} s` : `${Math.ceil(seconds / 60)} min`;
}

/** Takes pictures that are dropped anywhere on the page or pasted, and says what it does not take. */
export function connectDropping(add, say) {
  const isTaken = ({ type, name }) => !type || type.startsWith("image/") || type === "application/pdf" || isDrawing({ type, name });
  const pictures = (list) => [...(list ?? [])].filter(isTaken);
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
    if (files?.length && !found.length) {
      say("This is neither a picture nor an SVG: drop a file such as PNG, JPEG, WebP, AVIF, TIFF, PSD, PDF or SVG");
    }
    add(found);
  });
  addEventListener("paste", (event) => {
    const files = pictures(event.clipboardData?.files);
    if (files.length) event.preventDefault();
    add(files);
  });
}
