/* Blurs of soft items: read from filters that only blur, drawn, and written as filters. The softness of an item is the
 * standard deviation of its blur in user units; without one the item is sharp. */

import { formatNumber } from "viewer/paths.js";
import { reachOf } from "viewer/raster.js";

/** Returns the standard deviation of each filter of a document that is one Gaussian blur, by id. */
export function readBlurs(parsed) {
  const blurs = new Map();
  for (const filter of parsed.querySelectorAll("filter")) {
    const [step, ...more] = filter.children;
    const sigma = parseFloat(step?.getAttribute("stdDeviation") ?? "");
    const isBlur = step?.localName === "feGaussianBlur" && (step.getAttribute("in") ?? "SourceGraphic") === "SourceGraphic";
    if (isBlur && !more.length && sigma > 0 && sigma < Infinity) blurs.set(filter.id, sigma);
  }
  return blurs;
}

/** Returns the id of the filter of each soft item, and the lines that define the filters; `taken` are other ids. */
export function nameBlurs(items, taken) {
  const used = new Set(taken);
  const byText = new Map();
  const names = new Map();
  for (const item of items) {
    if (!item.softness) continue;
    const text = writeFilter(item);
    if (!byText.has(text)) {
      let number = byText.size + 1;
      while (used.has(`blur-${number}`)) number++;
      byText.set(text, `blur-${number}`);
      used.add(`blur-${number}`);
    }
    names.set(item, byText.get(text));
  }
  return { names, lines: [...byText].map(([text, name]) => text.replace(" ", ` id="${name}" `)) };
}

function writeFilter(item) {
  const [left, top, right, bottom] = reachOf(item);
  const [x, y] = [Math.floor(left), Math.floor(top)];
  const sides = `x="${x}" y="${y}" width="${Math.ceil(right) - x}" height="${Math.ceil(bottom) - y}"`;
  const blur = `<feGaussianBlur stdDeviation="${formatNumber(item.softness, 2)}"/>`;
  return `<filter filterUnits="userSpaceOnUse" ${sides} color-interpolation-filters="sRGB">${blur}</filter>`;
}
