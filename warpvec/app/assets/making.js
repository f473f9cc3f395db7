/* "Make": settings and files for machines. A machine sets the controls; then the page saves its file, and says what may
 * go wrong. */

import { find, findAll, setText } from "viewer/dom.js";

/** @type {Record<string, {settings: Record<string, any>, format: string, words: string}>} */
const MACHINES = {
  vinyl: {
    settings: { mode: "flat", cutout: true }, format: "zip",
    words: "A sheet for each colour, with marks to lay them on each other and a border to peel along.",
  },
  laser: {
    settings: { mode: "flat", cutout: true }, format: "cut.dxf",
    words: "The lines between the parts, in millimetres; one that two parts share is cut once. DXF below has closed parts.",
  },
  pen: {
    settings: { mode: "lines", cutout: false }, format: "svg",
    words: "One stroke along each line, in an order that moves the pen little.",
  },
  stencil: {
    settings: { mode: "mono", cutout: false }, format: "dxf",
    words: "One shape. It has no bridges: what lies inside of a hole falls out.",
  },
};

/** Formats -> what the button says that it saves, if it is not the format. @type {Record<string, string>} */
const SAVED = { zip: "sheets", "cut.dxf": "lines as DXF" };

export class MakePanel {
  constructor(desk) {
    this.desk = desk;
    this.chosen = null; // the last machine that was chosen
    this.checked = null; // the drawing whose warnings are shown
    for (const button of findAll("[data-machine]")) button.addEventListener("click", () => this.choose(button.dataset.machine));
    find("make-check").addEventListener("click", () => this.check());
    find("make-save").addEventListener("click", () => desk.save(desk.view.drawingText(), MACHINES[this.machine].format));
  }

  /** Shows the panel if the server can write what machines need. */
  setUp({ formats }) {
    find("make").hidden = !formats.includes("zip");
  }

  /** The machine for which the controls are set: the last one that was chosen, as long as they stand as it needs them. */
  get machine() {
    return this.chosen && this.desk.panel.isAt(MACHINES[this.chosen].settings) ? this.chosen : null;
  }

  /** Sets the controls for a machine; the picture is drawn with them. */
  choose(machine) {
    this.chosen = machine;
    this.clear();
    const changed = this.desk.panel.put(MACHINES[machine].settings);
    if (changed.length) this.desk.changeSettings(this.desk.panel.positions, changed.includes("mode") ? "mode" : changed[0]);
    this.show();
    find("make").scrollIntoView(); // what the machine gets may be below the end of the panel
  }

  /** Takes back what was said of a drawing that has changed. */
  forget() {
    if (this.checked && this.checked !== this.desk.view.drawingText()) this.clear();
  }

  clear() {
    this.checked = null;
    find("make-warnings").replaceChildren();
  }

  async check() {
    const { desk, machine } = this;
    await desk.attempt(async () => {
      const text = desk.view.drawingText();
      const { size, warnings } = await desk.server.cutFacts(text, machine);
      if (this.machine !== machine || desk.view.drawingText() !== text) return; // the answer is of what is not shown any more
      this.checked = text;
      const lines = [`The drawing is ${size}.`, ...(warnings.length ? warnings : ["Nothing that would go wrong was found."])];
      find("make-warnings").replaceChildren(...lines.map((textContent) => Object.assign(document.createElement("li"), { textContent })));
    });
  }

  show() {
    const { machine } = this;
    for (const button of findAll("[data-machine]")) button.ariaPressed = String(button.dataset.machine === machine);
    find("make-box").hidden = !machine;
    if (!machine) return;
    setText("make-text", MACHINES[machine].words);
    setText("make-save", `Save ${SAVED[MACHINES[machine].format] ?? MACHINES[machine].format.toUpperCase()}`);
    const { current, panel, server, view } = this.desk;
    const isDrawn = Boolean(current?.newest) && !current.isBusy && panel.isAt(MACHINES[machine].settings, view.facts.positions);
    const isReady = isDrawn && server.isOnline;
    for (const id of ["make-check", "make-save"]) find(id).disabled = !isReady;
  }
}
