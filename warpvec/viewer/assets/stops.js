/* Changes of the stops of a gradient. Each returns a new fill; offsets keep rising from 0 to 1. */

import { channelsOf, clamp01, hexColor } from "viewer/colors.js";

// What warpvec reads as one gradient, warpvec/geometry/stops.py.
export const STOPS_MAX = 8;
const STOPS_MIN = 2;

/** Returns the fill with a changed stop, and the very same one if nothing changes; its place stays between those of its neighbours.
 *
 * @param {any} fill
 * @param {number} index
 * @param {{offset?: number, color?: string, opacity?: number}} change */
export function withStop(fill, index, change) {
  const stop = { ...fill.stops[index], ...change };
  const low = fill.stops[index - 1]?.offset ?? 0;
  const high = fill.stops[index + 1]?.offset ?? 1;
  stop.offset = Math.min(Math.max(stop.offset, low), high);
  stop.opacity = clamp01(stop.opacity);
  const old = fill.stops[index];
  if (Object.keys(stop).every((name) => stop[name] === old[name])) return fill;
  return { ...fill, stops: fill.stops.with(index, stop), onCanvas: null };
}

export function withoutStop(fill, index) {
  if (fill.stops.length <= STOPS_MIN) return fill;
  return { ...fill, stops: fill.stops.toSpliced(index, 1), onCanvas: null };
}

/** Adds a stop in the middle of the widest gap, in the colour that is there: nothing looks different yet. */
export function withNewStop(fill) {
  const { stops } = fill;
  if (stops.length >= STOPS_MAX) return fill;
  const gaps = stops.slice(1).map(({ offset }, i) => offset - stops[i].offset);
  const before = gaps.indexOf(Math.max(...gaps));
  return { ...fill, stops: stops.toSpliced(before + 1, 0, between(stops[before], stops[before + 1])), onCanvas: null };
}

function between(a, b) {
  const [from, to] = [a, b].map(({ color }) => channelsOf(color));
  const color = hexColor(from.map((level, i) => (level + to[i]) / 2));
  return { offset: (a.offset + b.offset) / 2, color, opacity: (a.opacity + b.opacity) / 2 };
}
