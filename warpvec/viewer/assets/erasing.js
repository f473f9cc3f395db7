/* Erases from a new drawing what was erased from the one before, so that the edit can be applied again. */

import { cut } from "viewer/eraser.js";
import { editsOf, isOfPhoto } from "viewer/edits.js";
import { transformed } from "viewer/edit.js";
import { counterparts } from "viewer/likeness.js";
import { transformShape } from "viewer/paths.js";

/** Tells whether parts of shapes were erased from a drawing, and are to be erased from the `next` one too. */
export function mustErase(drawing, next) {
  return !isOfPhoto(next) && editsOf(drawing).some(({ erased }) => erased);
}

/** Returns what is left of the items of `next`, by their place, without what was erased from their counterparts in the
 * drawing before.
 *
 * @param {any} drawing
 * @param {any} next
 * @param {number[]} matrix from the user units of the one to those of the other */
export async function eraseAgain(drawing, next, matrix) {
  const left = new Map();
  for (const { before, erased, isWhole } of editsOf(drawing).filter((edit) => edit.erased)) {
    const placed = { ...before, ...transformed(before, matrix) };
    const origins = counterparts(placed, next.base.items, { withPieces: isWhole });
    for (const area of erased) await eraseArea(transformShape(area, matrix), origins, next, left);
  }
  return left;
}

async function eraseArea(area, origins, next, left) {
  const places = origins.map((origin) => next.base.items.indexOf(origin));
  const open = places.filter((place) => left.get(place)?.length !== 0);
  const items = open.map((place) => left.get(place)?.[0] ?? next.base.items[place]);
  const answers = await cut(items, area, next.box);
  answers.forEach((each, i) => each.left && left.set(open[i], each.left));
}
