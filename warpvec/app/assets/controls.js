/* The controls of a fit. `warpvec/app/controls.py` writes their elements into the page, and says what they send.
 *
 * The settings of a picture are positions: by the name of each control, the number of the step at which it stands. */

import { find, findAll } from "viewer/dom.js";

/** @type {{name: string, form: string, start: number, overrides: string | null, settings: Setting[]}[]}
 * @typedef {{name: string, modes: string[], values: any[], texts: string[]}} Setting */
const CONTROLS = JSON.parse(find("controls").textContent);

export const DEFAULT_POSITIONS = Object.fromEntries(CONTROLS.map(({ name, start }) => [name, start]));

/** Returns the settings as the server takes them, at `positions`. */
export function settingsForServer(positions) {
  const valuesOf = ({ name, settings }) => settings.map((setting) => [setting.name, setting.values[positions[name]]]);
  return Object.fromEntries(CONTROLS.flatMap(valuesOf));
}

/** Returns the positions of the settings that a file of warpvec states. The mode stays open if the picture decides it. */
export function positionsOf(stated) {
  const isOpen = ({ name }) => name === "mode" && ["photo", "flat"].includes(stated.mode);
  const placeOf = ({ name, values }) => (name in stated ? values.indexOf(stated[name]) : -1);
  const found = CONTROLS.filter((control) => !isOpen(control)).map(({ name, settings }) => {
    const places = settings.filter(({ modes }) => modes.includes(stated.mode)).map(placeOf);
    return /** @type {[string, number]} */ ([name, Math.max(-1, ...places)]);
  });
  return { ...DEFAULT_POSITIONS, ...Object.fromEntries(found.filter(([, place]) => place >= 0)) };
}

/** The controls in the panel; `onChange(positions, name)` is called when one has been moved. */
export class ControlPanel {
  // The kind of picture that was found, "photo", "flat" or "mono"; null if it is not known yet.
  kind = null;
  positions = { ...DEFAULT_POSITIONS };

  constructor(onChange) {
    for (const { name, form } of CONTROLS) {
      const changed = (position) => {
        this.positions = { ...this.positions, [name]: position };
        this.showEffects();
        onChange(this.positions, name);
      };
      const element = elementOf(name);
      if (form === "slider") element.addEventListener("input", () => changed(element.valueAsNumber));
      if (form === "tick") element.addEventListener("change", () => changed(Number(element.checked)));
      if (form === "choice") buttonsOf(name).forEach((button, position) => button.addEventListener("change", () => changed(position)));
    }
    this.showEffects();
  }

  /** Shows the settings of a picture; `reason` says why it is of its kind. */
  show(positions, kind, reason) {
    this.positions = { ...positions };
    this.kind = kind;
    for (const { name, form } of CONTROLS) {
      if (form === "slider") elementOf(name).value = positions[name];
      if (form === "tick") elementOf(name).checked = positions[name] === 1;
      if (form === "choice") buttonsOf(name).forEach((button, position) => (button.checked = position === positions[name]));
    }
    find("found").textContent = this.mode === "auto" && kind ? `found: ${kind}` : "";
    find("found").title = reason ?? "";
    this.showEffects();
  }

  /** Puts controls at values of their settings, by their names. Returns the names of those that stood elsewhere. */
  put(values) {
    const changed = placesOf(values).filter(({ name, place }) => place >= 0 && place !== this.positions[name]);
    const moved = Object.fromEntries(changed.map(({ name, place }) => [name, place]));
    this.show({ ...this.positions, ...moved }, this.kind, find("found").title);
    return changed.map(({ name }) => name);
  }

  /** Tells whether controls at `positions` have the values of settings, by their names. */
  isAt(values, positions = this.positions) {
    return placesOf(values).every(({ name, place }) => positions?.[name] === place);
  }

  /** The mode that is chosen: "auto", "photo", "flat" or "mono". */
  get mode() {
    return settingsForServer(this.positions).mode;
  }

  /** Shows the values of the sliders, and which controls have no effect. */
  showEffects() {
    const kind = this.mode === "auto" ? this.kind : this.mode;
    const overriders = CONTROLS.filter(({ name, overrides }) => overrides && this.positions[name] > 0);
    const overridden = new Set(overriders.map(({ overrides }) => overrides));
    for (const { name, form, settings } of CONTROLS.filter((control) => control.form !== "choice")) {
      const isUsed = !kind || settings.some(({ modes }) => modes.includes(kind));
      elementOf(name).disabled = !isUsed || overridden.has(name);
      if (form !== "slider") continue;
      const shown = settings.find(({ modes }) => modes.includes(kind ?? "photo")) ?? settings[0];
      this.showText(name, overridden.has(name) ? "by size" : shown.texts[this.positions[name]]);
    }
  }

  showText(name, text) {
    find(`set-${name}-text`).textContent = text;
    elementOf(name).setAttribute("aria-valuetext", text);
  }
}

/** Returns the controls of settings, by their names, and the places of these values; -1 for one that is not offered. */
function placesOf(values) {
  const given = CONTROLS.filter(({ name }) => name in values);
  return given.map(({ name, settings }) => ({ name, place: settings[0].values.indexOf(values[name]) }));
}

function elementOf(control) {
  return find(`set-${control}`);
}

function buttonsOf(control) {
  return findAll(`[name="set-${control}"]`);
}
