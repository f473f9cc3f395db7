/* Writes a drawing as SVG text in the structure of warpvec: background, a group for each layer, a path or form per line. */

import { nameBlurs } from "viewer/blurs.js";
import { coloredApart } from "viewer/colornames.js";
import { shortColor, writeOpacity } from "viewer/colors.js";
import { writeForm } from "viewer/forms.js";
import { isGradient, nameGradients, withOpacityInStops } from "viewer/gradients.js";
import { formatNumber, writeShape } from "viewer/paths.js";
import { LAYER_ID, PLAIN_STROKE } from "viewer/read.js";

// The longer side has at least so many steps, and numbers at least two decimals, as in warpvec's own files.
const STEPS_PER_SIDE = 2e4;
const INKSCAPE = "http://www.inkscape.org/namespaces/inkscape";

export function writeDrawing(drawing) {
  const decimals = decimalsFor(drawing.box);
  const [x, y, width, height] = drawing.box.map((value) => formatNumber(value));
  const taken = new Set(drawing.layers.map(({ id }) => id));
  const layers = drawing.layers
    .filter((layer) => layer.items.length)
    .flatMap((layer) => coloredApart(layer, drawing.base, taken))
    .map((layer) => ({ ...layer, items: layer.items.map(withOpacityInStops) }));
  const items = layers.flatMap((layer) => layer.items);
  const ids = layers.map(({ id }) => id);
  const gradients = nameGradients(items, ids, decimals);
  const blurs = nameBlurs(items, [...ids, ...gradients.names.values()]);
  const definitions = [...gradients.lines, ...blurs.lines];
  const size = ["width", "height"].map((name) => drawing[name] && ` ${name}="${escapeXml(drawing[name])}"`);
  const lines = [
    '<?xml version="1.0" encoding="UTF-8"?>',
    `<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="${INKSCAPE}"` +
      `${size.filter(Boolean).join("")} viewBox="${x} ${y} ${width} ${height}">`,
    ...writeDescription(drawing),
    ...(definitions.length ? ["<defs>", ...definitions, "</defs>"] : []),
    ...writeBackground(drawing, [x, y, width, height]),
    ...layers.flatMap((layer, i) => writeLayer(layer, i + 1, decimals, gradients.names, blurs.names)),
    "</svg>",
  ];
  return `${lines.join("\n")}\n`;
}

export function decimalsFor(box) {
  return Math.min(Math.max(Math.ceil(Math.log10(STEPS_PER_SIDE / Math.max(box[2], box[3]))), 2), 6);
}

function writeDescription({ title, metadata, settings }) {
  const lines = title ? [`<title>${escapeXml(title)}</title>`] : [];
  const text = settings ? JSON.stringify({ ...settings, edited: true }) : metadata;
  return text ? [...lines, `<metadata>${escapeXml(text)}</metadata>`] : lines;
}

function writeBackground({ background }, [x, y, width, height]) {
  if (!background) return [];
  const corner = (x === "0" ? "" : ` x="${x}"`) + (y === "0" ? "" : ` y="${y}"`);
  const paint = `fill="${shortColor(background.fill)}"${writeOpacity("fill-opacity", background.opacity)}`;
  return [`<rect id="background"${corner} width="${width}" height="${height}" ${paint}/>`];
}

function writeLayer(layer, number, decimals, names, blurs) {
  const count = `${layer.items.length} ${layer.items.length === 1 ? "path" : "paths"}`;
  const id = layer.id || `layer-${layer.key + 1}`;
  // Programs of plotters choose a pen by the first number of a label.
  const label = LAYER_ID.test(id) ? `Layer ${number}: generation ${layer.generation}, ${count}` : `${number} ${layer.name}`;
  return [
    `<g id="${escapeXml(id)}" inkscape:groupmode="layer" inkscape:label="${escapeXml(label)}">`,
    ...layer.items.map((item) => writeItem(item, decimals, names, blurs)),
    "</g>",
  ];
}

function writeItem(item, decimals, names, blurs) {
  const { shape, fill, opacity, rule, stroke } = item;
  const paint = fill ? `fill="${writePaint(fill, names)}"${writeOpacity("fill-opacity", opacity)}` : 'fill="none"';
  const evenOdd = rule === "evenodd" ? ' fill-rule="evenodd"' : "";
  const look = `${paint}${evenOdd}${writeStroke(stroke, opacity, names)}${blurs.has(item) ? ` filter="url(#${blurs.get(item)})"` : ""}`;
  if (shape.form) return `<${shape.form.element} ${look}${writeForm(shape.form, decimals)}/>`;
  return `<path ${look} d="${escapeXml(writeShape(shape, decimals))}"/>`;
}

function writePaint(paint, names) {
  return isGradient(paint) ? `url(#${names.get(paint)})` : shortColor(paint);
}

function writeStroke(stroke, opacity, names) {
  if (!stroke) return "";
  const width = formatNumber(stroke.width, 3);
  const words = { cap: "stroke-linecap", join: "stroke-linejoin", limit: "stroke-miterlimit" };
  const special = Object.keys(words).filter((name) => stroke[name] !== PLAIN_STROKE[name]);
  const shape = special.map((name) => ` ${words[name]}="${stroke[name]}"`).join("");
  return ` stroke="${writePaint(stroke.color, names)}" stroke-width="${width}"${shape}${writeOpacity("stroke-opacity", opacity)}`;
}

function escapeXml(text) {
  const entities = { "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" };
  return text.replace(/[^\t\n\r\x20-\ud7ff\ue000-\ufffd\u{10000}-\u{10ffff}]/gu, "\ufffd").replace(/[&<>"]/g, (c) => entities[c]);
}
