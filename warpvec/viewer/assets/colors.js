/* Colours as "#rrggbb", as levels of red, green and blue, and as hue, saturation and lightness. */

import { formatNumber } from "viewer/paths.js";

export function hexColor(channels) {
  return `#${channels.map((level) => Math.round(level).toString(16).padStart(2, "0")).join("")}`;
}

export function clamp01(value) {
  return Math.min(Math.max(value, 0), 1);
}

/** Returns "#rgb" if it is the same colour as "#rrggbb". */
export function shortColor(color) {
  return color.replace(/^#(.)\1(.)\2(.)\3$/, "#$1$2$3");
}

export function writeOpacity(name, opacity) {
  const text = formatNumber(opacity, 4);
  return text === "1" ? "" : ` ${name}="${text}"`;
}

export function channelsOf(color) {
  return [1, 3, 5].map((at) => parseInt(color.slice(at, at + 2), 16));
}

/** Returns the largest difference of a channel, from 0 to 255. */
export function gapBetween(a, b) {
  const [from, to] = [a, b].map(channelsOf);
  return Math.max(...from.map((level, i) => Math.abs(level - to[i])));
}

/** Returns `color` changed as much as `from` is changed by becoming `to`. */
export function shiftedColor(color, from, to) {
  const [level, start, end] = [color, from, to].map(channelsOf);
  return hexColor(level.map((value, i) => Math.min(Math.max(value + end[i] - start[i], 0), 255)));
}

/** Returns hue in degrees, saturation and lightness from 0 to 1 of "#rrggbb". */
export function hslOf(color) {
  const [r, g, b] = channelsOf(color).map((level) => level / 255);
  const [high, low] = [Math.max(r, g, b), Math.min(r, g, b)];
  const [range, lightness] = [high - low, (high + low) / 2];
  if (!range) return [0, 0, lightness];
  const sixth = high === r ? (g - b) / range : high === g ? (b - r) / range + 2 : (r - g) / range + 4;
  return [(60 * sixth + 360) % 360, range / (1 - Math.abs(2 * lightness - 1)), lightness];
}

export function colorOfHsl(hue, saturation, lightness) {
  const reach = saturation * Math.min(lightness, 1 - lightness);
  const channel = (n) => {
    const k = (n + hue / 30) % 12;
    return 255 * (lightness - reach * Math.max(-1, Math.min(k - 3, 9 - k, 1)));
  };
  return hexColor([channel(0), channel(8), channel(4)]);
}
