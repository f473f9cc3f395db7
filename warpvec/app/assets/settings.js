/* The controls of a fit, and the settings that they stand for. */

const DEFAULT_SETTINGS = { mode: "auto", detail: 20, size: 0, colors: 0, blends: 0, opaque: false, cutout: false };

// Each step of the detail is a quarter of a doubling: 16 to 4,096 shapes, or 3.2 to 0.0125 pixels.
const FEWEST_CURVES = 16;
const DEFAULT_DETAIL_PX = 0.1;
const STEPS_PER_DOUBLING = 4;

const SIZES_KB = [0, 2, 3, 5, 7, 10, 15, 20, 30, 40, 50, 60, 80, 100, 120, 150, 200, 300, 400, 500, 700, 1000];
const COLOR_COUNTS = [0, 2, 3, 4, 5, 6, 8, 10, 12, 16, 24, 32, 48, 64];

const SLIDERS = ["detail", "size", "colors", "blends"];
const CHECKS = ["opaque", "cutout"];

function curvesOf(detail) {
  return Math.round(FEWEST_CURVES * 2 ** (detail / STEPS_PER_DOUBLING));
}

function pixelsOf(detail) {
  return DEFAULT_DETAIL_PX * 2 ** ((DEFAULT_SETTINGS.detail - detail) / STEPS_PER_DOUBLING);
}

/** Returns the settings as the server takes them; see warpvec/app/settings.py. */
function settingsForServer({ mode, detail, size, colors, blends, opaque, cutout }) {
  const max_bytes = SIZES_KB[size] ? 1000 * SIZES_KB[size] : null;
  return {
    mode, max_bytes, opaque, cutout, curves: curvesOf(detail), detail: pixelsOf(detail), colors: COLOR_COUNTS[colors],
    gradients: blends / 100,
  };
}

/** The controls in the panel; `onChange(settings, name)` is called when one has been moved. */
class SettingsPanel {
  constructor(onChange) {
    this.settings = { ...DEFAULT_SETTINGS };
    this.kind = null;
    byId("size").max = SIZES_KB.length - 1;
    byId("colors").max = COLOR_COUNTS.length - 1;
    const changed = (name, value) => {
      this.settings = { ...this.settings, [name]: value };
      this.showTexts();
      onChange(this.settings, name);
    };
    for (const name of SLIDERS) byId(name).addEventListener("input", () => changed(name, byId(name).valueAsNumber));
    for (const name of CHECKS) byId(name).addEventListener("change", () => changed(name, byId(name).checked));
    for (const input of document.getElementsByName("mode")) input.addEventListener("change", () => changed("mode", input.value));
    this.showTexts();
  }

  /** Shows the settings of a picture, whose kind is "photo", "flat", "mono" or not known yet, null. */
  show(settings, kind, reason) {
    this.settings = { ...settings };
    this.kind = kind;
    for (const name of SLIDERS) byId(name).value = settings[name];
    for (const name of CHECKS) byId(name).checked = settings[name];
    for (const input of document.getElementsByName("mode")) input.checked = input.value === settings.mode;
    byId("found").textContent = settings.mode === "auto" && kind ? `found: ${kind}` : "";
    byId("found").title = reason ?? "";
    this.showTexts();
  }

  showTexts() {
    const { detail, size, colors, blends, mode } = this.settings;
    const kind = mode === "auto" ? this.kind : mode;
    const shapes = `${curvesOf(detail).toLocaleString("en")} shapes`;
    const pixels = `${pixelsOf(detail).toFixed(2)} px`;
    this.showText("detail", SIZES_KB[size] ? "by size" : kind === "flat" || kind === "mono" ? pixels : shapes);
    this.showText("size", SIZES_KB[size] ? `${SIZES_KB[size]} KB` : "any");
    this.showText("colors", COLOR_COUNTS[colors] ? String(COLOR_COUNTS[colors]) : "any");
    this.showText("blends", `${blends} %`);
    byId("detail").disabled = SIZES_KB[size] > 0;
    byId("colors").disabled = kind === "mono";
    byId("blends").disabled = kind === "flat" || kind === "mono";
    byId("cutout").disabled = kind === "photo" || kind === "mono";
  }

  showText(name, text) {
    byId(`${name}-text`).textContent = text;
    byId(name).setAttribute("aria-valuetext", text);
  }
}
