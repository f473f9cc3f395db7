/* Drawings that were saved are opened again: alone, or with the picture that they are of. */

import { readDrawing } from "viewer/read.js";
import { positionsOf } from "app/controls.js";

// Pixels of the longer side, at least, of the picture that a drawing without one is compared with: its own.
const OWN_SIDE_MIN = 512;

export function isDrawing({ type, name }) {
  return type === "image/svg+xml" || /\.svgz?$/i.test(name);
}

/** Returns {name, file, drawing} of each picture of `files`: a drawing belongs to the picture of the same name, or to the
 * only one beside it. */
export function pairs(files) {
  const made = files.map((file) => ({ name: file.name.replace(/\.[^.]+$/, "") || "picture", file }));
  const [drawings, pictures] = [made.filter(({ file }) => isDrawing(file)), made.filter(({ file }) => !isDrawing(file))];
  const isOnePair = drawings.length === 1 && pictures.length === 1;
  const found = drawings.map(({ name, file: drawing }) => {
    const own = isOnePair ? pictures[0] : pictures.find((picture) => picture.name === name);
    return { name, file: own?.file ?? null, drawing };
  });
  const taken = new Set(found.map(({ file }) => file));
  return [...found, ...pictures.filter(({ file }) => !taken.has(file)).map((each) => ({ ...each, drawing: null }))];
}

/** Returns the drawing of a picture from its file; one without a picture is drawn as its own. */
export async function read(picture, server) {
  const opened = await server.open(picture.drawing);
  picture.blob ??= await drawn(server, opened.text, opened.width, opened.height);
  return opened;
}

/** Gives a picture that the server has the drawing of its file: it is saved already, and has no undo steps. */
export async function take(picture, { svg, text, figures, width, height }, server) {
  if (Math.abs((width * picture.height) / height - picture.width) > Math.max(1, picture.width / picture.height)) {
    throw new Error(`${picture.drawing.name} does not have the proportions of the picture: drop it alone`);
  }
  const stated = readDrawing(svg).settings ?? {};
  const positions = positionsOf(stated);
  // What is changed in it is not known apart from it; of another program, all of it is.
  const isByHand = !stated.mode || Boolean(stated.edited);
  const result = { svg, text, ...figures, ...(await server.measure(picture.id, text)), positions, isByHand };
  const asked = { ...picture.asked, positions };
  Object.assign(picture, { result, positions, asked, mode: stated.mode ?? null, isSaved: true, status: "done" });
}

async function drawn(server, text, width, height) {
  const pixels = Math.round(width * Math.max(1, OWN_SIDE_MIN / Math.max(width, height)));
  const transparent = /<rect id="background"/.test(text) ? 0 : 1;
  const response = await server.export(text, { format: "png", width: pixels, transparent });
  return response.blob();
}
