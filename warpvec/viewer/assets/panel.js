/* The controls beside the drawing: they show the state and pass on the user's actions. */

import { FitAgain } from "viewer/again.js";
import { formatBytes, formatDb, MEASURING, plotHistory, settingRows } from "viewer/charts.js";
import {
  connectClicks, fillSelect, fillTable, find, findAll, onInput, onPick, setChoice, setText, setValue,
} from "viewer/dom.js";
import { EditPanel } from "viewer/editpanel.js";
import { countedKinds } from "viewer/kinds.js";
import { LayerTable } from "viewer/layers.js";
import { formatNumber } from "viewer/paths.js";
import { runUntil } from "viewer/raster.js";
import { ShapePanel } from "viewer/shapepanel.js";
import { SizePanel } from "viewer/size.js";
import { StopPanel } from "viewer/stoppanel.js";
import { connectWords, explainFigures } from "viewer/words.js";

export class Panel {
  // The layers that the lists show, and their names.
  listed = null;
  names = "";

  constructor(app) {
    this.app = app;
    this.connectView();
    this.connectButtons();
    this.connectSplit();
    this.editing = new EditPanel(app);
    this.shapes = new ShapePanel(app);
    this.stops = new StopPanel(app);
    app.palettes.connect();
    this.again = new FitAgain(app);
    this.size = new SizePanel(app);
    connectWords();
    this.reopen();
  }

  /** Shows what depends on the document alone. */
  reopen() {
    const { app } = this;
    this.stopMeasuring(); // of the document before
    find("title").textContent = app.drawing.title || app.data.name;
    this.factsShown = null;
    this.showFacts();
    this.relist();
    const notes = [...app.drawing.notes].map(([text, count]) => `${count} × ${text}`);
    this.say(notes.length ? `Shown differently from the file: ${notes.join("; ")}` : "");
    this.request();
  }

  /** Shows what belongs to the file of the drawing, whenever that is another one. */
  showFacts() {
    const { app } = this;
    const { facts } = app.drawing;
    if (this.factsShown === facts) return;
    this.factsShown = facts;
    const missing = { photo: !app.meter, history: !(facts.history?.length > 1) };
    for (const element of findAll("[data-needs]")) element.hidden = missing[element.dataset.needs];
    if (!missing.history) this.showPlot("iteration");
    const rows = settingRows(app.drawing.settings);
    fillTable(find("settings"), rows);
    find("settings-box").hidden = !rows.length;
    find("width").max = Math.max(Math.round(app.drawing.box[2] / 4), 2);
  }

  /** Shows the layers of the drawing, whenever their list is another one. */
  relist() {
    const { app } = this;
    [this.listed, this.names] = [app.drawing.layers, layerNames(app.drawing)];
    this.layerTable = new LayerTable(app, find("layers").tBodies[0]);
    find("shown-count").max = this.listed.length;
    find("shown-count").disabled = this.listed.length < 2;
    const names = this.listed.map(({ name }) => name);
    fillSelect(find("filter"), ["All shown", ...names]);
    fillSelect(find("brush-layer"), names);
    fillSelect(find("to-layer"), ["Move to …", ...names]);
  }

  connectView() {
    const { app } = this;
    onPick("show", (value) => app.setShow(value));
    onPick("tool", (value) => app.setTool(value));
    onPick("axis", (value) => this.showPlot(value));
    onInput("split", (value) => app.setSplit(Number(value)));
    onInput("shown-count", (value) => app.showLayers(Number(value)));
    onInput("filter", () => this.setFilter(find("filter").selectedIndex));
    onInput("brush-layer", () => (app.brush.layer = app.drawing.layers[find("brush-layer").selectedIndex]));
    onInput("to-layer", () => {
      const target = app.drawing.layers[find("to-layer").selectedIndex - 1];
      if (target) app.editor.toLayer(target);
      find("to-layer").selectedIndex = 0;
    });
  }

  setFilter(index) {
    const { app } = this;
    app.filter = app.drawing.layers[index - 1] ?? null;
    if (app.filter) app.select([...app.selection].filter(({ layer }) => layer === app.filter));
  }

  connectButtons() {
    const { app } = this;
    connectClicks({
      undo: () => app.undo(), redo: () => app.redo(), save: () => app.save(),
      "zoom-in": () => app.stage.zoom(1.4), "zoom-out": () => app.stage.zoom(1 / 1.4), "zoom-fit": () => app.stage.fit(),
      theme: () => toggleTheme(), "help-open": () => find("help").showModal(),
    });
  }

  /** Makes the line between photo and drawing draggable; the slider is for the keyboard. */
  connectSplit() {
    const line = find("split-line");
    line.addEventListener("pointerdown", (event) => {
      line.setPointerCapture(event.pointerId);
      event.preventDefault();
    });
    line.addEventListener("pointermove", (event) => {
      if (!line.hasPointerCapture(event.pointerId)) return;
      const { box } = this.app.drawing;
      const [x] = this.app.stage.toUser(event.clientX - find("stage").getBoundingClientRect().left, 0);
      this.app.setSplit((100 * (x - box[0])) / box[2]);
    });
  }

  request() {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => this.show());
  }

  show() {
    this.pending = false;
    const { app } = this;
    if (this.listed !== app.drawing.layers || this.names !== layerNames(app.drawing)) this.relist();
    if (!app.live.isOn) this.showFacts();
    const layers = app.shownLayers;
    setText("shown-paths", countedKinds(layers.flatMap(({ items }) => items)));
    for (const label of findAll("[data-server]")) label.hidden = !window.desk?.reshape;
    setChoice("tool", app.tool);
    setChoice("show", app.show);
    find("legend").hidden = app.show !== "residual";
    setValue("split", Math.round(app.split), `${Math.round(app.split)} %`);
    setValue("shown-count", app.shownCount, `${app.shownCount} of ${app.drawing.layers.length}`);
    this.editing.show();
    this.shapes.show();
    this.stops.show();
    app.palettes.show();
    this.again.show();
    this.size.show();
    this.showFigures();
    this.layerTable.show();
    this.measureSoon(layers);
    find("undo").disabled = !app.commands.done.length && !app.gesture && !window.desk?.canUndo?.();
    find("redo").disabled = !app.commands.undone.length;
  }

  showFigures() {
    const { app } = this;
    // While a fit is running, the figures are those of its frames, beside its progress. Without a shape there are none:
    // before the first frame, the empty page would be compared with the picture.
    const figures = app.live.isOn || !app.pathCount ? {} : app.figures.all;
    // Before there is a document, the page has no size.
    const rows = !app.data.svg && !app.data.kept ? [] : [
      ["Paths", app.pathCount.toLocaleString("en")],
      ["Layers", String(app.drawing.layers.filter(({ items }) => items.length).length)],
      ["Canvas", app.drawing.box.slice(2).map((side) => formatNumber(side, 2)).join(" × ")],
      ["Size", this.size.text],
    ];
    const known = (value, format) => (value === undefined ? MEASURING : format(value));
    if ("bytes" in figures) rows.push(["File size", known(figures.bytes, formatBytes)]);
    if ("psnr" in figures) rows.push(["Closeness", known(figures.psnr, formatDb)]);
    const details = [];
    if ("gzip_bytes" in figures) details.push(["Gzipped", formatBytes(figures.gzip_bytes)]);
    if ("segments" in figures) details.push(["Segments", figures.segments.toLocaleString("en")]);
    if ("ssim" in figures) details.push(["Likeness of structure", figures.ssim.toFixed(4)]);
    fillTable(find("figures"), rows);
    fillTable(find("more-figures"), details);
    this.showNotKept(app.live.isOn ? [] : app.drawing.facts.notKept ?? []);
    for (const table of ["figures", "more-figures"]) explainFigures(find(table));
    const parts = [countedKinds(app.drawing.layers.flatMap(({ items }) => items))];
    if (app.live.isOn) parts.push("drawing …");
    if ("bytes" in figures) parts.push(known(figures.bytes, formatBytes));
    if ("psnr" in figures) parts.push(known(figures.psnr, formatDb));
    if (app.edited && !app.live.isOn) parts.push("edited");
    if (parts.slice(-3).filter((part) => part === MEASURING).length > 1) parts.splice(parts.indexOf(MEASURING), 1);
    setText("summary", parts.join(" · "));
  }

  /** Lists what the drawing could not keep of its picture. */
  showNotKept(words) {
    const list = find("not-kept");
    find("not-kept-box").hidden = !words.length;
    if (list.dataset.shown === words.join()) return;
    list.dataset.shown = words.join();
    list.replaceChildren(...words.map((text) => Object.assign(document.createElement("li"), { textContent: text })));
  }

  /** Measures the shown picture, each layer and the file after a pause, in steps between frames. */
  measureSoon(layers) {
    const { app } = this;
    this.stopMeasuring();
    const known = app.meter && app.figures.psnrOf(layers);
    setText("shown-psnr", app.live.isOn || !app.meter || !app.pathCount ? "" : known === undefined ? MEASURING : formatDb(known));
    if (!app.live.isOn) this.timer = setTimeout(() => this.measure(this.measuring(layers)), MEASURE_DELAY_MS);
  }

  *measuring(layers) {
    const { app } = this;
    yield* app.figures.measuring(layers);
    if (app.meter && app.pathCount) setText("shown-psnr", formatDb(app.figures.psnrOf(layers)));
    this.showFigures();
    this.layerTable.show();
    app.live.onChange?.();
  }

  measure(steps) {
    if (!runUntil(steps, performance.now() + MEASURE_STEP_MS)) this.timer = setTimeout(() => this.measure(steps));
  }

  stopMeasuring() {
    clearTimeout(this.timer);
  }

  showPlot(axis) {
    plotHistory(find("plot"), this.app.drawing.facts.history, axis);
  }

  /** Updates whatever depends on the view: the split line, its labels, the zoom. */
  showView() {
    const { app } = this;
    const { stage } = app;
    const [x, y, width, height] = app.drawing.box;
    const [left, top] = stage.toStage(x + (width * app.split) / 100, y);
    const shown = [left, top, stage.view.scale, stage.view.x, app.split, Boolean(app.meter), ...app.drawing.box].join(" ");
    if (this.viewShown === shown) return;
    this.viewShown = shown;
    const line = find("split-line");
    line.hidden = !app.meter;
    line.classList.toggle("parked", !app.split);
    Object.assign(line.style, { left: `${left}px`, top: `${top}px`, height: `${height * stage.view.scale}px` });
    for (const tag of ["tag-photo", "tag-drawing"]) {
      // Beside the whole picture nothing of the drawing is seen.
      find(tag).hidden = !app.split || (tag === "tag-drawing" && app.split >= 100);
      Object.assign(find(tag).style, { left: `${left}px`, top: `${top + 8}px` });
    }
    setText("zoom", `${Math.round(stage.view.scale * 100)} %`);
    find("surface").dataset.view = [stage.view.scale, stage.view.x, stage.view.y].join(" ");
  }

  say(text) {
    find("message").textContent = text;
  }
}

// A pause in which nothing changes, after which the picture is measured, and the time of a step of it.
const MEASURE_DELAY_MS = 150;
const MEASURE_STEP_MS = 6;

function layerNames({ layers }) {
  return layers.map(({ name }) => name).join("\n");
}

function toggleTheme() {
  const root = document.documentElement;
  const isDarkBySystem = !root.style.colorScheme && matchMedia("(prefers-color-scheme: dark)").matches;
  const dark = getComputedStyle(find("theme")).colorScheme === "dark" || isDarkBySystem;
  root.style.colorScheme = dark ? "light" : "dark";
}
