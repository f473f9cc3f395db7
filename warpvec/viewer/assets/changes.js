/* Finds the part of a picture that a change of the drawing touches.
 *
 * A snapshot is what a picture shows: {items, states}, the states as in commands.js. */

import { unionOfBoxes } from "viewer/paths.js";
import { reachOf } from "viewer/raster.js";

export function snapshotOf(items) {
  return { items, states: items.map(({ shape, fill, opacity, stroke, softness }) => ({ shape, fill, opacity, stroke, softness })) };
}

export function sameState(a, b) {
  return a.shape === b.shape && a.fill === b.fill && a.opacity === b.opacity && a.stroke === b.stroke && a.softness === b.softness;
}

/** Returns the box around everything that differs between two snapshots; without a difference, null. */
export function differenceOf(before, after) {
  const [low, highBefore, highAfter] = differingRange(before, after);
  if (low === highBefore && low === highAfter) return null;
  const places = new Map();
  for (let i = low; i < highBefore; i++) places.set(before.items[i], i);
  const kept = [];
  const boxes = [];
  for (let j = low; j < highAfter; j++) {
    const i = places.get(after.items[j]);
    if (i === undefined) boxes.push(reachOf(after.states[j]));
    else kept.push([i, j]);
  }
  const inOrder = longestRise(kept.map(([i]) => i));
  kept.forEach(([i, j], index) => {
    places.delete(after.items[j]);
    if (inOrder.has(index) && sameState(before.states[i], after.states[j])) return;
    boxes.push(reachOf(before.states[i]), reachOf(after.states[j]));
  });
  for (const i of places.values()) boxes.push(reachOf(before.states[i]));
  return unionOfBoxes(boxes);
}

/** Returns the first place that differs, and the ends of the differing parts of both. */
function differingRange(before, after) {
  const same = (i, j) => before.items[i] === after.items[j] && sameState(before.states[i], after.states[j]);
  let [i, j] = [before.items.length, after.items.length];
  let low = 0;
  while (low < i && low < j && same(low, low)) low++;
  while (i > low && j > low && same(i - 1, j - 1)) [i, j] = [i - 1, j - 1];
  return [low, i, j];
}

/** Returns the indices of a longest rising part of `numbers`: the items that need not be moved to sort them. */
export function longestRise(numbers) {
  // The index of the smallest number that ends a rise of each length, and the index before each one.
  const ends = [];
  const previous = numbers.map((number, index) => {
    let [low, high] = [0, ends.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (numbers[ends[middle]] < number) low = middle + 1;
      else high = middle;
    }
    ends[low] = index;
    return low ? ends[low - 1] : -1;
  });
  const rise = new Set();
  for (let index = ends.at(-1) ?? -1; index >= 0; index = previous[index]) rise.add(index);
  return rise;
}
