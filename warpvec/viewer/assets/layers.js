/* Table of layers: visibility, lock, number of paths, and PSNR of the picture up to each layer. */

import { formatDb } from "viewer/charts.js";
import { mainColor } from "viewer/colornames.js";
import { countedKinds } from "viewer/kinds.js";

// Colours from the first generation to the last: viridis, whose lightness rises evenly.
export const LAYER_COLORS = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];

export class LayerTable {
  constructor(app, body) {
    this.app = app;
    this.layers = app.drawing.layers;
    body.replaceChildren();
    this.rows = this.layers.map((layer) => this.addRow(body, layer));
  }

  addRow(body, layer) {
    const row = body.insertRow();
    const box = document.createElement("input");
    Object.assign(box, { type: "checkbox", checked: true });
    box.setAttribute("aria-label", `Show ${layer.name}`);
    box.addEventListener("change", () => {
      layer.visible = box.checked;
      this.app.refresh();
    });
    const lock = document.createElement("input");
    Object.assign(lock, { type: "checkbox", checked: Boolean(layer.isLocked) });
    lock.setAttribute("aria-label", `Lock ${layer.name}`);
    lock.addEventListener("change", () => {
      layer.isLocked = lock.checked;
      this.app.refresh();
    });
    row.insertCell().append(box);
    row.insertCell().append(lock);
    const swatch = document.createElement("i");
    row.insertCell().append(swatch, layer.name);
    const cells = { swatch, lock, count: row.insertCell(), psnr: row.insertCell() };
    cells.psnr.hidden = !this.app.meter;
    return { row, box, ...cells };
  }

  show() {
    const { app, layers } = this;
    // The drawing has other layers by now: the next frame makes a table of those.
    if (layers !== app.drawing.layers) return;
    for (const [i, layer] of layers.entries()) {
      const { row, box, lock, count, psnr, swatch } = this.rows[i];
      const color = app.show === "layers" ? app.layerColor(layer) : mainColor(layer) ?? "transparent";
      if (swatch.dataset.color !== color) [swatch.dataset.color, swatch.style.background] = [color, color];
      box.checked = layer.visible;
      lock.checked = Boolean(layer.isLocked);
      row.classList.toggle("off", i >= app.shownCount || !layer.visible);
      const texts = [layer.items.length.toLocaleString("en"), formatDb(app.figures.psnrOf(layers.slice(0, i + 1)))];
      if (count.textContent !== texts[0]) count.textContent = texts[0];
      const kinds = countedKinds(layer.items);
      if (count.title !== kinds) count.title = kinds;
      psnr.textContent = texts[1].replace(" dB", "");
    }
  }
}
