/* Small parts of the panel: what the present fit says, dropping and pasting files, and which side is shown. */

function showSide(name) {
  document.body.dataset.side = name;
}

/** Sets a control of the viewer's page as a user does. */
function setControl(id, value) {
  byId(id).value = value;
  byId(id).dispatchEvent(new Event("input", { bubbles: true }));
}

/** Says how the fit of a picture goes on; while it `isOpening`, its drawing is not there yet. */
function showStatus(picture, isOpening) {
  setText(byId("fit-status"), isOpening && !picture.isBusy ? "Opening …" : statusText(picture));
  const frame = picture?.isBusy ? picture.frame : null;
  byId("fit-progress").hidden = !picture?.isBusy;
  if (frame) byId("fit-progress").value = progressOf(frame);
  else byId("fit-progress").removeAttribute("value");
  const rows = figureRows(frame ?? (picture?.isBusy ? null : picture?.result), Boolean(frame));
  byId("fit-figures").hidden = !rows.length;
  fillRows(byId("fit-figures"), rows);
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
  const rows = [["Shapes", facts.paths.toLocaleString("en")], ["Size", `${facts.bytes.toLocaleString("en")} bytes`]];
  if (facts.psnr !== null) rows.push(["PSNR", `${facts.psnr.toFixed(2)} dB`, "How close the drawing is to the picture: 30 is good, 40 looks the same"]);
  const seconds = isRunning ? facts.left : facts.seconds;
  if (seconds !== null && seconds !== undefined) rows.push([isRunning ? "Time left" : "Time", formatSeconds(seconds)]);
  return rows;
}

function formatSeconds(seconds) {
  return seconds < 90 ? `${Math.ceil(seconds)} s` : `${Math.ceil(seconds / 60)} min`;
}

function fillRows(table, rows) {
  const body = table.tBodies[0];
  while (body.rows.length > rows.length) body.deleteRow(-1);
  rows.forEach(([name, text, hint], i) => {
    const row = body.rows[i] ?? addRow(body);
    setText(row.cells[0], name);
    setText(row.cells[1], text);
    row.title = hint ?? "";
  });
}

function addRow(body) {
  const row = body.insertRow();
  const head = document.createElement("th");
  head.scope = "row";
  row.append(head);
  row.insertCell();
  return row;
}

/** Changes a text only if it is another one, so that screen readers do not repeat it. */
function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

/** Takes pictures that are dropped anywhere on the page or pasted, and says what it does not take. */
function connectDropping(add, say) {
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
    if (files?.length && !found.length) say("This is no picture: drop a PNG, JPEG, WebP, TIFF, BMP or GIF file");
    add(found);
  });
  addEventListener("paste", (event) => {
    const files = pictures(event.clipboardData?.files);
    if (files.length) event.preventDefault();
    add(files);
  });
}
