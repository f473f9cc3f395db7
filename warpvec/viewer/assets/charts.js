/* Draws the convergence plot and the tables of figures. */

const SVG = "http://www.w3.org/2000/svg";
const PLOT = { width: 268, height: 150, left: 34, right: 12, top: 8, bottom: 30 };

/** Fills `figure` with a plot of PSNR over `axis`, "iteration" or "seconds". */
export function plotHistory(figure, history, axis) {
  const points = history.filter((record) => Number.isFinite(record[axis]) && Number.isFinite(record.psnr));
  const xs = niceTicks(0, Math.max(...points.map((record) => record[axis])));
  const ys = niceTicks(Math.min(...points.map(({ psnr }) => psnr)), Math.max(...points.map(({ psnr }) => psnr)));
  const { width, height, left, right, top, bottom } = PLOT;
  const x = (value) => left + ((value - xs[0]) / (xs.at(-1) - xs[0])) * (width - left - right);
  const y = (value) => height - bottom - ((value - ys[0]) / (ys.at(-1) - ys[0])) * (height - top - bottom);
  const svg = svgElement("svg", { viewBox: `0 0 ${width} ${height}`, role: "img" });
  const last = points.at(-1);
  svg.setAttribute("aria-label", `Closeness rises from ${points[0].psnr.toFixed(2)} to ${last.psnr.toFixed(2)} dB`);
  for (const tick of ys) {
    svg.append(svgElement("path", { class: "grid", d: `M${left} ${y(tick)}H${width - right}` }));
    svg.append(svgText(left - 5, y(tick) + 3.5, formatTick(tick), "end"));
  }
  for (const tick of xs) svg.append(svgText(x(tick), height - bottom + 14, formatTick(tick), "middle"));
  svg.append(svgText((left + width - right) / 2, height - 3, axis === "seconds" ? "seconds" : "steps", "middle"));
  const line = points.map((record) => `${x(record[axis]).toFixed(1)} ${y(record.psnr).toFixed(1)}`).join("L");
  svg.append(svgElement("path", { class: "line", d: `M${line}` }));
  svg.append(svgElement("circle", { class: "dot", cx: x(last[axis]), cy: y(last.psnr), r: 3 }));
  figure.replaceChildren(svg);
}

function svgElement(name, attributes) {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  return element;
}

function svgText(x, y, text, anchor) {
  const element = svgElement("text", { x, y, "text-anchor": anchor });
  element.textContent = text;
  return element;
}

/** Returns three to six round numbers, the first at most `low` and the last at least `high`. */
function niceTicks(low, high) {
  const span = Math.max(high - low, 1e-3);
  const power = 10 ** Math.floor(Math.log10(span / 3));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((size) => span / size <= 4);
  const [first, last] = [Math.floor(low / step + 1e-9), Math.ceil(high / step - 1e-9)];
  return Array.from({ length: Math.max(last - first, 1) + 1 }, (_, i) => (first + i) * step);
}

function formatTick(value) {
  return String(Number(value.toPrecision(4)));
}

export const MEASURING = "measuring …";

export function formatDb(value) {
  if (value === undefined || value === null || Number.isNaN(value)) return "–";
  return Number.isFinite(value) ? `${value.toFixed(2)} dB` : "∞ dB";
}

/** Returns "1 path" or "2 paths": a noun with its number. */
export function counted(count, noun) {
  return `${count.toLocaleString("en")} ${noun}${count === 1 ? "" : "s"}`;
}

export function formatBytes(count) {
  return `${count.toLocaleString("en")} bytes`;
}

/** Settings of the fit as rows: words for names, "yes" and "no" for switches. */
export function settingRows(settings) {
  const word = (value) => ({ true: "yes", false: "no", null: "none" })[String(value)] ?? String(value);
  return Object.entries(settings ?? {}).map(([name, value]) => [name.replaceAll("_", " "), word(value)]);
}
